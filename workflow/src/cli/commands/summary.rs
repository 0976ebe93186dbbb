//! What is said about a run that came to its end.

use std::path::PathBuf;

use runner::outcome::NodeOutcome;
use runner::{Artefact as _, Outcome, Stage as _};
use serde_json::{Value, json};
use sim_check::{Check, Tier, Verdict};

use super::question;
use crate::cli::args::MakeArgs;
use crate::cli::speech::{Answer, Complaint, Exit};
use crate::output::sureness;
use crate::stages::{Criticise, Export, Page, Pictures, WritePictures};

/// Failed checks or doubts that are named in one line.
const SHOWN: usize = 3;

/// Where what was made stands.
#[derive(Clone, Debug)]
pub struct Shipped {
    /// The folder.
    pub place: PathBuf,
    /// Why it stands beside the output folder and not in it; none where it is in it.
    pub better: Option<String>,
}

/// What is said at the end of a finished run.
pub fn answer(
    outcome: &Outcome,
    (verdict, confidence): (&Verdict, Option<f64>),
    shipped: &Shipped,
    args: &MakeArgs,
) -> Answer {
    let notes = outcome.nodes.iter().flat_map(|n| &n.notes);
    let losses: Vec<_> = notes.filter(|n| n.loss).map(|n| n.message.clone()).collect();
    let below = below(verdict, args.tier);
    let unsure = sureness::too_unsure(confidence, args.min_confidence);
    let reason = below.clone().or_else(|| losses.first().map(|loss| format!("lost: {loss}")));
    let reason = reason.or_else(|| unsure.clone());
    let doubts = sureness::doubts(verdict);
    let asked = args.ask.then(|| question::of_outcome(outcome)).flatten();
    let exit = if reason.is_none() { Exit::Done } else { Exit::Losses };
    let warnings = warnings(outcome);
    let shown = |name: &str| shipped.place.join(name).display().to_string();
    // Page and pictures are there for people, as the views are; machines find them by names of their own.
    let formats = args.exports().into_iter().filter(|e| !e.is_for_looking());
    let package = |e: Export| e.package().map(|package| package.shown);
    let name = |e: Export| e.stage_and_file().map(|(_, file)| file).or_else(|| package(e));
    let others: Vec<_> = formats.filter_map(name).map(shown).collect();
    let urdf = shown("asset.urdf");
    let result = if args.json {
        let mut value = json!({
            "outcome": match () {
                () if below.is_some() => "below the tier",
                () if !losses.is_empty() => "done with losses",
                () if unsure.is_some() => "below the confidence",
                () => "done",
            },
            "reason": reason,
            "urdf": urdf,
            "published": shipped.better.is_none(),
            "exports": others,
            "page": shown(Page::FILE_NAME),
            "pictures": pictures(outcome).iter().map(|name| shown(name)).collect::<Vec<_>>(),
            "tier": verdict.tier.name(),
            "tier_asked": args.tier.name(),
            "failures": verdict.failures().map(|c| c.id.as_str()).collect::<Vec<_>>(),
            "losses": losses,
            "confidence": confidence,
            "doubts": doubts,
            "trace": shown("trace.mcap"),
            "stages": outcome.nodes.iter().filter(|n| n.key.is_some()).map(stage).collect::<Vec<_>>(),
        });
        if args.ask {
            value["question"] = json!(asked);
        }
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
    let mut remarks: Vec<_> = losses.iter().map(|loss| format!("lost: {loss}")).collect();
    remarks.extend(below);
    remarks.extend(unsure);
    remarks.extend(doubtful(&doubts));
    if args.ask {
        remarks.extend(asked.map_or_else(nothing_to_ask, |asked| question::lines(&asked)));
    }
    remarks.extend(shipped.better.iter().map(|why| format!("not published, because {why}")));
    remarks.extend(warnings.into_iter().flatten().map(|w| format!("warning: {w}")));
    Answer { result, remarks, exit }
}

/// What is doubtful, in one line; none where nothing is.
fn doubtful(doubts: &[&str]) -> Option<String> {
    let mut told = doubts.iter().take(SHOWN).copied().collect::<Vec<_>>().join("; ");
    let more = doubts.len().saturating_sub(SHOWN);
    if more > 0 {
        told.push_str(&format!("; and {more} more"));
    }
    (!doubts.is_empty()).then(|| format!("doubtful: {told}"))
}

fn nothing_to_ask() -> Vec<String> {
    vec!["question: none; nothing is in doubt, or nobody says how sure it is".into()]
}

/// The names of the pictures that were drawn.
fn pictures(outcome: &Outcome) -> Vec<String> {
    let drawn = outcome.artefact::<_, Pictures>(WritePictures::NAME);
    drawn.map(|pictures| pictures.0.into_keys().collect()).unwrap_or_default()
}

/// Why an asset is below the tier asked for, in a line; none if it is not.
fn below(verdict: &Verdict, asked: Tier) -> Option<String> {
    if verdict.tier >= asked {
        return None;
    }
    let failures: Vec<_> = verdict.failures().map(failure).collect();
    let more = failures.len().saturating_sub(SHOWN);
    let mut told = failures.into_iter().take(SHOWN).collect::<Vec<_>>().join("; ");
    if more > 0 {
        told.push_str(&format!("; and {more} more"));
    }
    let (tier, asked) = (verdict.tier.name(), asked.name());
    Some(format!("the asset reaches tier {tier}, asked for {asked}: {told}"))
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

fn failure(check: &Check) -> String {
    let evidence = check.evidence.first().map(|e| format!(" ({e})")).unwrap_or_default();
    format!("{} {}{evidence}", check.id, check.rule)
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
