//! Where the shared real cases lie, if they are there at all.

use std::path::{Path, PathBuf};

/// The folder named by `KINFOLD_SHARED`, or `../shared` beside the repository; `None`, said loudly,
/// where there is none.
pub fn shared() -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared");
    let folder = std::env::var_os("KINFOLD_SHARED").map_or(PathBuf::from(default), PathBuf::from);
    if folder.join("data").is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED: no shared cases at {} (set KINFOLD_SHARED)", folder.display());
    None
}

/// The development cases, sorted by name.
pub fn dev_cases() -> Option<Vec<PathBuf>> {
    let folder = shared()?.join("data/cases/dev");
    let entries = std::fs::read_dir(folder).ok()?;
    let mut cases: Vec<_> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    cases.sort();
    Some(cases)
}

/// The photo of a case: the real one where there is one, else the plain render.
pub fn photo(case: &std::path::Path) -> Option<PathBuf> {
    let names = ["image.png", "image.jpg", "image.jpeg", "image.webp", "render.png"];
    names.iter().map(|n| case.join(n)).find(|p| p.is_file())
}

/// The Python that has the simulators: `KINFOLD_PYTHON`, or the repository's `.venv`.
pub fn python() -> Option<PathBuf> {
    python_with("mujoco, pybullet, pinocchio, mcap")
}

/// The same Python, if it has some modules; said loudly where it has not.
pub fn python_with(modules: &str) -> Option<PathBuf> {
    python_at("KINFOLD_PYTHON", ".venv", modules)
}

/// The Python that has NVIDIA's validator and converter, which bring a USD of their own:
/// `KINFOLD_PYTHON_USD`, or the repository's `.venv-usd`.
pub fn python_of_usd() -> Option<PathBuf> {
    let modules = "urdf_usd_converter, usd_validation_nvidia";
    python_at("KINFOLD_PYTHON_USD", ".venv-usd", modules)
}

fn python_at(variable: &str, folder: &str, modules: &str) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let default = root.join(folder).join("bin/python");
    let python = std::env::var_os(variable).map_or(default, PathBuf::from);
    let mut ready = std::process::Command::new(&python);
    ready.args(["-c", &format!("import {modules}")]);
    if ready.output().is_ok_and(|o| o.status.success()) {
        return Some(python);
    }
    eprintln!("SKIPPED: no Python with {modules} at {}", python.display());
    None
}
