//! The sources that a fit follows from, as one digest: what a program was built from, and what a checkout
//! has, can be told apart.

use std::path::{Path, PathBuf};
use std::{fs, io};

/// Files and folders of the repository that a fit follows from; what ships learned is not among them.
pub(crate) const PLACES: [&str; 4] = ["Cargo.lock", "object/src", "model/src", "training/src"];

/// The digest of all [`PLACES`] of a checkout, by what they are called and what is in them.
pub(crate) fn digest(root: &Path) -> io::Result<String> {
    let mut files = Vec::new();
    for place in PLACES {
        collect(&root.join(place), &mut files)?;
    }
    files.sort();
    let mut hasher = blake3::Hasher::new();
    for file in &files {
        let name = file.strip_prefix(root).map_err(io::Error::other)?;
        let name = name.to_string_lossy().replace('\\', "/");
        for bytes in [name.into_bytes(), fs::read(file)?] {
            hasher.update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);
        }
    }
    Ok(hasher.finalize().to_hex().to_string())
}

fn collect(place: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    if !place.is_dir() {
        files.push(place.to_path_buf());
        return Ok(());
    }
    for entry in fs::read_dir(place)? {
        collect(&entry?.path(), files)?;
    }
    Ok(())
}
