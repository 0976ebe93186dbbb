//! What several machines share: blobs by digest, results by key, each written once and for all.
//!
//! A machine looks into its own state directory first, then here; what it makes it brings here
//! before it counts as done. Of two machines that make the same result at the same time the first
//! one's stands, and the other takes it over.
//!
//! ```
//! use runner::depot::check_depot;
//! use runner::{Depot, FolderDepot, Found};
//! use trace::Digest;
//!
//! let dir = tempfile::tempdir()?;
//! let depot = FolderDepot::open(&dir.path().join("shared"), "this machine")?;
//! assert_eq!(check_depot(&depot)?, Ok(()));
//! assert_eq!(depot.blob(&Digest::of(b"never put"))?, Found::Absent);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use trace::Digest;

use super::artefact::Note;
use super::journal::Committed;
use super::ours::marker::{self, Saved, Whose};
use super::ours::{Kind, Marker, sync_folder, write_synced};
use super::store::{Found, Store, StoreError};

/// A store of blobs and results that several machines share.
///
/// Promise: what was put survives the end of any machine; [`Depot::put_result`] is put-if-absent,
/// and every caller is told the one result that stands; bytes come back whole or not at all.
pub trait Depot: Send + Sync {
    /// The bytes of a digest, checked against it.
    ///
    /// # Errors
    /// [`DepotError`] when the other side refuses to say.
    fn blob(&self, digest: &Digest) -> Result<Found, DepotError>;

    /// Keeps some bytes; damaged ones under their name are replaced.
    ///
    /// # Errors
    /// [`DepotError`] when the other side refuses.
    fn put_blob(&self, digest: &Digest, bytes: &[u8]) -> Result<(), DepotError>;

    /// The result under a key.
    ///
    /// # Errors
    /// [`DepotError`] when the other side refuses to say.
    fn result(&self, key: &Digest) -> Result<Option<Committed>, DepotError>;

    /// Keeps a result if there is none under the key yet; returns the one that stands.
    ///
    /// # Errors
    /// [`DepotError`] when the other side refuses.
    fn put_result(&self, key: &Digest, result: &Committed) -> Result<Committed, DepotError>;
}

/// Why a depot could not do its work.
#[derive(Debug, thiserror::Error)]
pub enum DepotError {
    /// A file of a shared folder.
    #[error("shared store {}: cannot {doing}: {source}", path.display())]
    Io {
        /// What was tried.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// Its blobs.
    #[error("shared {0}")]
    Store(#[from] StoreError),
    /// A bucket, for a program that knows none.
    #[error(
        "shared store {0}: expected a kinfold built with its feature `remote`, found one without"
    )]
    NotBuilt(String),
    /// A bucket.
    #[error("shared store {place}: cannot {doing}: {found}")]
    Bucket {
        /// Its address, or that of an object in it.
        place: String,
        /// What was tried.
        doing: &'static str,
        /// The rule, where there is one, and what was found.
        found: String,
    },
    /// A folder that holds something else.
    #[error(
        "{} holds `{found}` and no marker of ours: it is no shared store of kinfold",
        crate::ours::name(path)
    )]
    NotOurs {
        /// The folder.
        path: PathBuf,
        /// What was found.
        found: String,
    },
    /// A result that cannot be read.
    #[error("shared store {place}: expected a result, found {found}")]
    Foreign {
        /// Where it stands.
        place: String,
        /// What was found.
        found: String,
    },
}

/// A folder on a file system that all machines see.
#[derive(Clone, Debug)]
pub struct FolderDepot {
    blobs: Store,
    results: PathBuf,
    scratch: PathBuf,
}

impl FolderDepot {
    /// Makes a folder a depot that is one of ours, empty or not there, and opens it. One of 0.1.0 gets
    /// its marker.
    ///
    /// # Errors
    /// [`DepotError::NotOurs`] before anything changes, others when the disk refuses.
    pub fn open(root: &Path, name: &str) -> Result<Self, DepotError> {
        let not_ours = |found: String| DepotError::NotOurs { path: root.to_path_buf(), found };
        match marker::whose(root).map_err(failed("look into", root))? {
            Whose::Ours(Marker { kind: Kind::Store | Kind::State, .. }) => {}
            Whose::Ours(Marker { kind, .. }) => {
                return Err(not_ours(format!("a marker that says {kind:?}")));
            }
            Whose::Strange(found) if !is_of_old(root) => return Err(not_ours(found)),
            Whose::Nobodys | Whose::Strange(_) => {
                fs::create_dir_all(root).map_err(failed("create", root))?;
                let marked = Marker::of(Kind::Store).write(root, Saved::Now);
                // Another machine may have marked it at the same time.
                if Marker::read(root).is_none() {
                    marked.map_err(failed("mark", root))?;
                }
            }
        }
        Ok(Self::new(root, name))
    }

    /// A depot in folder `root`. `name` tells this machine's unfinished files from others'.
    pub fn new(root: &Path, name: &str) -> Self {
        let scratch = root.join("tmp").join(name);
        let blobs = Store::new(root.join("cas"), scratch.clone());
        Self { blobs, results: root.join("results"), scratch }
    }

    fn place(&self, key: &Digest) -> PathBuf {
        let (head, tail) = key.as_str().split_at(2);
        self.results.join(head).join(tail)
    }
}

impl Depot for FolderDepot {
    fn blob(&self, digest: &Digest) -> Result<Found, DepotError> {
        Ok(self.blobs.get(digest)?)
    }

    fn put_blob(&self, _digest: &Digest, bytes: &[u8]) -> Result<(), DepotError> {
        Ok(self.blobs.put(bytes).map(drop)?)
    }

    fn result(&self, key: &Digest) -> Result<Option<Committed>, DepotError> {
        let path = self.place(key);
        match fs::read(&path) {
            Ok(bytes) => read_result(&bytes, &path.display().to_string()).map(Some),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(DepotError::Io { doing: "read", path, source }),
        }
    }

    /// Written whole beside its place first; then a link, which never replaces.
    fn put_result(&self, key: &Digest, result: &Committed) -> Result<Committed, DepotError> {
        let path = self.place(key);
        let folder = path.parent().unwrap_or(&self.results);
        for folder in [folder, &self.scratch] {
            fs::create_dir_all(folder).map_err(failed("create", folder))?;
        }
        let partial = self.scratch.join(format!("{}.result", key.short()));
        let written = write_synced(&partial, &result_bytes(result));
        written.map_err(failed("write", &partial))?;
        let linked = fs::hard_link(&partial, &path);
        // What stays behind is swept away with the folder.
        let _ = fs::remove_file(&partial);
        match linked {
            Ok(()) => {
                sync_folder(folder).map_err(failed("sync", folder))?;
                Ok(result.clone())
            }
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {
                Ok(self.result(key)?.unwrap_or_else(|| result.clone()))
            }
            Err(e) => Err(failed("move into place", &path)(e)),
        }
    }
}

/// Whether 0.1.0 made this folder: nothing but its own folders, and in them nothing but folders of two
/// digits.
fn is_of_old(root: &Path) -> bool {
    let names = |folder: &Path| -> Vec<std::ffi::OsString> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|e| e.file_name()).collect()
    };
    let of_old = |name: &std::ffi::OsString| ["cas", "results", "tmp"].iter().any(|n| name == *n);
    let two_digits = |name: std::ffi::OsString| {
        let hex = |b: u8| b.is_ascii_digit() || (b'a'..=b'f').contains(&b);
        name.to_str().is_some_and(|name| name.len() == 2 && name.bytes().all(hex))
    };
    names(root).iter().all(of_old)
        && names(&root.join("cas")).into_iter().all(two_digits)
        && names(&root.join("results")).into_iter().all(two_digits)
        && root.join("cas").is_dir()
}

/// A result as it stands in a depot.
pub(super) fn result_bytes(result: &Committed) -> Vec<u8> {
    let value = serde_json::json!({ "output": result.output, "notes": result.notes });
    value.to_string().into_bytes()
}

/// The result in such bytes.
pub(super) fn read_result(bytes: &[u8], place: &str) -> Result<Committed, DepotError> {
    #[derive(serde::Deserialize)]
    struct Kept {
        output: Digest,
        notes: Vec<Note>,
    }
    let kept: Result<Kept, _> = serde_json::from_slice(bytes);
    let kept =
        kept.map_err(|e| DepotError::Foreign { place: place.into(), found: e.to_string() })?;
    Ok(Committed { output: kept.output, notes: kept.notes })
}

fn failed(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> DepotError + use<> {
    let path = path.to_path_buf();
    move |source| DepotError::Io { doing, path, source }
}

/// Checks the promise of [`Depot`]; the broken promise as the inner `Err`.
///
/// # Errors
/// The depot's own error.
pub fn check_depot(depot: &dyn Depot) -> Result<Result<(), String>, DepotError> {
    let (key, bytes) = (Digest::of(b"a key"), b"some bytes".to_vec());
    let digest = Digest::of(&bytes);
    if depot.blob(&digest)? != Found::Absent || depot.result(&key)?.is_some() {
        return Ok(Err("an empty depot has nothing".into()));
    }
    depot.put_blob(&digest, &bytes)?;
    depot.put_blob(&digest, &bytes)?;
    if depot.blob(&digest)? != Found::Whole(bytes) {
        return Ok(Err("what was put must come back".into()));
    }
    let note = Note { message: "a doubt".into(), loss: false };
    let first = Committed { output: digest, notes: vec![note] };
    let second = Committed { output: Digest::of(b"other bytes"), notes: vec![] };
    let told = [depot.put_result(&key, &first)?, depot.put_result(&key, &second)?];
    if told.iter().any(|t| *t != first) || depot.result(&key)? != Some(first) {
        return Ok(Err("the first result stands, and everybody is told so".into()));
    }
    Ok(Ok(()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_keeps_the_promise_of_a_depot() {
        let dir = tempfile::tempdir().unwrap();
        check_depot(&FolderDepot::new(dir.path(), "one")).unwrap().unwrap();
    }

    #[test]
    fn of_many_that_put_at_once_one_result_stands() {
        let dir = tempfile::tempdir().unwrap();
        let key = Digest::of(b"key");
        let put = |n: usize| {
            let depot = FolderDepot::new(dir.path(), &format!("machine-{n}"));
            let own = Committed { output: Digest::of(n.to_string().as_bytes()), notes: vec![] };
            depot.put_result(&key, &own).unwrap().output
        };
        let told: Vec<_> = std::thread::scope(|scope| {
            let all: Vec<_> = (0..8).map(|n| scope.spawn(move || put(n))).collect();
            all.into_iter().map(|t| t.join().unwrap()).collect()
        });
        assert!(told.iter().all(|t| *t == told[0]), "{told:?}");
    }

    #[test]
    fn a_folder_that_is_no_depot_is_refused_before_anything_in_it_changes() {
        for name in ["thesis.txt", "cas/photo.png", "tmp/one/half"] {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, "mine").unwrap();
            let refused = FolderDepot::open(dir.path(), "one").unwrap_err();
            assert!(matches!(refused, DepotError::NotOurs { .. }), "{name}: {refused}");
            assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        }
    }

    #[test]
    fn a_depot_of_0_1_0_is_ours_and_gets_its_marker() {
        let dir = tempfile::tempdir().unwrap();
        FolderDepot::new(dir.path(), "one").blobs.put(b"a lid").unwrap();
        FolderDepot::open(dir.path(), "two").unwrap();
        assert!(Marker::read(dir.path()).is_some());
        FolderDepot::open(dir.path(), "three").unwrap();
    }

    #[test]
    fn a_damaged_blob_is_found_and_replaced() {
        let dir = tempfile::tempdir().unwrap();
        let depot = FolderDepot::new(dir.path(), "one");
        let digest = Digest::of(b"a lid");
        depot.put_blob(&digest, b"a lid").unwrap();
        fs::write(depot.blobs.path(&digest), "a li").unwrap();
        assert_eq!(depot.blob(&digest).unwrap(), Found::Damaged);
        depot.put_blob(&digest, b"a lid").unwrap();
        assert_eq!(depot.blob(&digest).unwrap(), Found::Whole(b"a lid".to_vec()));
    }
}
