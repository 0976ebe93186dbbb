//! Whether a batch still is what it was: every file follows from its trace, every trace from its
//! row of the ledger, every row from the one before it.

use std::collections::BTreeMap;
use std::path::Path;

use adapters::budget::FileBook;
use guard::files::Refused;
use guard::folder::{Caps, Entry, Folder, Kind};
use rayon::prelude::*;
use runner::ours::marker;
use trace::sign::PublicKey;
use trace::{Digest, Reading};

use super::error::BatchError;
use super::folder::{ASSETS, QUARANTINE, refused};
use super::index::ledgers;
use super::ledger::{Ledger, LedgerError};
use super::plan::Share;
use super::record::{Ended, Record};
use super::signed;
use crate::output::names::{ENVELOPE, REASON, SIGNATURE, STATEMENT, TRACE};

/// Items that are looked at side by side.
const AT_ONCE: usize = 256;
/// Threads that read them: many more than processors, for most of the time goes into waiting for
/// the disk.
const READERS: usize = 16;
/// The account book in a state directory.
pub const BOOK: &str = "spent.jsonl";
/// Findings that are kept at most.
const MOST: usize = 10_000;
/// How much of one item is read, bytes: a guess, a hundred times the largest seen.
const ONE: u64 = 4 << 30;
/// Files of an item's folder that no stage made.
const BESIDE: [&str; 6] = [TRACE, SIGNATURE, STATEMENT, ENVELOPE, REASON, marker::FILE];

/// Something that does not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The item, or nothing for the ledger itself.
    pub id: String,
    /// What was found.
    pub found: String,
}

/// What an audit came to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Audit {
    /// Items whose files were looked at.
    pub looked_at: u64,
    /// Items in the ledger that have files.
    pub items: u64,
    /// Everything that does not hold, at most ten thousand.
    pub findings: Vec<Finding>,
    /// What nothing vouches for: rows and lines that kinfold 0.1.0 did not chain.
    pub unknown: Vec<String>,
}

/// Audits a batch's folder and its shards; about `sample` items of each, or all. With a key every
/// statement must be signed by it, too.
///
/// # Errors
/// [`BatchError`] when a ledger cannot be read at all.
pub fn audit(
    root: &Path,
    sample: Option<u64>,
    key: Option<&PublicKey>,
) -> Result<Audit, BatchError> {
    let readers = rayon::ThreadPoolBuilder::new().num_threads(READERS).build();
    let readers = readers.map_err(BatchError::Threads)?;
    let mut audit = Audit::default();
    for (folder, ledger) in ledgers(root)? {
        // A batch has as many items as it has.
        let caps = Caps { entries: usize::MAX, ..Caps::default() };
        let opened = Folder::open(&folder, caps).map_err(refused(&folder))?;
        chains(&opened, &ledger, &mut audit)?;
        readers.install(|| one_ledger((&opened, &ledger), sample, key, &mut audit))?;
    }
    Ok(audit)
}

/// The chains of a ledger and of the account book beside it.
fn chains(folder: &Folder, ledger: &Ledger, audit: &mut Audit) -> Result<(), BatchError> {
    let said = |found: String| format!("{}: {found}", folder.path().display());
    for found in ledger.broken_links()? {
        audit.note(Finding { id: String::new(), found: said(found) });
    }
    for (table, rows) in ledger.unchained()? {
        let found = format!("{table}: {rows} rows of kinfold 0.1.0, which did not chain them");
        audit.unknown.push(said(found));
    }
    let place = Path::new("state").join(BOOK);
    match folder.real(&place) {
        Err(why) if why.is_absence() => return Ok(()),
        Err(why) => {
            let found = said(format!("{} {why}", place.display()));
            audit.note(Finding { id: String::new(), found });
            return Ok(());
        }
        Ok(_) => {}
    }
    let book = FileBook::new(folder.path().join(place));
    match book.unchained() {
        Ok(0) => {}
        Ok(lines) => {
            let found = format!("{BOOK}: {lines} lines of kinfold 0.1.0, which did not chain them");
            audit.unknown.push(said(found));
        }
        Err(error) => audit.note(Finding { id: String::new(), found: error.to_string() }),
    }
    Ok(())
}

impl Audit {
    fn note(&mut self, finding: Finding) {
        if self.findings.len() < MOST {
            self.findings.push(finding);
        }
    }
}

fn one_ledger(
    (root, ledger): (&Folder, &Ledger),
    sample: Option<u64>,
    key: Option<&PublicKey>,
    audit: &mut Audit,
) -> Result<(), BatchError> {
    let mut items = 0;
    ledger.each_item(|record| {
        items += u64::from(has_files(&record));
        Ok::<(), LedgerError>(())
    })?;
    let of = sample.map_or(1, |n| (items / n.max(1)).max(1));
    let mut page = Vec::new();
    ledger.each_item(|record| {
        if (Share { k: 0, of }).holds(&record.id) {
            page.extend(earlier(root, ledger, &record, audit)?);
            if record.outcome == Ended::Failed {
                failed(root, &record, audit);
            }
            page.extend(Some(record).filter(has_files));
        }
        if page.len() == AT_ONCE {
            look_at(root, &std::mem::take(&mut page), key, audit);
        }
        Ok::<(), LedgerError>(())
    })?;
    look_at(root, &page, key, audit);
    audit.items += items;
    for folder in [ASSETS, QUARANTINE] {
        without_row(root, folder, ledger, audit)?;
    }
    Ok(())
}

/// Whether an item ended with an asset, accepted or not.
pub(super) fn has_files(record: &Record) -> bool {
    matches!(record.outcome, Ended::Accepted | Ended::Rejected)
}

/// What a failed item left: its trace and the reason, where its row names them, are those.
fn failed(root: &Folder, record: &Record, audit: &mut Audit) {
    for (name, file) in [("trace", TRACE), ("reason", REASON)] {
        let Some(was) = record.digests.get(name) else { continue };
        let path = Path::new(QUARANTINE).join(&record.id).join(file);
        let is = root.file(&path).and_then(|f| Digest::of_reader(f).map_err(Refused::of));
        let found = match is {
            Ok(is) if is == *was => continue,
            Ok(_) => format!("{QUARANTINE}/{}/{file} is not the one the ledger names", record.id),
            Err(why) => format!("{QUARANTINE}/{}/{file} {why}", record.id),
        };
        audit.note(Finding { id: record.id.clone(), found });
    }
}

/// The row of an asset that was accepted before its item failed: it stays until another one is.
fn earlier(
    root: &Folder,
    ledger: &Ledger,
    last: &Record,
    audit: &mut Audit,
) -> Result<Option<Record>, LedgerError> {
    let stands = root.kind(&Path::new(ASSETS).join(&last.id)).is_ok_and(|kind| kind.is_some());
    if last.outcome == Ended::Accepted || !stands {
        return Ok(None);
    }
    let accepted = ledger.last_accepted(&last.id)?;
    if accepted.is_none() {
        let found = format!("{ASSETS}/{} was never accepted", last.id);
        audit.note(Finding { id: last.id.clone(), found });
    }
    Ok(accepted)
}

fn look_at(root: &Folder, records: &[Record], key: Option<&PublicKey>, audit: &mut Audit) {
    let findings: Vec<_> = records.par_iter().map(|record| one(root, record, key)).collect();
    audit.looked_at += records.len() as u64;
    for (record, found) in records.iter().zip(findings) {
        found.into_iter().for_each(|found| audit.note(Finding { id: record.id.clone(), found }));
    }
}

/// Folders that no row of the ledger names.
fn without_row(
    root: &Folder,
    folder: &'static str,
    ledger: &Ledger,
    audit: &mut Audit,
) -> Result<(), BatchError> {
    let entries = root.list(Path::new(folder)).map_err(refused(&root.path().join(folder)))?;
    for Entry { path, .. } in entries {
        let id = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if !ledger.knows(&id)? {
            let found = format!("{folder}/{id} stands in no row of the ledger");
            audit.note(Finding { id, found });
        }
    }
    Ok(())
}

/// Why an item's folder says nothing.
fn unread(place: &str, record: &Record, why: &Refused) -> String {
    if why.is_absence() {
        return format!("{place}/{} is gone", record.id);
    }
    format!("{place}/{} {why}", record.id)
}

/// Everything that does not hold about an item.
fn one(root: &Folder, record: &Record, key: Option<&PublicKey>) -> Vec<String> {
    let place = if record.outcome == Ended::Accepted { ASSETS } else { QUARANTINE };
    let caps = Caps { all: ONE, ..Caps::default() };
    let folder = match root.within(&Path::new(place).join(&record.id), caps) {
        Ok(folder) => folder,
        Err(why) => return vec![unread(place, record, &why)],
    };
    let Contents { files, trace, strange } = match contents(&folder) {
        Ok(found) if found.files.is_empty() && found.strange.is_empty() => {
            return vec![format!("{place}/{} is gone", record.id)];
        }
        Ok(found) => found,
        Err(why) => return vec![unread(place, record, &why)],
    };
    let mut found = strange;
    found.extend(against_ledger(record, &files));
    found.extend(key.iter().flat_map(|key| signed::unvouched(&folder, record, &files, key)));
    // Without a trace there is nothing to follow from; that it is gone was found above.
    match trace.map(|bytes| trace::read_bytes(&bytes, TRACE)) {
        Some(Ok(reading)) => found.extend(against_trace(record, &files, &reading)),
        Some(Err(e)) => found.push(e.to_string()),
        None => {}
    }
    found
}

/// What does not follow from the row: the trace, the statement, the list of files, the tier.
fn against_ledger(record: &Record, files: &BTreeMap<String, Digest>) -> Vec<String> {
    let mut found = Vec::new();
    let named = |file: &str, name: &str| match (files.get(file), record.digests.get(name)) {
        (Some(is), Some(was)) if is == was => None,
        (None, _) => Some(format!("{file} is gone")),
        (Some(_), _) => Some(format!("{file} is not the one the ledger names")),
    };
    found.extend(named(TRACE, "trace"));
    found.extend(named(STATEMENT, "attestation"));
    if record.digests.contains_key("reason") {
        found.extend(named(REASON, "reason"));
    }
    for (name, was) in record.files.iter().filter(|(name, _)| *name != TRACE) {
        match files.get(name) {
            None => found.push(format!("{name} is gone")),
            Some(is) if is != was => found.push(format!("{name} was changed")),
            Some(_) => {}
        }
    }
    let stranger =
        |name: &&String| !record.files.contains_key(*name) && !BESIDE.contains(&name.as_str());
    found.extend(files.keys().filter(stranger).map(|name| format!("{name} was added")));
    found
}

/// What does not follow from the trace: a file no stage made, another photo, another tier.
fn against_trace(
    record: &Record,
    files: &BTreeMap<String, Digest>,
    reading: &Reading,
) -> Vec<String> {
    let mut found = Vec::new();
    if let Some(torn) = &reading.torn {
        found.push(format!("trace.mcap is incomplete: {torn}"));
    }
    if !reading.chain_holds {
        found.push("trace.mcap: an event does not name the digest of the one before it".into());
    }
    let photo = reading.manifest.as_ref().and_then(|m| m.inputs.get("photo"));
    if photo != record.digests.get("photo") {
        found.push("trace.mcap is of another photo".into());
    }
    let outputs = || reading.events.iter().flat_map(|(_, event)| &event.outputs);
    for (name, digest) in files.iter().filter(|(name, _)| !BESIDE.contains(&name.as_str())) {
        let inner = name.strip_prefix("views/").unwrap_or(name);
        if !outputs().any(|o| o.digest == *digest && (o.name == *name || o.name == inner)) {
            found.push(format!("{name} does not follow from the trace"));
        }
    }
    let tier = reading.verdict.as_ref().and_then(|v| v.get("tier")?.as_str());
    if tier != record.verdict.as_deref() {
        found.push("the tier in the trace is not the ledger's".into());
    }
    found
}

/// What lies in an item's folder.
#[derive(Default)]
struct Contents {
    /// Digests of all its files, by path in it.
    files: BTreeMap<String, Digest>,
    /// The trace's bytes, if it has one.
    trace: Option<Vec<u8>>,
    /// What is not read, each with the reason.
    strange: Vec<String>,
}

/// Reads everything in an item's folder and nothing else: no link is followed, and what is no file
/// is told.
fn contents(folder: &Folder) -> Result<Contents, Refused> {
    let mut found = Contents::default();
    for Entry { path, kind } in folder.walk(Path::new("."))? {
        let name = path.to_string_lossy().replace('\\', "/");
        let digest = match kind {
            Kind::Link => {
                found.strange.push(format!("{name} is a link, which is not followed"));
                continue;
            }
            _ if name == TRACE => folder.read(&path).map(|bytes| {
                let digest = Digest::of(&bytes);
                found.trace = Some(bytes);
                digest
            }),
            _ => folder.file(&path).and_then(|f| Digest::of_reader(f).map_err(Refused::of)),
        };
        match digest {
            Ok(digest) => drop(found.files.insert(name, digest)),
            Err(why) => found.strange.push(format!("{name} {why}")),
        }
    }
    Ok(found)
}
