//! Gives what fits are made of a digest, so that nothing that other code fitted is taken for its own.

use std::error::Error;
use std::path::Path;

#[path = "src/fit/sources.rs"]
mod sources;

fn main() -> Result<(), Box<dyn Error>> {
    let manifest = std::env::var("CARGO_MANIFEST_DIR")?;
    let root = Path::new(&manifest).join("..");
    for place in sources::PLACES {
        println!("cargo:rerun-if-changed={}", root.join(place).display());
    }
    println!("cargo:rustc-env=KINFOLD_CODE_FIT={}", sources::digest(&root)?);
    Ok(())
}
