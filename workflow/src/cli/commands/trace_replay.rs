//! `kinfold trace replay`: the whole flow again, from nothing but its trace, without a network.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use adapters::kept::Kept;
use adapters::net::tape::{Bodies, Exchange};
use adapters::replay::Replay;
use adapters::{Config, Critic, Critique, GeneratedMesh, ImageTo3d, Photo, Vlm};
use model::Choice;
use object::Condition;
use runner::observe::Quiet;
use runner::ours::{Turns, scratch};
use runner::outcome::NodeOutcome;
use runner::{AlwaysOpen, Artefact, Cancel, Ending, Limits, Outcome, RunOptions, StateDir};
use serde_json::json;
use trace::verify::CALL_BODY;
use trace::{Digest, FixedClock, Happening, Manifest, Reading, StageEvent};

use super::make::out_complaint;
use super::sealed;
use crate::cli::speech::{Answer, Complaint};
use crate::image_to_urdf::image_to_urdf;
use crate::output::{self, OutFolder};
use crate::stages::{Export, Tools};

/// Runs the flow of a trace again and compares every artefact. Exit 1 with the first difference.
///
/// # Errors
/// [`Complaint`] when the trace is not whole, or when anything comes out other than recorded.
pub fn replay(file: &Path, out: Option<&Path>, json: bool) -> Result<Answer, Complaint> {
    let named =
        |c: Complaint| Complaint { message: format!("{}: {}", file.display(), c.message), ..c };
    let (bytes, reading) = sealed::sealed_bytes(file).map_err(named)?;
    let outcome = again(&reading).map_err(named)?;
    same(&reading, &outcome).map_err(named)?;
    if let Some(out) = out {
        ship(&bytes, &reading, &outcome, out)?;
    }
    let stages =
        outcome.nodes.iter().filter_map(|n| Some((n.stage, n.output.as_ref()?.0.to_string())));
    let stages: Vec<_> = stages.collect();
    if json {
        let stages: BTreeMap<_, _> = stages.into_iter().collect();
        return Ok(Answer::done(format!("{:#}\n", json!({ "same": true, "artefacts": stages }))));
    }
    let line = |(stage, digest): &(&str, String)| {
        format!("{stage:<18} {} same\n", digest.get(..12).unwrap_or(digest))
    };
    Ok(Answer::done(stages.iter().map(line).collect::<String>()))
}

/// What the flow of a trace comes to when it is run again.
///
/// # Errors
/// [`Complaint`] when the trace lacks what a run begins with.
pub(super) fn again(reading: &Reading) -> Result<Outcome, Complaint> {
    let manifest = reading.manifest.as_ref().ok_or_else(|| missing("its manifest"))?;
    let photo = reading.pictures.iter().find(|p| p.topic == "/input/photo");
    let photo = photo.ok_or_else(|| missing("the photo"))?.bytes.clone();
    let photo = Photo::read(photo, "photo").map_err(|e| Complaint::from_error(&e))?;
    let folder = scratch::folder();
    let folder = folder.map_err(|e| Complaint::failed(format!("no folder to work in: {e}")))?;
    let state = StateDir::open(folder.path()).map_err(|e| Complaint::from_error(&e))?;
    let tools = Arc::new(tools(reading, manifest, state.scratch())?);
    let clock = Arc::new(FixedClock(reading.events.first().map_or(0, |(at, _)| *at)));
    let (limits, cancel, version) =
        (Limits::default(), Cancel::default(), manifest.version.clone());
    let options =
        RunOptions { limits, cancel, clock, version, gate: Arc::new(AlwaysOpen), workers: None };
    let flow = image_to_urdf(photo, &exports(manifest), tools.criticise());
    let ran = runner::run(&flow, &tools, &state, &options, &mut Quiet);
    ran.map_err(|e| Complaint::from_error(&e))
}

fn missing(what: &str) -> Complaint {
    Complaint::failed(format!("it lacks {what}, so it cannot be run again"))
}

fn exports(manifest: &Manifest) -> Vec<Export> {
    let named = manifest.parameters.get("export").and_then(|v| v.as_array());
    let named: Vec<_> = named.into_iter().flatten().filter_map(|v| v.as_str()).collect();
    let asked = |e: &Export| *e == Export::Urdf || named.contains(&e.name());
    Export::ALL.into_iter().filter(asked).collect()
}

fn tools(
    reading: &Reading,
    manifest: &Manifest,
    scratch: std::path::PathBuf,
) -> Result<Tools, Complaint> {
    let config = manifest.parameters.get("providers").cloned().unwrap_or_default();
    let config: Option<Config> = serde_json::from_value(config)
        .map_err(|e| Complaint::failed(format!("its list of providers cannot be read: {e}")))?;
    // What was spent then is not spent again.
    let config = Config { budget: Default::default(), ..config.unwrap_or_default() };
    let said = |stage| said(reading, stage);
    let adapter = |e: &adapters::AdapterError| Complaint::from_error(e);
    let asked = said("generate-mesh")?.image_to_3d(&config).map_err(|e| adapter(&e))?;
    let image_to_3d = match asked.filter(|_| called(reading, "generate-mesh")) {
        Some(generator) => generator,
        None => kept_mesh(reading)?,
    };
    let vlm = match said("propose-condition")?.vlm(&config).map_err(|e| adapter(&e))? {
        Some(vlm) => vlm,
        None => kept_condition(reading)?,
    };
    let asked = said("criticise")?.critic(&config).map_err(|e| adapter(&e))?;
    let critic = asked.map(|critic| lost_critique(reading).unwrap_or(critic));
    let articulate = model::articulator(Choice::default());
    Ok(Tools { image_to_3d, vlm, critic, articulate, seed: manifest.seed, scratch })
}

/// A critique that was lost, for whatever reason, is lost again: not everything that can keep an
/// answer from coming is a call.
fn lost_critique(reading: &Reading) -> Option<Box<dyn Critic>> {
    let (identity, answer) = kept::<Critique>(reading, "criticise").ok()?;
    matches!(answer, Critique::Lost(_)).then(|| Box::new(Kept { identity, answer }) as _)
}

/// Whether a stage asked somebody through the network.
fn called(reading: &Reading, stage: &str) -> bool {
    reading.events.iter().any(|(_, e)| e.stage == stage && !e.calls.is_empty())
}

/// What was said for one stage, and nobody who could say or do anything else.
fn said(reading: &Reading, stage: &str) -> Result<Replay, Complaint> {
    let named = |digest: &Digest| {
        reading.events.iter().any(|(_, e)| e.stage == stage && e.calls.contains(digest))
    };
    let calls = reading.calls.iter().filter(|c| named(&Digest::of(c)));
    let calls: Result<Vec<Exchange>, _> = calls.map(|c| serde_json::from_slice(c)).collect();
    let calls = calls.map_err(|e| Complaint::failed(format!("a call in it is damaged: {e}")))?;
    Ok(Replay::new(calls, bodies(reading)))
}

fn bodies(reading: &Reading) -> Bodies {
    let body = |kept: &trace::reader::Kept| {
        Some((Digest::parse(kept.name.strip_prefix(CALL_BODY)?)?, kept.bytes.clone()))
    };
    reading.attachments.iter().filter_map(body).collect()
}

/// The mesh as it was given, or as a program made it: none is ever run again.
fn kept_mesh(reading: &Reading) -> Result<Box<dyn ImageTo3d>, Complaint> {
    let (identity, answer) = kept::<GeneratedMesh>(reading, "generate-mesh")?;
    Ok(Box::new(Kept { identity, answer }))
}

fn kept_condition(reading: &Reading) -> Result<Box<dyn Vlm>, Complaint> {
    let (identity, answer) = kept::<Condition>(reading, "propose-condition")?;
    Ok(Box::new(Kept { identity, answer }))
}

fn kept<A: Artefact<Tools>>(reading: &Reading, stage: &str) -> Result<(String, A), Complaint> {
    let event = finished(reading, stage).ok_or_else(|| missing(&format!("what {stage} made")))?;
    let made = event.outputs.first().map(|o| &o.digest);
    let file = reading.attachments.iter().find(|a| made == Some(&Digest::of(&a.bytes)));
    let file = file.ok_or_else(|| missing(&format!("what {stage} made")))?;
    let answer = A::decode(&file.bytes).map_err(|e| Complaint::from_error(&e))?;
    Ok((event.identity.clone().unwrap_or_default(), answer))
}

fn finished<'a>(reading: &'a Reading, stage: &str) -> Option<&'a StageEvent> {
    let done = |e: &&StageEvent| e.stage == stage && e.event == Happening::Finished;
    reading.events.iter().map(|(_, e)| e).find(done)
}

/// The first stage that came out other than recorded.
fn same(reading: &Reading, outcome: &Outcome) -> Result<(), Complaint> {
    let differs = |what: String| {
        let made = reading.manifest.as_ref().map_or("", |m| m.version.as_str());
        let hint = format!(
            "the trace was written by kinfold {made}, this is {}; other code may give other bytes",
            env!("CARGO_PKG_VERSION")
        );
        Err(Complaint::failed(what).hint(hint))
    };
    let failed = reading.events.iter().find(|(_, e)| e.event == Happening::Failed);
    match (&outcome.ending, failed) {
        (Ending::Done, Some((_, event))) => {
            return differs(format!(
                "{}: recorded is a failure, this time it succeeds",
                event.stage
            ));
        }
        (Ending::Failed { stage, error }, failed) => {
            let recorded = failed.map(|(_, e)| (e.stage.as_str(), e.notes.first()));
            if recorded != Some((stage, Some(&error.line()))) {
                return differs(format!("{stage}: recorded is no such failure: {}", error.line()));
            }
        }
        (Ending::Done, None) => {}
        (Ending::Interrupted(_), _) => return Err(Complaint::failed("interrupted")),
    }
    outcome.nodes.iter().try_for_each(|node| match unlike(reading, node) {
        Some(what) => differs(what),
        None => Ok(()),
    })
}

fn unlike(reading: &Reading, node: &NodeOutcome) -> Option<String> {
    let recorded = finished(reading, node.stage)?.outputs.first()?;
    let Some((found, _)) = &node.output else {
        return Some(format!("{}: made nothing this time", node.stage));
    };
    let (name, old, new) = (&recorded.name, recorded.digest.short(), found.short());
    (*found != recorded.digest)
        .then(|| format!("{}: {name}: recorded {old}, this time {new}", node.stage))
}

/// Puts the files into a folder, with the trace they follow from.
fn ship(trace: &[u8], reading: &Reading, outcome: &Outcome, out: &Path) -> Result<(), Complaint> {
    if !matches!(outcome.ending, Ending::Done) {
        return Err(Complaint::failed("the recorded run failed, so there is nothing to write"));
    }
    let exports = reading.manifest.as_ref().map(exports).unwrap_or_default();
    let files = output::files(outcome, &exports).map_err(Complaint::from_stage)?;
    let turns = Turns { wait: true, tell: true };
    let out = OutFolder::open(out, turns).map_err(|e| out_complaint(&e))?;
    let attempt = out.begin().map_err(|e| out_complaint(&e))?;
    let copied = std::fs::write(attempt.trace(), trace);
    copied.map_err(|e| Complaint::failed(format!("the trace cannot be copied: {e}")))?;
    // A signature that goes was of what stood there before; the replay ships its own trace.
    attempt.publish(&files).map(drop).map_err(|e| out_complaint(&e))
}
