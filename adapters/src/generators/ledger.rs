//! What is known of jobs across crashes: asked for, or running under a number.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::{Deserialize, Serialize};
use trace::Digest;

use super::JobHandle;
use crate::AdapterError;

/// How far a job is known to have come.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Entry {
    /// About to be asked for; whether the request arrived is not known.
    Asked,
    /// Running, or done, under this number.
    Running(JobHandle),
}

/// Remembers jobs by the digest of what was asked for.
///
/// Promise: what [`Ledger::begin`] and [`Ledger::running`] wrote survives the end of the program at
/// any moment after they return; of several callers [`Ledger::begin`] gives one the right to ask.
pub trait Ledger: Send + Sync {
    /// What is known of a job; none if it was never asked for.
    ///
    /// # Errors
    /// [`AdapterError`] when the ledger cannot be read.
    fn entry(&self, job: &Digest) -> Result<Option<Entry>, AdapterError>;

    /// Writes down that a job is about to be asked for; false if somebody already did.
    ///
    /// # Errors
    /// [`AdapterError`] when it cannot be written.
    fn begin(&self, job: &Digest) -> Result<bool, AdapterError>;

    /// Writes down the number a job got.
    ///
    /// # Errors
    /// [`AdapterError`] when it cannot be written.
    fn running(&self, job: &Digest, handle: &JobHandle) -> Result<(), AdapterError>;

    /// Forgets a job: it never arrived, or nothing can come of it any more.
    ///
    /// # Errors
    /// [`AdapterError`] when it cannot be forgotten.
    fn forget(&self, job: &Digest) -> Result<(), AdapterError>;

    /// A file that whoever does a job on this machine locks, so that it is done by one at a time;
    /// none where the ledger has no place for it.
    fn lock(&self, _job: &Digest) -> Option<PathBuf> {
        None
    }
}

/// A ledger in memory.
#[derive(Debug, Default)]
pub struct MemoryLedger(Mutex<BTreeMap<Digest, Entry>>);

impl MemoryLedger {
    fn entries(&self) -> std::sync::MutexGuard<'_, BTreeMap<Digest, Entry>> {
        self.0.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl Ledger for MemoryLedger {
    fn entry(&self, job: &Digest) -> Result<Option<Entry>, AdapterError> {
        Ok(self.entries().get(job).cloned())
    }

    fn begin(&self, job: &Digest) -> Result<bool, AdapterError> {
        let mut entries = self.entries();
        let first = !entries.contains_key(job);
        entries.entry(job.clone()).or_insert(Entry::Asked);
        Ok(first)
    }

    fn running(&self, job: &Digest, handle: &JobHandle) -> Result<(), AdapterError> {
        self.entries().insert(job.clone(), Entry::Running(handle.clone()));
        Ok(())
    }

    fn forget(&self, job: &Digest) -> Result<(), AdapterError> {
        self.entries().remove(job);
        Ok(())
    }
}

/// A ledger in a folder, one file a job.
#[derive(Clone, Debug)]
pub struct FolderLedger {
    /// The folder; made when it is first needed.
    pub folder: PathBuf,
}

impl FolderLedger {
    fn path(&self, job: &Digest) -> PathBuf {
        self.folder.join(format!("{job}.json"))
    }

    /// A file with its bytes on the disk, not yet under its name.
    fn written(&self, entry: &Entry) -> std::io::Result<tempfile::NamedTempFile> {
        std::fs::create_dir_all(&self.folder)?;
        let mut file = tempfile::NamedTempFile::new_in(&self.folder)?;
        serde_json::to_writer(&mut file, entry)?;
        file.flush()?;
        file.as_file().sync_all()?;
        Ok(file)
    }

    /// The folder's own entry reaches the disk.
    fn sync(&self) -> std::io::Result<()> {
        std::fs::File::open(&self.folder)?.sync_all()
    }
}

fn io(path: &Path) -> impl Fn(std::io::Error) -> AdapterError {
    move |source| AdapterError::Io { path: path.display().to_string(), source }
}

impl Ledger for FolderLedger {
    fn entry(&self, job: &Digest) -> Result<Option<Entry>, AdapterError> {
        let path = self.path(job);
        let text = match std::fs::read(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            read => read.map_err(io(&path))?,
        };
        let entry = serde_json::from_slice(&text);
        entry.map(Some).map_err(|e| AdapterError::Format {
            path: path.display().to_string(),
            expected: "a job written down by kinfold",
            found: e.to_string(),
        })
    }

    fn begin(&self, job: &Digest) -> Result<bool, AdapterError> {
        let path = self.path(job);
        let file = self.written(&Entry::Asked).map_err(io(&path))?;
        match file.persist_noclobber(&path) {
            Err(e) if e.error.kind() == ErrorKind::AlreadyExists => return Ok(false),
            persisted => persisted.map_err(|e| io(&path)(e.error))?,
        };
        self.sync().map_err(io(&path))?;
        Ok(true)
    }

    fn running(&self, job: &Digest, handle: &JobHandle) -> Result<(), AdapterError> {
        let path = self.path(job);
        let file = self.written(&Entry::Running(handle.clone())).map_err(io(&path))?;
        file.persist(&path).map_err(|e| io(&path)(e.error))?;
        self.sync().map_err(io(&path))
    }

    fn forget(&self, job: &Digest) -> Result<(), AdapterError> {
        let path = self.path(job);
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(()),
            removed => removed.map_err(io(&path)),
        }
    }

    fn lock(&self, job: &Digest) -> Option<PathBuf> {
        Some(self.folder.join(format!("{job}.lock")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keeps_its_promise(ledger: &dyn Ledger) {
        let job = Digest::of(b"a photo and a seed");
        let handle = JobHandle::new("17");
        assert_eq!(ledger.entry(&job).unwrap(), None);
        assert!(ledger.begin(&job).unwrap());
        assert!(!ledger.begin(&job).unwrap(), "one caller may ask");
        assert_eq!(ledger.entry(&job).unwrap(), Some(Entry::Asked));
        ledger.running(&job, &handle).unwrap();
        assert!(!ledger.begin(&job).unwrap());
        assert_eq!(ledger.entry(&job).unwrap(), Some(Entry::Running(handle)));
        ledger.forget(&job).unwrap();
        ledger.forget(&job).unwrap();
        assert!(ledger.begin(&job).unwrap());
    }

    #[test]
    fn both_ledgers_keep_the_promise() {
        let dir = tempfile::tempdir().unwrap();
        keeps_its_promise(&MemoryLedger::default());
        keeps_its_promise(&FolderLedger { folder: dir.path().join("jobs") });
    }

    #[test]
    fn a_damaged_ledger_is_told_and_not_taken_for_an_empty_one() {
        let dir = tempfile::tempdir().unwrap();
        let ledger = FolderLedger { folder: dir.path().into() };
        let job = Digest::of(b"x");
        std::fs::write(ledger.path(&job), "{\"runn").unwrap();
        assert!(ledger.entry(&job).unwrap_err().to_string().contains("expected a job"));
    }
}
