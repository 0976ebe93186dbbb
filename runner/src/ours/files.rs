//! Files as we write them: new ones only, whole, and known to the disk.
//!
//! ```
//! use runner::ours::files;
//!
//! let dir = tempfile::tempdir()?;
//! let path = dir.path().join("lid.txt");
//! files::write_synced(&path, b"a lid")?;
//! files::sync_folder(dir.path())?;
//! assert_eq!(std::fs::read(&path)?, b"a lid");
//! # Ok::<(), std::io::Error>(())
//! ```

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::Path;

/// A new file of that name, whatever file stood there before. A link that stands there is taken
/// away; what it leads to is not touched.
///
/// # Errors
/// What the operating system says.
pub fn create(path: &Path) -> io::Result<File> {
    let new = || File::options().write(true).create_new(true).open(path);
    match new() {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {
            fs::remove_file(path)?;
            new()
        }
        created => created,
    }
}

/// A name as it may be shown in a message.
pub fn name(path: &Path) -> String {
    guard::text::shown(&path.display().to_string()).into_owned()
}

/// Writes a new file, whatever file stood there before, and waits until the disk has it. What a link
/// leads to that stood there is not touched.
///
/// # Errors
/// What the operating system says.
pub fn write_synced(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Waits until the disk knows the names in a folder.
///
/// # Errors
/// What the operating system says.
pub fn sync_folder(path: &Path) -> io::Result<()> {
    File::open(path)?.sync_all()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_link_that_stands_there_is_not_written_through() {
        let dir = tempfile::tempdir().unwrap();
        let (precious, planted) = (dir.path().join("precious"), dir.path().join("new"));
        fs::write(&precious, "mine").unwrap();
        std::os::unix::fs::symlink(&precious, &planted).unwrap();
        create(&planted).unwrap().write_all(b"ours").unwrap();
        assert_eq!(fs::read_to_string(&precious).unwrap(), "mine");
        assert_eq!(fs::read_to_string(&planted).unwrap(), "ours");
    }
}
