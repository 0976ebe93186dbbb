//! Writes the objects of `examples/`: mesh, condition and a photo-like render of each family.
//!
//! `cargo run --release -p kinfold-training --example write_examples -- examples`

use std::error::Error;
use std::path::Path;

use training::procedural::{FAMILIES, Made};
use view::{Camera, Paint};

/// The families that stand in `examples/`.
const SHOWN: [&str; 3] = ["cabinet", "pedal_bin", "cart"];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: write_examples FOLDER")?;
    for family in FAMILIES.iter().filter(|f| SHOWN.contains(&f.name)) {
        let folder = Path::new(&folder).join(family.name);
        std::fs::create_dir_all(&folder)?;
        let made = family.make()?;
        std::fs::write(folder.join("mesh.glb"), object::glb::write(made.object.mesh()))?;
        let condition = serde_json::to_string_pretty(&made.condition)? + "\n";
        std::fs::write(folder.join("condition.json"), condition)?;
        std::fs::write(folder.join("photo.png"), photo(&made)?)?;
    }
    Ok(())
}

/// The object as a photographer would show it: from the front right, a little from above.
fn photo(made: &Made) -> Result<Vec<u8>, Box<dyn Error>> {
    let mesh = made.object.mesh();
    let bounds = mesh.bounds();
    let direction = object::DVec3::new(0.55, -1.0, 0.5).normalize();
    let camera = Camera {
        eye: bounds.centre() + direction * bounds.diagonal() * 1.7,
        target: bounds.centre(),
        up: object::DVec3::Z,
        fov_y: 0.62,
        size: [768, 768],
    };
    Ok(view::encode_png(&view::render(mesh, &Paint::Surface, &camera))?)
}
