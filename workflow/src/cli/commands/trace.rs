//! `kinfold trace show`: what happened in a run, and how far it went.

use std::fmt::Write as _;
use std::path::Path;

use adapters::net::tape::{Exchange, Outcome};
use guard::text::shown;
use serde_json::json;
use trace::{Digest, Happening, Reading, StageEvent, Time};

use super::by_hand::{self, by_hand};
use crate::cli::speech::{Answer, Complaint, Exit};

/// Shows a trace. Exit 3 if it is torn, damaged or its chain of events does not hold.
///
/// # Errors
/// [`Complaint`] when the file cannot be read or is no trace.
pub fn show(file: &Path, json: bool) -> Result<Answer, Complaint> {
    let reading = trace::read(file).map_err(|e| Complaint::from_error(&e))?;
    let result = if json { as_json(&reading)? } else { as_text(&reading) };
    let name = file.display();
    let mut remarks = Vec::new();
    if let Some(torn) = &reading.torn {
        remarks.push(format!("{name}: incomplete, everything before this was read: {torn}"));
    }
    if !reading.chain_holds {
        remarks.push(format!("{name}: an event does not name the digest of the one before it"));
    }
    let exit = if remarks.is_empty() { Exit::Done } else { Exit::Losses };
    Ok(Answer { result, remarks, exit })
}

fn as_json(reading: &Reading) -> Result<String, Complaint> {
    let event = |(at, event): &(Time, StageEvent)| json!({ "time_ns": at, "event": event });
    let kept = |k: &trace::reader::Kept| json!({ "name": k.name, "media_type": k.media_type, "bytes": k.bytes.len() });
    let value = json!({
        "manifest": reading.manifest,
        "events": reading.events.iter().map(event).collect::<Vec<_>>(),
        "attachments": reading.attachments.iter().map(kept).collect::<Vec<_>>(),
        "by_hand": by_hand::as_json(&by_hand(reading)),
        "topics": reading.topics,
        "verdict": reading.verdict,
        "torn": reading.torn,
        "chain_holds": reading.chain_holds,
    });
    let text = serde_json::to_string_pretty(&value);
    text.map(|t| t + "\n").map_err(|e| Complaint::from_error(&e))
}

fn as_text(reading: &Reading) -> String {
    let mut out = String::new();
    if let Some(m) = &reading.manifest {
        let run = shown(m.run_id.get(..12).unwrap_or(&m.run_id));
        let (flow, version) = (shown(&m.flow), shown(&m.version));
        let _ = writeln!(out, "run {run}  {flow} {version}  seed {}", m.seed);
        for (name, digest) in &m.inputs {
            let _ = writeln!(out, "  input {} {}", shown(name), digest.short());
        }
    }
    let start = reading.events.first().map_or(0, |(at, _)| *at);
    for (at, event) in &reading.events {
        let _ = writeln!(out, "{}", shown(&line(at.saturating_sub(start), event)));
        let who = who(event, reading).into_iter();
        who.chain(event.notes.iter().map(|note| format!("note: {note}"))).for_each(|told| {
            let _ = writeln!(out, "{:>34}{}", "", shown(&told));
        });
    }
    for by in by_hand(reading) {
        let _ = writeln!(out, "by hand {:<22} {}", shown(&by.part), by.given.join(", "));
    }
    for (topic, count) in &reading.topics {
        let _ = writeln!(out, "topic {:<24} {count} messages", shown(topic));
    }
    for kept in &reading.attachments {
        let _ = writeln!(out, "file  {:<24} {} bytes", shown(&kept.name), kept.bytes.len());
    }
    let tier = reading.verdict.as_ref().and_then(|v| v.get("tier")?.as_str());
    let _ = writeln!(out, "{}", shown(&ending(reading, tier)));
    out
}

/// Who did a stage's work, and what was asked of whom for it.
fn who(event: &StageEvent, reading: &Reading) -> Vec<String> {
    if event.event == Happening::Started {
        return Vec::new();
    }
    let by = event.identity.iter().map(|identity| format!("by {identity}"));
    let is_mine = |bytes: &&Vec<u8>| event.calls.contains(&Digest::of(bytes));
    let calls = reading.calls.iter().filter(is_mine);
    let calls: Vec<_> = calls.filter_map(|b| serde_json::from_slice(b).ok()).map(asked).collect();
    let count = format!("{} call{}", calls.len(), if calls.len() == 1 { "" } else { "s" });
    let asked = (!calls.is_empty()).then(|| format!("{count}: {}", calls.join(", ")));
    by.chain(asked).collect()
}

/// A call: what it was for, and what came of it where that was no answer.
fn asked(call: Exchange) -> String {
    match call.outcome {
        Outcome::Answered { status: 200..=299, .. } => call.step,
        Outcome::Answered { status, .. } => format!("{} ({status})", call.step),
        Outcome::Unanswered(_) => format!("{} (no answer)", call.step),
    }
}

fn line(since: Time, event: &StageEvent) -> String {
    let word = match event.event {
        Happening::Started => "started",
        Happening::Finished => "finished",
        Happening::Failed => "failed",
    };
    let made = event.outputs.first().map(|o| format!("{} {}", o.name, o.digest.short()));
    let seconds = since as f64 / 1e9;
    let line =
        format!("{seconds:>9.3} s  {:<18} {word:<9} {}", event.stage, made.unwrap_or_default());
    line.trim_end().to_owned()
}

fn ending(reading: &Reading, tier: Option<&str>) -> String {
    let last = reading.events.last().map(|(_, e)| (e.event, e.stage.as_str()));
    match (tier, last) {
        (Some(tier), _) => format!("verdict: tier {tier}"),
        (None, Some((Happening::Failed, stage))) => format!("no verdict: {stage} failed"),
        (None, Some((Happening::Started, stage))) => format!("no verdict: it ends inside {stage}"),
        (None, Some((Happening::Finished, stage))) => format!("no verdict: it ends after {stage}"),
        (None, None) => "no verdict: it ends before the first stage".into(),
    }
}
