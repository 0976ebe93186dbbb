//! Whether a trace is what it says: one chain from what was given to what was made.
//!
//! ```
//! use trace::verify;
//! # use trace::{Manifest, Recorder};
//! # let dir = tempfile::tempdir()?;
//! # let path = dir.path().join("trace.mcap");
//! # let (inputs, parameters) = Default::default();
//! # let (run_id, flow, version) = ("r".into(), "toy".into(), "1".into());
//! # let manifest = Manifest { run_id, flow, version, seed: 7, inputs, parameters };
//! # Recorder::create(&path, &manifest, 1)?.finish()?;
//!
//! let mut reading = trace::read(&path)?;
//! assert_eq!(verify::holds_together(&reading), Ok(()));
//! assert_eq!(verify::made(&reading).count(), 0);
//!
//! reading.manifest = None;
//! assert_eq!(verify::holds_together(&reading), Err("it has no manifest".to_owned()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::{BTreeMap, BTreeSet};

use crate::digest::Digest;
use crate::event::{ArtefactRef, Happening, StageEvent};
use crate::reader::Reading;

/// How the names of attachments begin that hold what was said in a call; the rest is its digest.
pub const CALL_BODY: &str = "calls/";
/// Where a call names the digests of what was said.
const BODIES: [&str; 2] = ["/body", "/outcome/answered/body"];

/// Checks that everything in a trace belongs together. The manifest comes first, and each event
/// names the one before it. Each stage was given what stages before it made. Every file, picture
/// and call is the one that an event names.
///
/// # Errors
/// The first thing that does not hold, in words.
pub fn holds_together(reading: &Reading) -> Result<(), String> {
    if let Some(torn) = &reading.torn {
        return Err(format!("it is incomplete: {torn}"));
    }
    if reading.manifest.is_none() {
        return Err("it has no manifest".to_owned());
    }
    if !reading.chain_holds {
        return Err("an event does not name the digest of the one before it".to_owned());
    }
    inputs_were_made(reading)?;
    files_are_named(reading)?;
    pictures_are_named(reading)?;
    calls_are_named(reading)?;
    calls_are_whole(reading)
}

/// Everything finished stages made, in order.
pub fn made(reading: &Reading) -> impl Iterator<Item = (&StageEvent, &ArtefactRef)> {
    let finished = reading.events.iter().filter(|(_, e)| e.event == Happening::Finished);
    finished.flat_map(|(_, e)| e.outputs.iter().map(move |o| (e, o)))
}

fn inputs_were_made<'a>(reading: &'a Reading) -> Result<(), String> {
    let known = |a: &'a ArtefactRef| (a.name.as_str(), &a.digest, a.bytes);
    let mut made = BTreeSet::new();
    let given = reading.manifest.iter().flat_map(|m| &m.inputs);
    let given: BTreeMap<_, _> = given.collect();
    for (_, event) in &reading.events {
        if let Some(input) = event.inputs.iter().find(|i| !made.contains(&known(i))) {
            let (stage, name) = (&event.stage, &input.name);
            let digest = input.digest.short();
            return Err(format!("{stage}: was given {name} {digest}, which no stage before made"));
        }
        made.extend(event.outputs.iter().map(known));
        let promised = given.get(&event.stage);
        let found = event.outputs.first().map(|o| &o.digest);
        if let Some((promised, found)) = promised.copied().zip(found).filter(|(p, f)| p != f) {
            let (stage, promised, found) = (&event.stage, promised.short(), found.short());
            return Err(format!("{stage}: the manifest says {promised}, found {found}"));
        }
    }
    Ok(())
}

fn files_are_named(reading: &Reading) -> Result<(), String> {
    let all: BTreeSet<_> = made(reading).map(|(_, o)| (o.name.as_str(), &o.digest)).collect();
    for file in &reading.attachments {
        let digest = Digest::of(&file.bytes);
        let named = match file.name.strip_prefix(CALL_BODY) {
            Some(name) => name == digest.as_str(),
            None if file.name == "manifest.json" => true,
            None => all.contains(&(file.name.as_str(), &digest)),
        };
        if !named {
            return Err(format!("{}: no event names {}", file.name, digest.short()));
        }
    }
    Ok(())
}

fn pictures_are_named(reading: &Reading) -> Result<(), String> {
    let all: BTreeSet<_> = made(reading).map(|(_, o)| &o.digest).collect();
    let named = |bytes: &[u8]| all.contains(&Digest::of(bytes));
    let unnamed = reading.pictures.iter().find(|picture| !named(&picture.bytes));
    let words = |topic: &str| format!("{topic}: no event names this picture");
    unnamed.map_or(Ok(()), |picture| Err(words(&picture.topic)))
}

fn calls_are_named(reading: &Reading) -> Result<(), String> {
    let found: Vec<_> = reading.calls.iter().map(|c| Digest::of(c)).collect();
    let named: Vec<_> = reading.events.iter().flat_map(|(_, e)| &e.calls).collect();
    let same = found.iter().eq(named.iter().copied());
    let counts = format!("{} calls stand in it, events name {}", found.len(), named.len());
    if same { Ok(()) } else { Err(format!("its calls are not the ones its events name: {counts}")) }
}

fn calls_are_whole(reading: &Reading) -> Result<(), String> {
    let kept: BTreeSet<_> = reading.attachments.iter().map(|a| a.name.as_str()).collect();
    for call in &reading.calls {
        let call: serde_json::Value =
            serde_json::from_slice(call).map_err(|e| format!("a call is no JSON: {e}"))?;
        let step = call.get("step").and_then(|s| s.as_str()).unwrap_or("a call");
        for digest in BODIES.iter().filter_map(|p| call.pointer(p)?.as_str()) {
            let name = format!("{CALL_BODY}{digest}");
            if !kept.contains(name.as_str()) {
                return Err(format!("{step}: what was said is missing: {name}"));
            }
        }
    }
    Ok(())
}
