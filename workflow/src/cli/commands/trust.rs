//! `kinfold trust`: approves a configuration that was found in a folder, once it was read.

use std::path::Path;

use adapters::config::Draft;
use serde_json::json;

use super::providers::{self, DEFAULT};
use crate::cli::args::TrustArgs;
use crate::cli::speech::{Answer, Complaint};
use crate::cli::trust::{Approval, Approvals, TrustError};

/// Says what a configuration would do and approves it, or lists approvals, or takes one back.
///
/// # Errors
/// [`Complaint`] when the configuration or the list of approvals cannot be read or written.
pub fn trust(args: &TrustArgs) -> Result<Answer, Complaint> {
    let approvals = Approvals::of_user().map_err(|e| complaint(&e))?;
    let file = args.file.as_deref().unwrap_or(Path::new(DEFAULT));
    if args.list {
        return list(&approvals, args.json);
    }
    if args.remove {
        let removed = approvals.remove(file).map_err(|e| complaint(&e))?;
        return Ok(Answer::done(match (args.json, removed) {
            (true, _) => format!("{:#}\n", json!({ "removed": removed })),
            (false, 0) => {
                format!("{}: was not trusted\n", guard::text::shown(&file.to_string_lossy()))
            }
            (false, _) => {
                format!("{}: no longer trusted\n", guard::text::shown(&file.to_string_lossy()))
            }
        }));
    }
    let draft = Draft::read(file).map_err(|e| providers::complaint(&e))?;
    let acts = draft.acts();
    let approval = approvals.add(&draft).map_err(|e| complaint(&e))?;
    Ok(Answer::done(told(&approval, &acts, args.json)))
}

fn told(approval: &Approval, acts: &[String], json: bool) -> String {
    if json {
        return format!("{:#}\n", json!({ "trusted": approval, "acts": acts }));
    }
    let mut lines = format!("{}: trusted until it changes\n", guard::text::shown(&approval.path));
    for act in acts {
        lines += &format!("  {}\n", guard::text::shown(act));
    }
    lines
}

fn list(approvals: &Approvals, json: bool) -> Result<Answer, Complaint> {
    let all = approvals.all().map_err(|e| complaint(&e))?;
    if json {
        return Ok(Answer::done(format!("{:#}\n", json!(all))));
    }
    let line = |a: &Approval| format!("{} {}\n", a.digest.short(), guard::text::shown(&a.path));
    Ok(Answer::done(all.iter().map(line).collect::<String>()))
}

fn complaint(error: &TrustError) -> Complaint {
    let complaint = Complaint::from_error(error);
    match error {
        TrustError::Nowhere => complaint.hint("name the file each time, with --config FILE"),
        TrustError::Line { .. } => complaint.hint("remove that line"),
        TrustError::Io { .. } | TrustError::Refused { .. } => complaint,
    }
}
