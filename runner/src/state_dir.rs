//! A state directory: store, journal and the lock that keeps two runners apart.
//!
//! ```
//! use runner::{StateDir, StateError};
//!
//! let dir = tempfile::tempdir()?;
//! let state = StateDir::open(dir.path())?;
//! let digest = state.store.put(b"a lid")?;
//! assert!(state.store.path(&digest).is_file());
//! assert!(matches!(StateDir::open(dir.path()), Err(StateError::Lock { .. })));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use trace::Digest;

use super::depot::{Depot, DepotError};
use super::journal::{Committed, Journal, JournalError};
use super::ours::lock::After;
use super::ours::marker::{self, Saved, Whose};
use super::ours::{Kind, Lock, LockError, Marker, Turns};
use super::store::{Found, Store, StoreError};

/// The record of runs.
const RECORD: &str = "run.sqlite";
/// What 0.1.0 put into a state directory, which had no marker.
const OF_OLD: [&str; 9] = [
    RECORD,
    "run.sqlite-wal",
    "run.sqlite-shm",
    "lock",
    "cas",
    "tmp",
    "calls",
    "jobs",
    "spent.jsonl",
];
/// Folders of ours in a state directory that are written into.
const FOLDERS: [&str; 3] = ["cas", "calls", "jobs"];
/// How the names of passing folders in `tmp/` begin; six letters and digits follow.
const PASSING: [&str; 2] = ["check-", "command-"];

/// A folder with a marker, `run.sqlite`, `cas/`, `tmp/` and `lock`.
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
    _lock: Option<Lock>,
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
    /// It holds files, and neither our marker nor a record of runs.
    #[error(
        "{} holds `{found}` and no marker of ours: it is no state directory of kinfold",
        crate::ours::name(path)
    )]
    NotOurs {
        /// The folder.
        path: PathBuf,
        /// What was found.
        found: String,
    },
    /// There is none, where one must be.
    #[error("{}: expected a state directory of kinfold, found none", crate::ours::name(.0))]
    Absent(PathBuf),
    /// Another runner holds the lock.
    #[error("state directory {} {source}", crate::ours::name(path))]
    Lock {
        /// The folder.
        path: PathBuf,
        /// Who.
        source: LockError,
    },
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
    /// Opens or creates the folder, alone, now or not at all.
    ///
    /// # Errors
    /// As [`StateDir::open_in_turn`].
    pub fn open(root: &Path) -> Result<Self, StateError> {
        Self::open_in_turn(root, Turns::AT_ONCE)
    }

    /// Opens or creates the folder, alone, when it is our turn.
    ///
    /// # Errors
    /// [`StateError::NotOurs`] before anything in it changes, [`StateError::Lock`] while another
    /// runner has it and nobody is to wait, others when the disk refuses.
    pub fn open_in_turn(root: &Path, turns: Turns) -> Result<Self, StateError> {
        claim(root)?;
        let what = format!("state directory {}", crate::ours::name(root));
        let lock = Lock::take(&root.join("lock"), After::Stays, turns, &what);
        let lock = lock.map_err(|source| StateError::Lock { path: root.to_path_buf(), source })?;
        let this = Self::parts(root, Journal::open(&root.join(RECORD)), Some(lock))?;
        this.sweep()?;
        Ok(this)
    }

    /// Opens a folder that must be there already, alone, when it is our turn.
    ///
    /// # Errors
    /// [`StateError::Absent`] where there is none, others as [`StateDir::open_in_turn`].
    pub fn open_existing(root: &Path, turns: Turns) -> Result<Self, StateError> {
        if !is_there(root)? {
            return Err(StateError::Absent(root.to_path_buf()));
        }
        Self::open_in_turn(root, turns)
    }

    /// Opens the folder for looking only, `None` if there is no record yet. Takes no lock and
    /// changes nothing.
    ///
    /// # Errors
    /// [`StateError`] when it is not ours or the record cannot be read.
    pub fn open_to_read(root: &Path) -> Result<Option<Self>, StateError> {
        if !is_there(root)? || fs::symlink_metadata(root.join(RECORD)).is_err() {
            return Ok(None);
        }
        Self::parts(root, Journal::open_to_read(&root.join(RECORD)), None).map(Some)
    }

    fn parts(
        root: &Path,
        journal: Result<Journal, JournalError>,
        lock: Option<Lock>,
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

    /// Removes what a killed run left unfinished: files of our own names in `tmp/`, and nothing
    /// through a link.
    fn sweep(&self) -> Result<(), StateError> {
        let scratch = self.scratch();
        fs::create_dir_all(&scratch).map_err(io_failed("create", &scratch))?;
        let about = fs::symlink_metadata(&scratch).map_err(io_failed("look into", &scratch))?;
        if !about.is_dir() {
            return Ok(());
        }
        for entry in fs::read_dir(&scratch).map_err(io_failed("look into", &scratch))? {
            let entry = entry.map_err(io_failed("look into", &scratch))?;
            let kind = entry.file_type().map_err(io_failed("look into", &scratch))?;
            let (name, path) = (entry.file_name(), entry.path());
            let name = name.to_str().unwrap_or_default();
            let removed = match (kind.is_dir(), kind.is_file()) {
                (true, _) if is_passing(name) => fs::remove_dir_all(&path),
                (_, true) if super::store::is_unfinished(name) => fs::remove_file(&path),
                _ => Ok(()),
            };
            removed.map_err(io_failed("remove", &path))?;
        }
        Ok(())
    }

    /// A folder for unfinished files; what is ours in it is removed by the next run.
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

    /// An error of the record as one of this folder.
    pub fn journal_failed(&self) -> impl FnOnce(JournalError) -> StateError {
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

/// Makes a folder ours that is one of ours, empty or not there; one of 0.1.0 gets its marker.
///
/// # Errors
/// [`StateError::NotOurs`] before anything changes, others when the disk refuses.
pub fn claim(root: &Path) -> Result<(), StateError> {
    is_there(root)?;
    no_links(root)?;
    fs::create_dir_all(root).map_err(io_failed("create", root))?;
    if Marker::read(root).is_some() {
        return Ok(());
    }
    let marker = Marker::of(Kind::State);
    marker.write(root, Saved::Now).map_err(io_failed("mark", root))
}

/// Refuses a state directory in which a link stands for a folder of ours: what it leads to is not.
fn no_links(root: &Path) -> Result<(), StateError> {
    for name in FOLDERS {
        if fs::symlink_metadata(root.join(name)).is_ok_and(|about| about.is_symlink()) {
            let found = format!("`{name}`, a link");
            return Err(StateError::NotOurs { path: root.to_path_buf(), found });
        }
    }
    Ok(())
}

/// Whether there is a state directory; an error for a folder that is something else.
fn is_there(root: &Path) -> Result<bool, StateError> {
    let not_ours = |found: String| StateError::NotOurs { path: root.to_path_buf(), found };
    match marker::whose(root).map_err(io_failed("look into", root))? {
        Whose::Nobodys => Ok(false),
        Whose::Ours(Marker { kind: Kind::State, .. }) => Ok(true),
        Whose::Ours(Marker { kind, .. }) => Err(not_ours(format!("a marker that says {kind:?}"))),
        Whose::Strange(_) if is_of_old(root) => Ok(true),
        Whose::Strange(found) => Err(not_ours(found)),
    }
}

/// Whether 0.1.0 made this folder: a record of runs in it that is one. Or nothing but names of ours
/// without a record, as a kill or `kinfold doctor` left them; then nothing of it is ever removed but
/// what bears a name of our own.
fn is_of_old(root: &Path) -> bool {
    let record = root.join(RECORD);
    match fs::symlink_metadata(&record) {
        Ok(about) if about.is_file() && about.len() > 0 => Journal::is_one(&record),
        Ok(about) if !about.is_file() => false,
        _ => {
            let entries = fs::read_dir(root).into_iter().flatten().flatten();
            entries.map(|e| e.file_name()).all(|name| OF_OLD.iter().any(|old| name == *old))
                && (root.join("lock").exists() || root.join("calls").is_dir())
        }
    }
}

/// Whether a folder in `tmp/` bears a name of ours.
fn is_passing(name: &str) -> bool {
    let rest = PASSING.iter().find_map(|begin| name.strip_prefix(begin));
    rest.is_some_and(|rest| rest.len() == 6 && rest.bytes().all(|b| b.is_ascii_alphanumeric()))
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
        let second = StateDir::open(dir.path());
        assert!(matches!(second, Err(StateError::Lock { source: LockError::InUse(Some(_)), .. })));
        assert!(StateDir::open_to_read(dir.path()).unwrap().is_some(), "looking is allowed");
        drop(first);
        StateDir::open(dir.path()).unwrap();
    }

    #[test]
    fn looking_creates_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("state");
        assert!(StateDir::open_to_read(&root).unwrap().is_none());
        assert!(matches!(
            StateDir::open_existing(&root, Turns::AT_ONCE),
            Err(StateError::Absent(_))
        ));
        assert!(!root.exists());
    }

    #[test]
    fn of_tmp_only_files_of_our_own_names_are_swept_away() {
        let dir = tempfile::tempdir().unwrap();
        drop(StateDir::open(dir.path()).unwrap());
        let tmp = dir.path().join("tmp");
        for name in ["0123456789ab-7.partial", "half.partial", "check-", "thesis.txt"] {
            fs::write(tmp.join(name), "x").unwrap();
        }
        for name in ["check-aB3xYz", "command-aB3xYz", "check-mine", ".tmpAbCdEf"] {
            fs::create_dir_all(tmp.join(name).join("inner")).unwrap();
        }
        let state = StateDir::open(dir.path()).unwrap();
        let entries = fs::read_dir(state.scratch()).unwrap();
        let mut left: Vec<_> = entries.map(|e| e.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, [".tmpAbCdEf", "check-", "check-mine", "half.partial", "thesis.txt"]);
    }

    #[cfg(unix)]
    #[test]
    fn nothing_is_swept_through_a_link() {
        let dir = tempfile::tempdir().unwrap();
        let (state, far) = (dir.path().join("state"), dir.path().join("far"));
        drop(StateDir::open(&state).unwrap());
        fs::create_dir(&far).unwrap();
        fs::write(far.join("0123456789ab-7.partial"), "mine").unwrap();
        fs::remove_dir(state.join("tmp")).unwrap();
        std::os::unix::fs::symlink(&far, state.join("tmp")).unwrap();
        drop(StateDir::open(&state).unwrap());
        assert!(far.join("0123456789ab-7.partial").exists());
    }

    #[test]
    fn a_folder_is_no_state_directory_because_of_the_names_in_it() {
        let strange: [&[(&str, &[u8])]; 5] = [
            &[("tmp/thesis.txt", b"precious")],
            &[("run.sqlite", b"no database"), ("lock", b"")],
            &[("lock", b""), ("cas/ab/c", b""), ("thesis.txt", b"precious")],
            &[("cas/photo.png", b"precious")],
            &[(".kinfold", b"{\"schema\":\"kinfold-folder/1\",\"kind\":\"batch\"}")],
        ];
        for files in strange {
            let dir = tempfile::tempdir().unwrap();
            for (name, bytes) in files {
                let path = dir.path().join(name);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, bytes).unwrap();
            }
            let before = fs::read_dir(dir.path()).unwrap().count();
            for opened in [
                StateDir::open(dir.path()).err(),
                StateDir::open_to_read(dir.path()).err(),
                StateDir::open_existing(dir.path(), Turns::AT_ONCE).err(),
            ] {
                assert!(matches!(opened, Some(StateError::NotOurs { .. })), "{files:?}");
            }
            assert_eq!(fs::read_dir(dir.path()).unwrap().count(), before);
            assert!(files.iter().all(|(n, b)| fs::read(dir.path().join(n)).unwrap() == *b));
        }
    }

    #[test]
    fn a_state_directory_of_0_1_0_is_ours_and_gets_its_marker() {
        let dir = tempfile::tempdir().unwrap();
        let state = StateDir::open(dir.path()).unwrap();
        let digest = state.store.put(b"a lid").unwrap();
        drop(state);
        fs::remove_file(dir.path().join(marker::FILE)).unwrap();
        assert!(StateDir::open_to_read(dir.path()).unwrap().is_some());
        let state = StateDir::open(dir.path()).unwrap();
        assert!(matches!(state.store.get(&digest).unwrap(), Found::Whole(_)));
        assert!(Marker::read(dir.path()).is_some());
        // Killed before it wrote anything.
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("lock"), "").unwrap();
        StateDir::open(dir.path()).unwrap();
    }
}
