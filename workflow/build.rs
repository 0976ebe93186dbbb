//! Gives every room's sources a digest, so that a result made by other code is never taken for
//! this code's result.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

/// Rooms whose code shapes a stage's result, with the variable that carries their digest.
const ROOMS: [(&str, &str); 9] = [
    ("KINFOLD_CODE_GUARD", "guard/src"),
    ("KINFOLD_CODE_OBJECT", "object/src"),
    ("KINFOLD_CODE_VIEW", "view/src"),
    ("KINFOLD_CODE_ADAPTERS", "adapters/src"),
    ("KINFOLD_CODE_MODEL", "model/src"),
    ("KINFOLD_CODE_ASSET", "asset/src"),
    ("KINFOLD_CODE_SIM_CHECK", "sim_check/src"),
    ("KINFOLD_CODE_PAGE", "page/src"),
    ("KINFOLD_CODE_STAGES", "workflow/src/stages"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let manifest = std::env::var("CARGO_MANIFEST_DIR")?;
    let root = Path::new(&manifest).join("..");
    let lock = root.join("Cargo.lock");
    println!("cargo:rerun-if-changed={}", lock.display());
    for (variable, room) in ROOMS {
        let folder = root.join(room);
        println!("cargo:rerun-if-changed={}", folder.display());
        let mut files = vec![lock.clone()];
        collect(&folder, &mut files)?;
        files.sort();
        println!("cargo:rustc-env={variable}={}", digest(&root, &files)?);
    }
    Ok(())
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Box<dyn Error>> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}

fn digest(root: &Path, files: &[PathBuf]) -> Result<String, Box<dyn Error>> {
    let mut hasher = blake3::Hasher::new();
    for file in files {
        let name = file.strip_prefix(root)?.to_string_lossy().replace('\\', "/");
        let bytes = fs::read(file)?;
        hasher.update(&(name.len() as u64).to_le_bytes());
        hasher.update(name.as_bytes());
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(&bytes);
    }
    Ok(hasher.finalize().to_hex().as_str()[..12].to_string())
}
