//! What is said about a run that came to its end.

use serde_json::{Value, json};
use sim_check::{Check, Tier, Verdict};

use crate::cli::MakeArgs;
use crate::dag::run::NodeOutcome;
use crate::dag::{Outcome, Stage as _};
use crate::output::OutFolder;
use crate::speech::{Answer, Complaint, Exit};
use crate::stages::{Checked, Criticise, Export};

/// What is said at the end of a finished run.
///
/// # Errors
/// [`Complaint`] when the verdict cannot be read.
pub fn answer(outcome: &Outcome, out: &OutFolder, args: &MakeArgs) -> Result<Answer, Complaint> {
    let checked = outcome.artefact::<Checked>("check-in-sim").map_err(Complaint::from_stage)?;
    let verdict = checked.verdict;
    let notes = outcome.nodes.iter().flat_map(|n| &n.notes);
    let losses: Vec<_> = notes.filter(|n| n.loss).map(|n| n.message.clone()).collect();
    let exit = if losses.is_empty() { Exit::Done } else { Exit::Losses };
    let warnings = warnings(outcome);
    let shown = |name: &str| out.path(name).display().to_string();
    let others = args.exports().into_iter().filter_map(Export::stage_and_file);
    let others: Vec<_> = others.map(|(_, file)| shown(file)).collect();
    let urdf = shown("asset.urdf");
    let result = if args.json {
        let mut value = json!({
            "outcome": if losses.is_empty() { "done" } else { "done with losses" },
            "urdf": urdf,
            "exports": others,
            "tier": verdict.tier.name(),
            "failures": verdict.failures().map(|c| c.id.as_str()).collect::<Vec<_>>(),
            "losses": losses,
            "trace": shown("trace.mcap"),
            "stages": outcome.nodes.iter().filter(|n| n.key.is_some()).map(stage).collect::<Vec<_>>(),
        });
        // A word about a critique only where one was asked for.
        if let Some(warnings) = &warnings {
            value["warnings"] = json!(warnings);
        }
        pretty(&value)
    } else {
        let files: String =
            std::iter::once(&urdf).chain(&others).map(|f| format!("{}\n", word(f))).collect();
        format!("{files}tier {}\n", verdict.tier.name())
    };
    let mut remarks = remarks(&verdict, &losses);
    remarks.extend(warnings.into_iter().flatten().map(|w| format!("warning: {w}")));
    Ok(Answer { result, remarks, exit })
}

/// What the critic flagged, or why it did not answer; none where nobody asked it.
fn warnings(outcome: &Outcome) -> Option<Vec<String>> {
    let critique = outcome.nodes.iter().find(|n| n.stage == Criticise::NAME)?;
    Some(critique.notes.iter().map(|n| n.message.clone()).collect())
}

fn stage(node: &NodeOutcome) -> Value {
    json!({
        "stage": node.stage,
        "ran": !node.recalled,
        "seconds": node.took.as_secs_f64(),
        "key": node.key.as_ref().map(ToString::to_string),
        "output": node.output.as_ref().map(|(digest, _)| digest.to_string()),
    })
}

fn remarks(verdict: &Verdict, losses: &[String]) -> Vec<String> {
    let mut remarks: Vec<_> = losses.iter().map(|loss| format!("lost: {loss}")).collect();
    if verdict.tier < Tier::Kinematic {
        let tier = verdict.tier.name();
        remarks.push(format!("the asset reaches tier {tier} only, below kinematic; what fails:"));
        remarks.extend(verdict.failures().take(12).map(failure));
    }
    remarks
}

fn failure(check: &Check) -> String {
    let evidence = check.evidence.first().map(|e| format!(": {e}")).unwrap_or_default();
    format!("  {:<3} {:<8} {}{evidence}", check.id, check.status.name(), check.rule)
}

/// The complaint with its words as JSON for stdout, where JSON was asked for.
pub fn with_result(complaint: Complaint, as_json: bool) -> Complaint {
    if !as_json {
        return complaint;
    }
    let interrupted = complaint.exit == Exit::Interrupted;
    let value = json!({
        "outcome": if interrupted { "interrupted" } else { "failed" },
        "error": complaint.message,
        "causes": complaint.causes,
        "hints": complaint.hints,
    });
    Complaint { result: pretty(&value), ..complaint }
}

/// A name on one line.
fn word(name: &str) -> std::borrow::Cow<'_, str> {
    guard::text::shown(name)
}

fn pretty(value: &Value) -> String {
    serde_json::to_string_pretty(value).unwrap_or_default() + "\n"
}
