//! What a store keeps: removes what nothing names any more, finds what rotted.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use guard::files::Refused;
use guard::folder::{Caps, Entry, Folder, Kind};
use rayon::prelude::*;
use runner::ours::Turns;
use runner::{StateDir, StateError};
use trace::{Digest, Time};

use super::error::BatchError;
use super::folder::{io_failed, refused};
use super::index::ledgers;
use super::ledger::{self, Ledger, LedgerError};
use super::record::{Ended, Record};

/// Blobs that are hashed side by side.
const AT_ONCE: usize = 256;

/// What was removed, or would be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Removed {
    /// Blobs that stay.
    pub kept: u64,
    /// Blobs that go.
    pub blobs: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Results that go with them.
    pub results: u64,
}

/// What of a store is not whole.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verified {
    /// Blobs that were looked at.
    pub blobs: u64,
    /// Blobs whose bytes were not theirs.
    pub damaged: Vec<Digest>,
    /// Blobs that results name and that are not there.
    pub missing: Vec<Digest>,
    /// Items of the batch that will be made again, because what they rest on was taken out.
    pub reopened: u64,
}

/// How a store is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// To look: nothing is created or changed.
    Look,
    /// To change it, alone, when it is our turn.
    Change(Turns),
}

impl Access {
    fn open(self, folder: &Path) -> Result<StateDir, StateError> {
        let state = state_of(folder);
        match self {
            Self::Look => StateDir::open_to_read(&state)?.ok_or(StateError::Absent(state)),
            Self::Change(turns) => StateDir::open_existing(&state, turns),
        }
    }

    fn may_change(self) -> bool {
        self != Self::Look
    }
}

/// The state directory of a folder that is one, or of a batch's folder.
pub fn state_of(folder: &Path) -> PathBuf {
    let of_batch = folder.join("state");
    if of_batch.join("run.sqlite").exists() { of_batch } else { folder.to_path_buf() }
}

/// Removes blobs that no ledger, no trace and no result younger than `before` names.
///
/// Of a batch's folder the batch's ledgers count. `keep` are folders whose traces count, too.
///
/// # Errors
/// [`BatchError`] when something cannot be read, and then nothing is removed; or when the disk
/// refuses to remove.
pub fn collect(
    folder: &Path,
    keep: &[PathBuf],
    before: Time,
    access: Access,
) -> Result<Removed, BatchError> {
    let root = state_of(folder);
    let state = access.open(folder)?;
    let mut named = BTreeSet::new();
    if folder.join(ledger::FILE).exists() {
        for (_, ledger) in ledgers(folder)? {
            named.extend(ledger.named()?);
        }
    }
    for folder in keep {
        named_by_traces(folder, &mut named)?;
    }
    let journal = |e| BatchError::from(state.journal_failed()(e));
    let stale = state.journal.stale(before, &named).map_err(journal)?;
    named.extend(state.journal.named_except(&stale).map_err(journal)?);
    let mut removed = Removed { results: stale.len() as u64, ..Removed::default() };
    if access.may_change() {
        state.journal.forget(&stale).map_err(journal)?;
    }
    for blob in blobs(&open(&root)?)? {
        if named.contains(&blob.digest) {
            removed.kept += 1;
            continue;
        }
        let path = root.join(&blob.path);
        removed.blobs += 1;
        removed.bytes += fs::symlink_metadata(&path).map_err(io_failed("look at", &path))?.len();
        if access.may_change() {
            fs::remove_file(&path).map_err(io_failed("remove", &path))?;
        }
    }
    Ok(removed)
}

/// A store is as large as it is; one blob has a cap.
fn open(root: &Path) -> Result<Folder, BatchError> {
    let caps = Caps { entries: usize::MAX, all: u64::MAX, file: 64 << 30, ..Caps::default() };
    Folder::open(root, caps).map_err(refused(root))
}

/// Something in the store.
struct Blob {
    digest: Digest,
    /// Its path in the state directory.
    path: PathBuf,
    kind: Kind,
}

/// Everything in the store whose name is a digest, in order. No link is followed.
fn blobs(state: &Folder) -> Result<Vec<Blob>, BatchError> {
    let list = |path: &Path| state.list(path).map_err(refused(&state.path().join(path)));
    let mut found = Vec::new();
    for head in list(Path::new("cas"))?.into_iter().filter(|e| e.kind == Kind::Folder) {
        for Entry { path, kind } in list(&head.path)? {
            let names = [&head.path, &path].map(|p| p.file_name().unwrap_or_default());
            let name: String = names.iter().map(|n| n.to_string_lossy()).collect();
            if let Some(digest) = Digest::parse(&name) {
                found.push(Blob { digest, path, kind });
            }
        }
    }
    Ok(found)
}

/// Whether a blob's bytes are its own.
fn is_whole(state: &Folder, blob: &Blob) -> Result<bool, BatchError> {
    if blob.kind != Kind::File {
        return Ok(false);
    }
    let digest = state.file(&blob.path).and_then(|f| Digest::of_reader(f).map_err(Refused::of));
    match digest {
        Ok(digest) => Ok(digest == blob.digest),
        Err(Refused::NotRegular | Refused::Outside | Refused::TooLarge { .. }) => Ok(false),
        Err(why) => Err(refused(&state.path().join(&blob.path))(why)),
    }
}

fn named_by_traces(folder: &Path, named: &mut BTreeSet<Digest>) -> Result<(), BatchError> {
    let opened = open(folder)?;
    for Entry { path, kind } in opened.walk(Path::new(".")).map_err(refused(folder))? {
        let full = folder.join(&path);
        if kind == Kind::Link {
            // What lies inside is met anyway; what lies outside nobody named.
            if matches!(opened.real(&path), Err(Refused::Outside)) {
                return Err(refused(&full)(Refused::Outside));
            }
            continue;
        }
        if path.extension().is_some_and(|e| e == "mcap") {
            let bytes = opened.read(&path).map_err(refused(&full))?;
            for (_, event) in trace::read_bytes(&bytes, &full.display().to_string())?.events {
                named.extend(event.inputs.into_iter().chain(event.outputs).map(|a| a.digest));
            }
        }
    }
    Ok(())
}

/// Hashes every blob. If it may change something it also takes damaged ones out, and reopens the items
/// of the batch that rest on what is damaged or missing: the next run makes just those stages again.
///
/// # Errors
/// [`BatchError`] when the disk refuses.
pub fn verify(folder: &Path, at: Time, access: Access) -> Result<Verified, BatchError> {
    let root = state_of(folder);
    let state = access.open(folder)?;
    // Before the blobs: a blob is there before its row, whoever is at work meanwhile.
    let journal = |e| BatchError::from(state.journal_failed()(e));
    let outputs = state.journal.outputs().map_err(journal)?;
    let opened = open(&root)?;
    let blobs = blobs(&opened)?;
    let mut verified = Verified { blobs: blobs.len() as u64, ..Verified::default() };
    for some in blobs.chunks(AT_ONCE) {
        let found: Vec<_> = some.par_iter().map(|blob| (blob, is_whole(&opened, blob))).collect();
        for (blob, whole) in found {
            if whole? {
                continue;
            }
            if access.may_change() {
                let path = root.join(&blob.path);
                fs::remove_file(&path).map_err(io_failed("remove", &path))?;
            }
            verified.damaged.push(blob.digest.clone());
        }
    }
    let there: BTreeSet<_> = blobs.into_iter().map(|blob| blob.digest).collect();
    verified.missing = outputs.into_iter().filter(|d| !there.contains(d)).collect();
    let lost: BTreeSet<_> = verified.damaged.iter().chain(&verified.missing).cloned().collect();
    if access.may_change() && !lost.is_empty() && folder.join(ledger::FILE).exists() {
        verified.reopened = reopen(folder, &lost, at)?;
    }
    Ok(verified)
}

fn reopen(folder: &Path, lost: &BTreeSet<Digest>, at: Time) -> Result<u64, BatchError> {
    let ledger = Ledger::open(&folder.join(ledger::FILE))?;
    let mut ids = Vec::new();
    ledger.each_item(|record| {
        if record.artefacts.iter().any(|a| lost.contains(a)) {
            ids.push(record.id);
        }
        Ok::<(), LedgerError>(())
    })?;
    let nobody = Digest::of(b"");
    for id in &ids {
        let mut record = Record::new(id, Ended::Reopened);
        record.at_ns = at;
        ledger.add(0, &nobody, &[(nobody.clone(), record)])?;
    }
    Ok(ids.len() as u64)
}
