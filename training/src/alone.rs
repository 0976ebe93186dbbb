//! One run at a time in a folder.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;

/// Keeps other runs out of a folder until it is dropped or the process ends.
#[derive(Debug)]
pub(crate) struct Alone(File);

impl Alone {
    /// The folder for this run alone; nothing where another is at work in it.
    ///
    /// # Errors
    /// [`io::Error`] where the folder cannot be written to, or not be locked.
    pub(crate) fn in_folder(out: &Path) -> io::Result<Option<Self>> {
        let file = File::create(out.join("lock"))?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self(file))),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(error)) => Err(error),
        }
    }
}

impl Drop for Alone {
    /// Said aloud: a program that another thread has just started holds the open file, too, for a moment,
    /// and with it a lock that is only closed.
    fn drop(&mut self) {
        let _ = self.0.unlock();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_free_again_as_soon_as_its_run_ended() {
        let folder = tempfile::tempdir().unwrap();
        let first = Alone::in_folder(folder.path()).unwrap().unwrap();
        assert!(Alone::in_folder(folder.path()).unwrap().is_none());
        // What a child of ours holds until it becomes another program.
        let held = first.0.try_clone().unwrap();
        drop(first);
        assert!(Alone::in_folder(folder.path()).unwrap().is_some(), "the child holds the lock");
        drop(held);
    }
}
