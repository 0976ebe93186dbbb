//! Findings that were known before: they do not fail again, and new ones do.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sim_check::report::answer::{Allowance, known};
use sim_check::{Status, Verdict};

use super::config::from;
use crate::cli::speech::Complaint;

/// Version of the format.
const VERSION: u32 = 1;
/// More than a file about a hundred thousand models has, bytes; a guess with room.
const MOST: u64 = 256 << 20;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    kinfold_baseline: u32,
    /// By file, from this file's folder: by check, its findings without their figures.
    findings: BTreeMap<String, BTreeMap<String, BTreeSet<String>>>,
}

/// A file of known findings.
#[derive(Debug)]
pub(super) struct Baseline {
    name: String,
    folder: PathBuf,
    written: Written,
}

impl Baseline {
    /// Reads it.
    ///
    /// # Errors
    /// Where it cannot be read, or is no such file.
    pub(super) fn read(path: &Path) -> Result<Self, Complaint> {
        let shown = path.display();
        let bytes = guard::files::read(path, MOST).map_err(|e| {
            let hint = "--write-baseline FILE writes one with all that fails today";
            Complaint::failed(format!("{shown} {e}")).hint(hint)
        })?;
        let written: Written = serde_json::from_slice(&bytes)
            .map_err(|e| Complaint::misused(format!("{shown}: not a baseline: {e}")))?;
        if written.kinfold_baseline != VERSION {
            let found = written.kinfold_baseline;
            let message = format!("{shown}: expected kinfold_baseline {VERSION}, found {found}");
            return Err(Complaint::misused(message));
        }
        Ok(Self { name: shown.to_string(), folder: folder_of(path), written })
    }

    /// What of a file was known.
    pub(super) fn of(&self, file: &Path) -> Vec<Allowance> {
        let Some(checks) = self.written.findings.get(&from(&self.folder, file)) else {
            return Vec::new();
        };
        let reason = format!("known before: {}", self.name);
        let all = checks.iter().flat_map(|(id, findings)| {
            let whole = findings.is_empty().then_some(None);
            let each = findings.iter().map(|finding| Some(finding.clone()));
            each.chain(whole).map(|finding| Allowance { finding, ..Allowance::new(id, &reason) })
        });
        all.collect()
    }
}

/// What fails in these files today, for [`Baseline::read`]; the same verdicts give the same bytes.
///
/// # Errors
/// Where it cannot be written.
pub(super) fn write<'a>(
    path: &Path,
    files: impl Iterator<Item = (&'a Path, &'a Verdict)>,
) -> Result<usize, Complaint> {
    let folder = folder_of(path);
    let mut written = Written { kinfold_baseline: VERSION, findings: BTreeMap::new() };
    let mut count = 0;
    for (file, verdict) in files {
        let failed =
            verdict.checks.iter().filter(|c| c.status == Status::Fail && c.waived.is_none());
        let checks: BTreeMap<String, BTreeSet<String>> =
            failed.map(|c| (c.id.clone(), c.evidence.iter().map(|e| known(e)).collect())).collect();
        count += checks.values().map(|findings| findings.len().max(1)).sum::<usize>();
        if !checks.is_empty() {
            written.findings.insert(from(&folder, file), checks);
        }
    }
    let failed = |e: &dyn std::fmt::Display| Complaint::failed(format!("{}: {e}", path.display()));
    let text = serde_json::to_string_pretty(&written).map_err(|e| failed(&e))?;
    std::fs::write(path, guard::text::json(&text).into_owned() + "\n").map_err(|e| failed(&e))?;
    Ok(count)
}

fn folder_of(path: &Path) -> PathBuf {
    let whole = std::path::absolute(path).unwrap_or(path.into());
    whole.parent().unwrap_or(Path::new("")).to_owned()
}
