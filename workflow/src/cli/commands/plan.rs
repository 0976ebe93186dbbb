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
        let (word, why) =
            if stage.would_run() { ("run", why.join(", ")) } else { ("keep", String::new()) };
        let _ = writeln!(out, "{}", format!("{:<18} {word:<5} {why}", stage.stage).trim_end());
    }
    let count = plan.iter().filter(|s| s.would_run()).count();
    let _ = writeln!(out, "{count} of {} stages would run", plan.len());
    Ok(Answer::done(out))
}

fn in_json(plan: &[PlannedStage]) -> Result<Answer, Complaint> {
    let one = |s: &PlannedStage| {
        let reasons: Vec<_> = s.reasons.iter().map(Reason::to_string).collect();
        json!({ "stage": s.stage, "run": s.would_run(), "reasons": reasons })
    };
    let stages: Vec<_> = plan.iter().map(one).collect();
    let text = serde_json::to_string_pretty(&json!({ "stages": stages }));
    text.map(|t| Answer::done(t + "\n")).map_err(|e| Complaint::from_error(&e))
}
