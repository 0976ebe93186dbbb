//! `kinfold make --dry-run`: which stages would run, and why.

use std::fmt::Write as _;

use runner::{PlannedStage, Reason};
use serde_json::json;

use crate::cli::speech::{Answer, Complaint};

/// The plan as a table or as JSON.
///
/// # Errors
/// [`Complaint`] if it cannot be printed.
pub fn shown(plan: &[PlannedStage], as_json: bool) -> Result<Answer, Complaint> {
    if as_json {
        return in_json(plan);
    }
    let mut out = String::new();
    for stage in plan {
        let why: Vec<_> = stage.reasons.iter().map(Reason::to_string).collect();
        let word = match (stage.would_run(), stage.may_run()) {
            (true, _) => "run",
            (_, true) => "may",
            _ => "keep",
        };
        let why = why.join(", ");
        let _ = writeln!(out, "{}", format!("{:<18} {word:<5} {why}", stage.stage).trim_end());
    }
    let count = plan.iter().filter(|s| s.would_run()).count();
    let more = plan.iter().filter(|s| s.may_run()).count();
    let more = if more == 0 {
        String::new()
    } else {
        format!(", {more} more may: those whose inputs come out other than before")
    };
    let _ = writeln!(out, "{count} of {} stages would run{more}", plan.len());
    Ok(Answer::done(out))
}

fn in_json(plan: &[PlannedStage]) -> Result<Answer, Complaint> {
    let one = |s: &PlannedStage| {
        let reasons: Vec<_> = s.reasons.iter().map(Reason::to_string).collect();
        json!({ "stage": s.stage, "run": s.would_run(), "may": s.may_run(), "reasons": reasons })
    };
    let stages: Vec<_> = plan.iter().map(one).collect();
    let text = serde_json::to_string_pretty(&json!({ "stages": stages }));
    text.map(|t| Answer::done(t + "\n")).map_err(|e| Complaint::from_error(&e))
}
