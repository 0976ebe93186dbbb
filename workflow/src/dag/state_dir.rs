//! A state directory: store, journal and the lock that keeps two runners apart.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use trace::Digest;

use super::depot::{Depot, DepotError};
use super::journal::{Committed, Journal, JournalError};
use super::store::{Found, Store, StoreError};

/// A folder with `run.sqlite`, `cas/`, `tmp/` and `lock`.
///
/// Open for writing it holds the lock, which the operating system frees when the process ends,
/// however it ends: no lock is ever stale.
pub struct StateDir {
    root: PathBuf,
    /// Bytes by digest.
    pub store: Store,
    /// Results by key.
    pub journal: Journal,
    depot: Option<Arc<dyn Depot>>,
    claims: Mutex<BTreeSet<Digest>>,
    _lock: Option<File>,
}

/// Why a state directory cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// The disk.
    #[error("state directory {}: cannot {doing}: {source}", path.display())]
    Io {
        /// What was tried.
        doing: &'static str,
        /// The folder or file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// Another runner holds the lock.
    #[error("state directory {} is in use by another run", .0.display())]
    InUse(PathBuf),
    /// The journal.
    #[error("state directory {}: {source}", path.display())]
    Journal {
        /// The folder.
        path: PathBuf,
        /// What the journal said.
        source: JournalError,
    },
    /// The store.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The store that several machines share.
    #[error(transparent)]
    Depot(#[from] DepotError),
}

impl StateDir {
    /// Opens or creates the folder, alone.
    ///
    /// # Errors
    /// [`StateError::InUse`] while another runner has it, others when the disk refuses.
    pub fn open(root: &Path) -> Result<Self, StateError> {
        fs::create_dir_all(root).map_err(io_failed("create", root))?;
        let lock = take_lock(root)?;
        let this = Self::parts(root, Journal::open(&root.join("run.sqlite")), Some(lock))?;
        this.sweep()?;
        Ok(this)
    }

    /// Opens the folder for looking only, `None` if there is no record yet. Takes no lock and
    /// changes nothing.
    ///
    /// # Errors
    /// [`StateError`] when the record cannot be read.
    pub fn open_to_read(root: &Path) -> Result<Option<Self>, StateError> {
        let record = root.join("run.sqlite");
        if !record.exists() {
            return Ok(None);
        }
        Self::parts(root, Journal::open_to_read(&record), None).map(Some)
    }

    fn parts(
        root: &Path,
        journal: Result<Journal, JournalError>,
        lock: Option<File>,
    ) -> Result<Self, StateError> {
        let path = root.to_path_buf();
        let journal = journal.map_err(|source| StateError::Journal { path, source })?;
        let store = Store::new(root.join("cas"), root.join("tmp"));
        Ok(Self {
            root: root.to_path_buf(),
            store,
            journal,
            depot: None,
            claims: Mutex::default(),
            _lock: lock,
        })
    }

    /// The same with a store that other machines share.
    #[must_use]
    pub fn sharing(mut self, depot: Arc<dyn Depot>) -> Self {
        self.depot = Some(depot);
        self
    }

    /// Removes what a killed run left unfinished.
    fn sweep(&self) -> Result<(), StateError> {
        let scratch = self.scratch();
        match fs::remove_dir_all(&scratch) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => {
                return Err(io_failed("empty", &scratch)(e));
            }
            _ => {}
        }
        fs::create_dir_all(&scratch).map_err(io_failed("create", &scratch))
    }

    /// A folder for unfinished files, emptied by the next run.
    pub fn scratch(&self) -> PathBuf {
        self.root.join("tmp")
    }

    /// The result under a key, with its bytes, if both journal and store have it whole, or the
    /// shared store has.
    ///
    /// # Errors
    /// [`StateError`] when a disk refuses to say.
    pub fn recall(&self, key: &Digest) -> Result<Recall, StateError> {
        let committed = self.journal.recall(key).map_err(self.journal_failed())?;
        let own = match committed {
            None => Recall::Unknown,
            Some(committed) => match self.store.get(&committed.output)? {
                Found::Whole(bytes) => return Ok(Recall::Known(committed, bytes)),
                Found::Absent => Recall::Lost("its bytes are missing from the store"),
                Found::Damaged => Recall::Lost("its bytes in the store are damaged"),
            },
        };
        Ok(self.recall_shared(key)?.unwrap_or(own))
    }

    fn recall_shared(&self, key: &Digest) -> Result<Option<Recall>, StateError> {
        let Some(depot) = &self.depot else { return Ok(None) };
        let Some(committed) = depot.result(key)? else { return Ok(None) };
        Ok(Some(match depot.blob(&committed.output)? {
            Found::Whole(bytes) => {
                self.store.put(&bytes)?;
                Recall::Known(committed, bytes)
            }
            Found::Absent => Recall::Lost("its bytes are missing from the shared store"),
            Found::Damaged => Recall::Lost("its bytes in the shared store are damaged"),
        }))
    }

    /// Claims the work under a key for one run of this process; false while another has it.
    pub fn claim(&self, key: &Digest) -> bool {
        self.claims.lock().unwrap_or_else(|e| e.into_inner()).insert(key.clone())
    }

    /// Gives a claim up: the work is done, or will not be.
    pub fn release(&self, key: &Digest) {
        self.claims.lock().unwrap_or_else(|e| e.into_inner()).remove(key);
    }

    /// Brings a result to the shared store, if there is one; returns the result that stands there
    /// with its bytes.
    ///
    /// # Errors
    /// [`StateError`] when the shared store refuses.
    pub fn share(
        &self,
        key: &Digest,
        own: Committed,
        bytes: Vec<u8>,
    ) -> Result<(Committed, Vec<u8>), StateError> {
        let Some(depot) = &self.depot else { return Ok((own, bytes)) };
        depot.put_blob(&own.output, &bytes)?;
        let stands = depot.put_result(key, &own)?;
        if stands.output == own.output {
            return Ok((stands, bytes));
        }
        match depot.blob(&stands.output)? {
            Found::Whole(theirs) => {
                self.store.put(&theirs)?;
                Ok((stands, theirs))
            }
            Found::Absent | Found::Damaged => Ok((own, bytes)),
        }
    }

    pub(crate) fn journal_failed(&self) -> impl FnOnce(JournalError) -> StateError {
        let path = self.root.clone();
        move |source| StateError::Journal { path, source }
    }
}

/// What is known under a key.
#[derive(Debug)]
pub enum Recall {
    /// Nothing was ever committed.
    Unknown,
    /// Something was committed, but its bytes are gone; the reason.
    Lost(&'static str),
    /// The result and its bytes.
    Known(Committed, Vec<u8>),
}

fn take_lock(root: &Path) -> Result<File, StateError> {
    let path = root.join("lock");
    let file = File::options().create(true).truncate(false).write(true).open(&path);
    let file = file.map_err(io_failed("open the lock of", &path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(StateError::InUse(root.to_path_buf())),
        Err(TryLockError::Error(e)) => Err(io_failed("lock", &path)(e)),
    }
}

fn io_failed(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> StateError {
    let path = path.to_path_buf();
    move |source| StateError::Io { doing, path, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_runner_is_refused_until_the_first_is_gone() {
        let dir = tempfile::tempdir().unwrap();
        let first = StateDir::open(dir.path()).unwrap();
        assert!(matches!(StateDir::open(dir.path()), Err(StateError::InUse(_))));
        assert!(StateDir::open_to_read(dir.path()).unwrap().is_some(), "looking is allowed");
        drop(first);
        StateDir::open(dir.path()).unwrap();
    }

    #[test]
    fn looking_creates_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("state");
        assert!(StateDir::open_to_read(&root).unwrap().is_none());
        assert!(!root.exists());
    }

    #[test]
    fn unfinished_files_of_a_killed_run_are_swept_away() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("tmp")).unwrap();
        fs::write(dir.path().join("tmp/half.partial"), "ha").unwrap();
        let state = StateDir::open(dir.path()).unwrap();
        assert_eq!(fs::read_dir(state.scratch()).unwrap().count(), 0);
    }
}
