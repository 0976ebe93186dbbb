//! The store: bytes under the name of their digest, written whole or not at all.
//!
//! ```
//! use runner::Found;
//! use runner::store::Store;
//!
//! let dir = tempfile::tempdir()?;
//! let store = Store::new(dir.path().join("cas"), dir.path().join("tmp"));
//! let digest = store.put(b"a lid")?;
//! assert_eq!(store.get(&digest)?, Found::Whole(b"a lid".to_vec()));
//!
//! std::fs::write(store.path(&digest), b"a li")?;
//! assert_eq!(store.get(&digest)?, Found::Damaged);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use guard::files::Refused;
use trace::Digest;

use super::ours::{sync_folder, write_synced};

/// Most bytes of a blob that are read; a guess, some ten times the largest mesh that is taken.
const MOST: u64 = 4 << 30;

/// A folder of blobs, `<root>/ab/cdef…`, each named by the digest of its bytes.
#[derive(Clone, Debug)]
pub struct Store {
    root: PathBuf,
    scratch: PathBuf,
    /// How many files were begun: two that write the same bytes at once use two files.
    begun: Arc<AtomicU64>,
}

/// Why the store could not do its work.
#[derive(Debug, thiserror::Error)]
#[error("store {}: cannot {doing}: {source}", path.display())]
pub struct StoreError {
    /// What was tried.
    pub doing: &'static str,
    /// The file.
    pub path: PathBuf,
    /// What the operating system said.
    pub source: io::Error,
}

/// What is under a name.
#[derive(Debug, PartialEq, Eq)]
pub enum Found {
    /// The bytes, whose digest was right.
    Whole(Vec<u8>),
    /// Nothing.
    Absent,
    /// Something else: torn or damaged.
    Damaged,
}

impl Store {
    /// A store in folder `root`; unfinished files live in `scratch`, on the same file system.
    pub fn new(root: PathBuf, scratch: PathBuf) -> Self {
        Self { root, scratch, begun: Arc::default() }
    }

    /// Where the bytes of a digest stand.
    pub fn path(&self, digest: &Digest) -> PathBuf {
        let (head, tail) = digest.as_str().split_at(2);
        self.root.join(head).join(tail)
    }

    /// Keeps some bytes: temporary file, fsync, rename, fsync of the folder. Whole bytes that are
    /// there already are left alone, damaged ones replaced.
    ///
    /// # Errors
    /// [`StoreError`] when the disk refuses; nothing is half-written then.
    pub fn put(&self, bytes: &[u8]) -> Result<Digest, StoreError> {
        let digest = Digest::of(bytes);
        if matches!(self.get(&digest)?, Found::Whole(_)) {
            return Ok(digest);
        }
        let target = self.path(&digest);
        let folder = target.parent().unwrap_or(&self.root).to_path_buf();
        let number = self.begun.fetch_add(1, Ordering::Relaxed);
        let temporary = self.scratch.join(format!("{}-{number}.partial", digest.short()));
        for folder in [&folder, &self.scratch] {
            fs::create_dir_all(folder).map_err(failed("create the folder of", &target))?;
        }
        let written = write_synced(&temporary, bytes);
        if written.is_err() {
            let _ = fs::remove_file(&temporary);
        }
        written.map_err(failed("write", &temporary))?;
        fs::rename(&temporary, &target).map_err(failed("move into place", &target))?;
        sync_folder(&folder).map_err(failed("sync the folder of", &target))?;
        Ok(digest)
    }

    /// Every blob by the digest in its name, in order, with its file.
    ///
    /// # Errors
    /// [`StoreError`] when the disk refuses to say.
    pub fn blobs(&self) -> Result<Vec<(Digest, PathBuf)>, StoreError> {
        let mut found = Vec::new();
        for head in names(&self.root)? {
            for tail in names(&self.root.join(&head))? {
                if let Some(digest) = Digest::parse(&format!("{head}{tail}")) {
                    let path = self.path(&digest);
                    found.push((digest, path));
                }
            }
        }
        Ok(found)
    }

    /// What is kept under a digest, checked against it.
    ///
    /// # Errors
    /// [`StoreError`] when the disk refuses to say.
    pub fn get(&self, digest: &Digest) -> Result<Found, StoreError> {
        let path = self.path(digest);
        match fs::symlink_metadata(&path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Found::Absent),
            Err(source) => return Err(StoreError { doing: "look at", path, source }),
            // We write files alone: a link, a pipe or a folder of that name is none of its bytes.
            Ok(about) if !about.is_file() => return Ok(Found::Damaged),
            Ok(_) => {}
        }
        match guard::files::read(&path, MOST) {
            Ok(bytes) if Digest::of(&bytes) == *digest => Ok(Found::Whole(bytes)),
            Err(Refused::Open(e)) if e.kind() == io::ErrorKind::NotFound => Ok(Found::Absent),
            Err(Refused::Open(source) | Refused::Read(source)) => {
                Err(StoreError { doing: "read", path, source })
            }
            // Too long, or no file after all.
            Ok(_) | Err(_) => Ok(Found::Damaged),
        }
    }
}

/// The names in a folder, in order; none if it is not there.
fn names(folder: &Path) -> Result<Vec<String>, StoreError> {
    let entries = match fs::read_dir(folder) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(failed("read the folder", folder))?,
    };
    let name = |entry: io::Result<fs::DirEntry>| {
        let entry = entry.map_err(failed("read the folder", folder))?;
        Ok(entry.file_name().to_string_lossy().into_owned())
    };
    let mut names = entries.map(name).collect::<Result<Vec<_>, StoreError>>()?;
    names.sort();
    Ok(names)
}

fn failed(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> StoreError {
    let path = path.to_path_buf();
    move |source| StoreError { doing, path, source }
}

/// Whether a file in a scratch folder bears the name of an unfinished blob.
pub(super) fn is_unfinished(name: &str) -> bool {
    let number = name.strip_suffix(".partial").and_then(|name| name.split_once('-'));
    let hex = |b: u8| b.is_ascii_digit() || (b'a'..=b'f').contains(&b);
    number.is_some_and(|(digest, number)| {
        digest.len() == 12
            && digest.bytes().all(hex)
            && !number.is_empty()
            && number.bytes().all(|b| b.is_ascii_digit())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn store() -> (tempfile::TempDir, Store) {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::new(dir.path().join("cas"), dir.path().join("tmp"));
        (dir, store)
    }

    #[test]
    fn what_was_put_is_found_under_its_digest() {
        let (dir, store) = store();
        let digest = store.put(b"a lid").unwrap();
        assert_eq!(digest, Digest::of(b"a lid"));
        assert_eq!(store.get(&digest).unwrap(), Found::Whole(b"a lid".to_vec()));
        assert_eq!(store.get(&Digest::of(b"other")).unwrap(), Found::Absent);
        assert_eq!(fs::read_dir(dir.path().join("tmp")).unwrap().count(), 0);
    }

    #[test]
    fn a_damaged_blob_is_noticed_and_replaced() {
        let (_dir, store) = store();
        let digest = store.put(b"a lid").unwrap();
        fs::write(store.path(&digest), b"a li").unwrap();
        assert_eq!(store.get(&digest).unwrap(), Found::Damaged);
        store.put(b"a lid").unwrap();
        assert_eq!(store.get(&digest).unwrap(), Found::Whole(b"a lid".to_vec()));
    }

    #[test]
    fn a_disk_that_refuses_is_an_error_with_the_file_in_it() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("cas"), "a file where the folder should be").unwrap();
        let store = Store::new(dir.path().join("cas"), dir.path().join("tmp"));
        let error = store.put(b"x").unwrap_err().to_string();
        assert!(error.contains("cas"), "{error}");
    }
}
