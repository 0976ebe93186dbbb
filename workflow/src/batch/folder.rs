//! The folder of a batch: one folder per accepted asset, the rest in quarantine, a ledger beside.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use super::BatchError;
use super::ledger::{self, Ledger};
use crate::dag::store::sync_folder;

/// Accepted assets, by id.
pub const ASSETS: &str = "assets";
/// What was made and not accepted, and the traces of what failed, by id.
pub const QUARANTINE: &str = "quarantine";
/// What is being made.
const UNFINISHED: &str = "unfinished";

/// The folder of a batch.
///
/// Open for writing it holds the lock, which the operating system frees when the process ends,
/// however it ends.
#[derive(Debug)]
pub struct BatchFolder {
    root: PathBuf,
    _lock: File,
}

impl BatchFolder {
    /// Opens or creates the folder, alone, and its ledger.
    ///
    /// # Errors
    /// [`BatchError`] when another batch has it, when it holds something else, or the disk refuses.
    pub fn open(root: &Path) -> Result<(Self, Ledger), BatchError> {
        let ledger = root.join(ledger::FILE);
        let strange = !ledger.exists() && fs::read_dir(root).is_ok_and(|mut d| d.next().is_some());
        if strange {
            let found = "it holds other files, and no ledger of a batch".into();
            return Err(BatchError::Folder { path: root.to_path_buf(), found });
        }
        for folder in [ASSETS, QUARANTINE, UNFINISHED] {
            let folder = root.join(folder);
            fs::create_dir_all(&folder).map_err(io_failed("create", &folder))?;
        }
        let lock = take_lock(root)?;
        let ledger = Ledger::open(&ledger)?;
        Ok((Self { root: root.to_path_buf(), _lock: lock }, ledger))
    }

    /// Its path.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// An empty folder to make an item's asset in.
    ///
    /// # Errors
    /// [`BatchError`] when the disk refuses.
    pub fn unfinished(&self, id: &str) -> Result<PathBuf, BatchError> {
        let folder = self.root.join(UNFINISHED).join(id);
        remove(&folder)?;
        Ok(folder)
    }

    /// Moves what was made into its place, instead of whatever an earlier try left there.
    ///
    /// # Errors
    /// [`BatchError`] when the disk refuses.
    pub fn place(&self, id: &str, accepted: bool) -> Result<PathBuf, BatchError> {
        let (here, there) = if accepted { (ASSETS, QUARANTINE) } else { (QUARANTINE, ASSETS) };
        let from = self.root.join(UNFINISHED).join(id);
        let to = self.root.join(here).join(id);
        remove(&self.root.join(there).join(id))?;
        remove(&to)?;
        fs::rename(&from, &to).map_err(io_failed("move into place", &to))?;
        let parent = self.root.join(here);
        sync_folder(&parent).map_err(io_failed("sync", &parent))?;
        Ok(to)
    }

    /// Removes what was being made of an item.
    ///
    /// # Errors
    /// [`BatchError`] when the disk refuses.
    pub fn put_down(&self, id: &str) -> Result<(), BatchError> {
        remove(&self.root.join(UNFINISHED).join(id))
    }
}

fn take_lock(root: &Path) -> Result<File, BatchError> {
    let path = root.join("lock");
    let file = File::options().create(true).truncate(false).write(true).open(&path);
    let file = file.map_err(io_failed("open", &path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => {
            let found = "another batch is at work in it".into();
            Err(BatchError::Folder { path: root.to_path_buf(), found })
        }
        Err(TryLockError::Error(e)) => Err(io_failed("lock", &path)(e)),
    }
}

fn remove(folder: &Path) -> Result<(), BatchError> {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(io_failed("remove", folder)(e)),
        _ => Ok(()),
    }
}

/// An error of the disk about a file of the batch.
pub(super) fn io_failed(
    doing: &'static str,
    path: &Path,
) -> impl FnOnce(io::Error) -> BatchError + use<> {
    let path = path.to_path_buf();
    move |source| BatchError::Io { doing, path, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_made_lies_in_one_place_only() {
        let dir = tempfile::tempdir().unwrap();
        let (folder, _ledger) = BatchFolder::open(dir.path()).unwrap();
        for accepted in [false, true, true, false] {
            let made = folder.unfinished("lid").unwrap();
            fs::create_dir(&made).unwrap();
            fs::write(made.join("asset.urdf"), accepted.to_string()).unwrap();
            let placed = folder.place("lid", accepted).unwrap();
            assert_eq!(
                fs::read_to_string(placed.join("asset.urdf")).unwrap(),
                accepted.to_string()
            );
            let places = [ASSETS, QUARANTINE, UNFINISHED].map(|f| dir.path().join(f).join("lid"));
            assert_eq!(places.map(|p| p.exists()), [accepted, !accepted, false]);
        }
    }

    #[test]
    fn a_second_batch_in_one_folder_is_refused_until_the_first_is_gone() {
        let dir = tempfile::tempdir().unwrap();
        let first = BatchFolder::open(dir.path()).unwrap();
        let error = BatchFolder::open(dir.path()).unwrap_err().to_string();
        assert!(error.ends_with("another batch is at work in it"), "{error}");
        drop(first);
        BatchFolder::open(dir.path()).unwrap();
    }

    #[test]
    fn somebody_elses_folder_is_left_alone() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("thesis.tex"), "mine").unwrap();
        let error = BatchFolder::open(dir.path()).unwrap_err().to_string();
        assert!(error.contains("it holds other files"), "{error}");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }
}
