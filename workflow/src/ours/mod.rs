//! What is ours on disk: the marker by which a folder of ours is known, the lock that lets one
//! process at a time write into it, and the step by which a new folder takes an old one's place.

pub mod lock;
pub mod looking;
pub mod marker;
pub mod swap;

use std::fs::{self, File};
use std::io;
use std::path::Path;

pub use lock::{Holder, Lock, LockError, Turns};
pub use marker::{Kind, Marker, Whose};

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

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_link_that_stands_there_is_not_written_through() {
        let dir = tempfile::tempdir().unwrap();
        let (precious, planted) = (dir.path().join("precious"), dir.path().join("new"));
        fs::write(&precious, "mine").unwrap();
        std::os::unix::fs::symlink(&precious, &planted).unwrap();
        io::Write::write_all(&mut create(&planted).unwrap(), b"ours").unwrap();
        assert_eq!(fs::read_to_string(&precious).unwrap(), "mine");
        assert_eq!(fs::read_to_string(&planted).unwrap(), "ours");
    }
}
