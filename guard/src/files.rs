//! Files from outside: regular, bounded, and never waited for.

use std::io::Read as _;
use std::path::Path;

use cap_std::ambient_authority;
#[cfg(unix)]
use cap_std::fs::OpenOptionsExt as _;
use cap_std::fs::{File, OpenOptions};

/// Why a file was not read. It names no path: whoever asked knows which.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// Nothing stands there, or it may not be opened.
    #[error("cannot be opened: {0}")]
    Open(std::io::Error),
    /// A folder, a pipe, a socket or a device.
    #[error("is no regular file")]
    NotRegular,
    /// It is larger than a file of its kind may be.
    #[error("has more than {most} bytes, the most that is read")]
    TooLarge {
        /// Most bytes.
        most: u64,
    },
    /// The disk.
    #[error("cannot be read: {0}")]
    Read(std::io::Error),
}

/// Reads a file that a person named, up to `most` bytes. A link is followed, since the person
/// named it; what it leads to must be a regular file. A pipe or a device is refused, not waited for.
///
/// # Errors
/// [`Refused`].
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>, Refused> {
    let mut options = OpenOptions::new();
    options.read(true);
    // A pipe without a writer would be waited for.
    #[cfg(unix)]
    options.custom_flags(NONBLOCK);
    let file = File::open_ambient_with(path, &options, ambient_authority());
    read_whole(file.map_err(Refused::Open)?, most)
}

/// `O_NONBLOCK`, as the C library of this system defines it.
#[cfg(target_os = "linux")]
const NONBLOCK: i32 = 0o4000;
#[cfg(all(unix, not(target_os = "linux")))]
const NONBLOCK: i32 = 0x4;

fn read_whole(file: File, most: u64) -> Result<Vec<u8>, Refused> {
    let about = file.metadata().map_err(Refused::Read)?;
    if !about.is_file() {
        return Err(Refused::NotRegular);
    }
    if about.len() > most {
        return Err(Refused::TooLarge { most });
    }
    let mut bytes = Vec::with_capacity(usize::try_from(about.len()).unwrap_or_default());
    // It may grow while it is read.
    file.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(Refused::Read)?;
    if bytes.len() as u64 > most {
        return Err(Refused::TooLarge { most });
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_and_a_large_file_are_refused_and_a_small_one_is_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        std::fs::write(&path, [7; 100]).unwrap();
        assert_eq!(read(&path, 100).unwrap(), [7; 100]);
        assert!(matches!(read(&path, 99), Err(Refused::TooLarge { most: 99 })));
        assert!(matches!(read(dir.path(), 99), Err(Refused::NotRegular)));
        assert!(matches!(read(&dir.path().join("b"), 99), Err(Refused::Open(_))));
    }
}
