//! Folders to work in that do not outlive the program, even where it ends all of a sudden.
//!
//! ```
//! let folder = runner::ours::scratch::folder()?;
//! let place = folder.path().to_path_buf();
//! assert!(place.is_dir());
//! drop(folder);
//! assert!(!place.exists());
//! # Ok::<(), std::io::Error>(())
//! ```

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard};

use tempfile::TempDir;

/// Folders that must not outlive the program.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A folder to work in that is gone when it is let go, and when the program [removes all](remove_all) of
/// them before it ends itself.
///
/// # Errors
/// What the disk says.
pub fn folder() -> std::io::Result<TempDir> {
    let folder = tempfile::Builder::new().prefix("kinfold-").tempdir()?;
    folders().push(folder.path().to_path_buf());
    Ok(folder)
}

/// Removes all of them, for who is about to end the program without letting them go.
pub fn remove_all() {
    remove(&mut folders());
}

fn remove(folders: &mut Vec<PathBuf>) {
    for folder in folders.drain(..) {
        // It lies in the system's own place for such folders, where others tidy up, too.
        let _ = std::fs::remove_dir_all(folder);
    }
}

fn folders() -> MutexGuard<'static, Vec<PathBuf>> {
    FOLDERS.lock().unwrap_or_else(|e| e.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_was_not_let_go_goes_with_the_program() {
        let kept = folder().unwrap().keep();
        std::fs::write(kept.join("copy.sqlite"), "a copy").unwrap();
        assert!(folders().contains(&kept));
        remove(&mut vec![kept.clone()]);
        assert!(!kept.exists());
    }
}
