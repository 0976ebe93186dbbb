//! Signed statements of a batch: an envelope beside each attestation, and whether it says what lies
//! there.
//!
//! The ledger's chain gives changes away and can be forged whole; what is looked at here needs the
//! secret key to be forged.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Write as _};
use std::path::Path;

use guard::folder::Folder;
use runner::ours::marker::{self, Saved};
use runner::ours::sync_folder;
use runner::ours::{Marker, Turns};
use serde_json::Value;
use trace::Digest;
use trace::sign::{PublicKey, SecretKey, dsse};

use super::error::BatchError;
use super::folder::{ASSETS, BatchFolder, QUARANTINE, io_failed};
use super::index::ledgers;
use super::ledger::LedgerError;
use super::record::{Ended, Record};
use crate::output::names::{ENVELOPE, REASON, SIGNATURE, STATEMENT};

/// Most bytes of a statement or an envelope: a guess, a hundred times what one of ours has.
const MOST: u64 = 64 << 20;
/// Files of an item's folder that a statement cannot name, or does not.
const BESIDE: [&str; 5] = [STATEMENT, ENVELOPE, SIGNATURE, REASON, marker::FILE];

/// Signs the statement of every item of a batch and its shards that has one; returns how many.
/// Nothing may be changing the batch meanwhile, so its folder is held.
///
/// # Errors
/// [`BatchError`] when there is no batch, another process has it, or the disk refuses.
pub fn sign(root: &Path, key: &SecretKey, turns: Turns) -> Result<u64, BatchError> {
    let folders: Vec<_> = ledgers(root)?.into_iter().map(|(folder, _)| folder).collect();
    let mut count = 0;
    for folder in folders {
        let (held, ledger) = BatchFolder::open(&folder, turns)?;
        let mut places = Vec::new();
        ledger.each_item(|record| {
            // An asset that was accepted stays where a later try failed.
            let asset = held.root().join(ASSETS).join(&record.id);
            let stands = record.outcome == Ended::Accepted || asset.is_dir();
            let accepted = ledger.last_accepted(&record.id)?.filter(|_| stands);
            let accepted = accepted.map(|row| (ASSETS, row));
            let rejected = (record.outcome == Ended::Rejected).then_some((QUARANTINE, record));
            for (place, row) in accepted.into_iter().chain(rejected) {
                let digest = row.digests.get("attestation").cloned();
                places.extend(Some(held.root().join(place).join(&row.id)).zip(digest));
            }
            Ok::<(), LedgerError>(())
        })?;
        for (place, digest) in places {
            let path = place.join(STATEMENT);
            let statement = guard::files::read(&path, MOST);
            let statement = statement.map_err(io::Error::other);
            let statement = statement.map_err(io_failed("read", &path))?;
            if Digest::of(&statement) != digest {
                let found = "it is not the statement that the ledger names".into();
                return Err(BatchError::Folder { path, found });
            }
            let path = place.join(ENVELOPE);
            let envelope = dsse::seal(key, dsse::IN_TOTO, &statement);
            placed(&path, &envelope).map_err(io_failed("write", &path))?;
            count += 1;
        }
    }
    Ok(count)
}

/// Puts a whole file that everybody may read into its place in one step; a link there is replaced, not
/// followed. In a folder of ours the marker names it, so that it goes with what it was signed for.
///
/// # Errors
/// When the disk refuses.
pub(crate) fn placed(place: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = place.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if let Some(mut marker) = Marker::read(folder)
        && let Some(name) = place.file_name()
        && marker.files.insert(name.to_string_lossy().into_owned())
    {
        marker.write(folder, Saved::Now)?;
    }
    let mut file = tempfile::Builder::new().prefix(".kinfold-").tempfile_in(folder)?;
    file.write_all(bytes)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        file.as_file().set_permissions(fs::Permissions::from_mode(0o644))?;
    }
    file.as_file().sync_all()?;
    file.persist(place).map_err(|e| e.error)?;
    sync_folder(folder)
}

/// What a key does not vouch for in an item's folder, whose files have these digests.
pub(super) fn unvouched(
    folder: &Folder,
    record: &Record,
    files: &BTreeMap<String, Digest>,
    key: &PublicKey,
) -> Vec<String> {
    let envelope = match folder.read(Path::new(ENVELOPE)) {
        Ok(bytes) => bytes,
        Err(e) => return vec![format!("{ENVELOPE} {e}: it is not signed")],
    };
    let statement = match dsse::open(key, dsse::IN_TOTO, &envelope) {
        Ok(statement) => statement,
        Err(e) => return vec![format!("{ENVELOPE}: {e}")],
    };
    let mut found = Vec::new();
    if files.get(STATEMENT) != Some(&Digest::of(&statement)) {
        found.push(format!("{} is not the statement that was signed", STATEMENT));
    }
    match serde_json::from_slice::<Value>(&statement) {
        Ok(statement) => {
            found.extend(other_files(&statement, files));
            found.extend(other_words(&statement["predicate"], record));
        }
        Err(e) => found.push(format!("the signed statement is no JSON: {e}")),
    }
    found
}

/// Files that are not the ones that the signed statement names.
fn other_files(statement: &Value, files: &BTreeMap<String, Digest>) -> Vec<String> {
    let subject = statement["subject"].as_array().map(Vec::as_slice).unwrap_or_default();
    let named: BTreeMap<_, _> = subject
        .iter()
        .filter_map(|one| Some((one["name"].as_str()?, one["digest"]["blake3"].as_str()?)))
        .collect();
    let there = files.iter().filter(|(name, _)| !BESIDE.contains(&name.as_str()));
    let there: BTreeMap<_, _> = there.map(|(n, digest)| (n.as_str(), digest.as_str())).collect();
    let names: BTreeSet<_> = named.keys().chain(there.keys()).collect();
    let differ = names.into_iter().filter(|name| named.get(**name) != there.get(**name));
    differ.map(|name| format!("{name} is not the one of the signed statement")).collect()
}

/// Words of the ledger's row that are not those of the signed statement.
fn other_words(predicate: &Value, record: &Record) -> Vec<String> {
    let pairs = [
        ("id", &predicate["id"], Some(record.id.as_str())),
        ("category", &predicate["category"], record.category.as_deref()),
        ("license", &predicate["license"], record.license.as_deref()),
        ("verdict", &predicate["verdict"]["tier"], record.verdict.as_deref()),
    ];
    let differ = pairs.into_iter().filter(|(_, signed, row)| signed.as_str() != *row);
    differ.map(|(name, ..)| format!("the ledger's {name} is not the signed statement's")).collect()
}
