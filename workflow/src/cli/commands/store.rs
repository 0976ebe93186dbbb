//! `kinfold store`: what is kept of finished stages, and whether it is whole.

use runner::StateError;
use runner::ours::Turns;
use serde_json::json;
use trace::{Clock, SystemClock};

use super::make;
use crate::batch::BatchError;
use crate::batch::keep::{self, Access};
use crate::cli::args::StoreCommand;
use crate::cli::speech::{Answer, Complaint, Exit};

/// Nanoseconds of a day.
const DAY: u64 = 86_400_000_000_000;

/// Tidies up a store, or looks through it.
///
/// # Errors
/// [`Complaint`] when it is in use or cannot be read; nothing was removed then.
pub fn store(command: &StoreCommand) -> Result<Answer, Complaint> {
    let access = |changes: bool, no_wait: bool| {
        let turns = Turns { wait: !no_wait, tell: true };
        if changes { Access::Change(turns) } else { Access::Look }
    };
    match command {
        StoreCommand::Gc { folder, keep, older_than, dry_run, no_wait, json, .. } => {
            let now = SystemClock::default().now();
            let before = now.saturating_sub(older_than.saturating_mul(DAY));
            let removed = keep::collect(folder, keep, before, access(!dry_run, *no_wait));
            Ok(collected(&removed.map_err(|e| complaint(&e))?, *dry_run, *json))
        }
        StoreCommand::Verify { folder, repair, no_wait, json, .. } => {
            let now = SystemClock::default().now();
            let verified = keep::verify(folder, now, access(*repair, *no_wait));
            Ok(verdict(&verified.map_err(|e| complaint(&e))?, *repair, *json))
        }
    }
}

fn collected(removed: &keep::Removed, dry_run: bool, as_json: bool) -> Answer {
    let keep::Removed { kept, blobs, bytes, results } = removed;
    if as_json {
        let value = json!({ "kept": kept, "removed": blobs, "bytes": bytes, "results": results, "dry_run": dry_run });
        return Answer::done(format!("{value:#}\n"));
    }
    let word = if dry_run { "would remove" } else { "removed" };
    let size = indicatif::HumanBytes(*bytes);
    Answer::done(format!("{word} {blobs} blobs, {size}; kept {kept}\n"))
}

fn verdict(verified: &keep::Verified, repair: bool, as_json: bool) -> Answer {
    let keep::Verified { blobs, damaged, missing, reopened } = verified;
    let whole = damaged.is_empty() && missing.is_empty();
    let result = if as_json {
        let value = json!({
            "blobs": blobs, "damaged": damaged, "missing": missing, "repaired": repair,
            "reopened": reopened,
        });
        format!("{value:#}\n")
    } else {
        format!("{blobs} blobs, {} damaged, {} missing\n", damaged.len(), missing.len())
    };
    let word = if repair { "damaged and taken out" } else { "damaged" };
    let mut remarks: Vec<_> = damaged.iter().map(|d| format!("{word}: {d}")).collect();
    remarks.extend(missing.iter().map(|d| format!("missing: {d}")));
    if *reopened > 0 {
        let items = if *reopened == 1 { "item" } else { "items" };
        remarks.push(format!("hint: {reopened} {items} will be made again by the same `kinfold batch`, the lost stages alone"));
    } else if !whole && !repair {
        remarks.push(
            "hint: --repair takes it out, and the next run makes the lost stages again".into(),
        );
    } else if !whole {
        remarks.push("hint: the next run makes the lost stages again".into());
    }
    Answer { result, remarks, exit: if whole { Exit::Done } else { Exit::Losses } }
}

fn complaint(error: &BatchError) -> Complaint {
    match error {
        BatchError::State(e @ (StateError::Absent(_) | StateError::NotOurs { .. })) => {
            Complaint::from_error(e).hint("name a batch's folder, or a state directory")
        }
        BatchError::State(e) => make::state_complaint(e),
        _ => Complaint::from_error(error),
    }
}
