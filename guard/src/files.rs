//! Files from outside: regular, bounded, and never waited for.

use std::io::{self, Read};
use std::path::Path;
use std::time::Duration;

use cap_std::ambient_authority;
#[cfg(unix)]
use cap_std::fs::OpenOptionsExt as _;
use cap_std::fs::{File, OpenOptions};

/// Why a file or a folder was not read. It names no path: whoever asked knows which.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// Nothing stands there, or it may not be opened.
    #[error("cannot be opened: {0}")]
    Open(io::Error),
    /// A folder, a pipe, a socket or a device.
    #[error("is no regular file")]
    NotRegular,
    /// A link, an absolute path or `..` leads to where nothing may be read.
    #[error("leads out of the folder, where nothing is read")]
    Outside,
    /// It is larger than a file of its kind may be.
    #[error("has more than {most} bytes, the most that is read")]
    TooLarge {
        /// Most bytes.
        most: u64,
    },
    /// All files of a folder together are larger than they may be.
    #[error("would make it more than {most} bytes in all, the most that is read of a folder")]
    TooMuch {
        /// Most bytes.
        most: u64,
    },
    /// A folder holds too much.
    #[error("holds more than {most} files and folders, the most that is looked through")]
    TooMany {
        /// Most entries.
        most: usize,
    },
    /// Folders in folders.
    #[error("holds folders more than {most} deep, the deepest that is looked into")]
    TooDeep {
        /// Most levels.
        most: usize,
    },
    /// It took too long.
    #[error("was not read to its end after {} s, the longest it may take", most.as_secs_f64())]
    TooLong {
        /// The longest time.
        most: Duration,
    },
    /// The disk.
    #[error("cannot be read: {0}")]
    Read(io::Error),
}

impl Refused {
    /// What a reader of this room said, however often it was wrapped.
    pub fn of(error: io::Error) -> Self {
        if error.get_ref().is_some_and(|inner| inner.is::<Self>()) {
            let inner = error.into_inner().and_then(|inner| inner.downcast::<Self>().ok());
            return inner.map_or(Self::NotRegular, |inner| *inner);
        }
        Self::Read(error)
    }

    /// Whether nothing stands there at all.
    pub fn is_absence(&self) -> bool {
        matches!(self, Self::Open(e) if e.kind() == io::ErrorKind::NotFound)
    }
}

/// Reads a file that a person named, up to `most` bytes. A link is followed, since the person
/// named it; what it leads to must be a regular file. A pipe or a device is refused, not waited for.
///
/// # Errors
/// [`Refused`].
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>, Refused> {
    let (file, length) = open(path, most)?;
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or_default());
    // It may grow while it is read.
    file.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(Refused::Read)?;
    if bytes.len() as u64 > most {
        return Err(Refused::TooLarge { most });
    }
    Ok(bytes)
}

/// Opens a file that a person named, as [`read`] does, for somebody who reads it in pieces.
///
/// # Errors
/// [`Refused`].
pub fn open_file(path: &Path, most: u64) -> Result<std::fs::File, Refused> {
    open(path, most).map(|(file, _)| file.into_std())
}

fn open(path: &Path, most: u64) -> Result<(File, u64), Refused> {
    // To open a device may be to do something with it.
    if !std::fs::metadata(path).map_err(Refused::Open)?.is_file() {
        return Err(Refused::NotRegular);
    }
    let file = File::open_ambient_with(path, &reading(), ambient_authority());
    let file = file.map_err(Refused::Open)?;
    let length = regular(&file, most)?;
    Ok((file, length))
}

/// The length of an open file, if it is a regular one and not too long.
pub(crate) fn regular(file: &File, most: u64) -> Result<u64, Refused> {
    let about = file.metadata().map_err(Refused::Read)?;
    if !about.is_file() {
        return Err(Refused::NotRegular);
    }
    if about.len() > most {
        return Err(Refused::TooLarge { most });
    }
    Ok(about.len())
}

/// To read, and never to wait: a pipe without a writer would be waited for.
pub(crate) fn reading() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    options.custom_flags(NONBLOCK);
    options
}

/// `O_NONBLOCK`, as the C library of this system defines it.
#[cfg(target_os = "linux")]
const NONBLOCK: i32 = 0o4000;
#[cfg(all(unix, not(target_os = "linux")))]
const NONBLOCK: i32 = 0x4;

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
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

    #[cfg(unix)]
    #[test]
    fn a_pipe_and_a_device_are_refused_at_once_even_through_a_link() {
        let dir = tempfile::tempdir().unwrap();
        let pipe = dir.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let link = dir.path().join("link");
        std::os::unix::fs::symlink(&pipe, &link).unwrap();
        for path in [pipe.as_path(), link.as_path(), Path::new("/dev/zero")] {
            assert!(matches!(read(path, 99), Err(Refused::NotRegular)), "{}", path.display());
        }
    }

    #[test]
    fn a_terabyte_of_nothing_is_refused_by_its_length() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("sparse");
        std::fs::File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let refused = read(&path, 1 << 30).unwrap_err();
        let words = "has more than 1073741824 bytes, the most that is read";
        assert_eq!(refused.to_string(), words);
    }
}
