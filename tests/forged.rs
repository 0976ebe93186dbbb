//! Traces as a stranger could send them: whole, sealed, and saying whatever he likes.

use std::path::Path;

use adapters::net::tape::Exchange;
use serde_json::json;
use trace::verify::CALL_BODY;
use trace::{Digest, Happening, Reading, Recorder, StageEvent};

/// Writes down a reading as a trace that is sealed and holds together.
pub fn write(path: &Path, reading: &Reading) {
    let manifest = reading.manifest.clone().unwrap();
    let mut recorder = Recorder::create(path, &manifest, 0).unwrap();
    for file in reading.attachments.iter().filter(|a| a.name != "manifest.json") {
        recorder.attach(&file.name, &file.media_type, &file.bytes, 0).unwrap();
    }
    for picture in &reading.pictures {
        recorder.image(&picture.topic, "png", &picture.bytes, 0).unwrap();
    }
    for call in &reading.calls {
        let call: Exchange = serde_json::from_slice(call).unwrap();
        recorder.call(&call, &json!({ "type": "object" }), 0).unwrap();
    }
    for (at, event) in &reading.events {
        recorder.stage(event, *at).unwrap();
    }
    let end = reading.events.last().map_or(0, |(at, _)| *at);
    if let Some(verdict) = &reading.verdict {
        recorder.verdict(verdict, end).unwrap();
    }
    recorder.finish().unwrap();
}

/// The event with which a stage ended well.
pub fn finished<'a>(reading: &'a mut Reading, stage: &str) -> &'a mut StageEvent {
    let events = reading.events.iter_mut().map(|(_, event)| event);
    let mut done = events.filter(|e| e.stage == stage && e.event == Happening::Finished);
    done.next().unwrap()
}

/// Lets a stage have made a call that nobody made.
pub fn add_call(reading: &mut Reading, stage: &str) {
    let body = b"{}".to_vec();
    let digest = Digest::of(&body);
    let call = json!({
        "step": "hunyuan.submit", "method": "POST", "url": "http://127.0.0.1:1/send",
        "headers": [], "body": digest, "key": digest,
        "outcome": { "answered": { "status": 200, "headers": [], "body": digest } },
    });
    let call: Exchange = serde_json::from_value(call).unwrap();
    let bytes = serde_json::to_vec(&call).unwrap();
    finished(reading, stage).calls.push(Digest::of(&bytes));
    reading.calls.push(bytes);
    let (name, media_type) = (format!("{CALL_BODY}{digest}"), "application/json".into());
    reading.attachments.push(trace::reader::Kept { name, media_type, bytes: body });
}

/// Takes a file out of the trace that a stage made; its digest stays.
pub fn drop_file(reading: &mut Reading, name: &str) {
    let before = reading.attachments.len();
    reading.attachments.retain(|a| a.name != name);
    assert!(reading.attachments.len() < before, "no {name} in the trace");
}
