//! A trace comes back whole, comes back torn, and gives damage away.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]

use std::path::{Path, PathBuf};

use trace::{
    ArtefactRef, Digest, Happening, Manifest, Recorder, SceneLink, Severity, StageEvent, Transform,
};

const START: u64 = 1_700_000_000_000_000_000;

fn manifest() -> Manifest {
    Manifest {
        run_id: "r".into(),
        flow: "image-to-urdf".into(),
        version: "0.1.0".into(),
        seed: 7,
        inputs: [("photo".to_string(), Digest::of(b"photo"))].into(),
        parameters: Default::default(),
    }
}

fn event(stage: &str, event: Happening) -> StageEvent {
    let made = ArtefactRef { name: "out.json".into(), digest: Digest::of(b"{}"), bytes: 2 };
    let outputs = if event == Happening::Finished { vec![made] } else { vec![] };
    let (stage, key) = (stage.to_string(), "k".to_string());
    StageEvent {
        stage,
        event,
        key,
        identity: None,
        inputs: vec![],
        outputs,
        calls: vec![],
        notes: vec![],
        previous: None,
    }
}

/// Stages with everything a trace may hold; returns the length of the file after each sync.
fn record(path: &Path, stages: u64) -> Vec<u64> {
    let mut r = Recorder::create(path, &manifest(), START).unwrap();
    let mut synced = vec![std::fs::metadata(path).unwrap().len()];
    for i in 0..stages {
        let (stage, at) = (format!("stage-{i}"), START + i * 1_000);
        r.stage(&event(&stage, Happening::Started), at).unwrap();
        r.image("/views/front", "png", &[i as u8; 997], at).unwrap();
        r.log(Severity::Info, "a line", at).unwrap();
        r.scene(&[SceneLink { frame: "door".into(), glb: vec![3; 101] }], at).unwrap();
        let (translation, rotation) = ([0.0, 1.0, 2.0], [0.0, 0.0, 0.0, 1.0]);
        let pose = Transform { parent: "body".into(), child: "door".into(), translation, rotation };
        r.transforms(&[pose], at).unwrap();
        r.joints(&[("hinge".into(), 0.1 * i as f64)], at).unwrap();
        r.attach(&format!("file-{i}.bin"), "application/octet-stream", &[7; 211], at).unwrap();
        r.stage(&event(&stage, Happening::Finished), at).unwrap();
        r.sync().unwrap();
        synced.push(std::fs::metadata(path).unwrap().len());
    }
    r.verdict(&serde_json::json!({ "tier": "kinematic" }), START + 9_000).unwrap();
    r.finish().unwrap();
    synced
}

fn recorded() -> (tempfile::TempDir, PathBuf, Vec<u64>) {
    recorded_of(7)
}

fn recorded_of(stages: u64) -> (tempfile::TempDir, PathBuf, Vec<u64>) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("trace.mcap");
    let synced = record(&path, stages);
    (dir, path, synced)
}

#[test]
fn everything_written_comes_back() {
    let (_dir, path, _) = recorded();
    let reading = trace::read(&path).unwrap();
    assert_eq!(reading.manifest, Some(manifest()));
    assert_eq!(reading.events.len(), 14);
    assert!(reading.chain_holds && reading.torn.is_none());
    assert_eq!(reading.attachments.len(), 8);
    assert_eq!(reading.verdict.unwrap()["tier"], "kinematic");
    let topics: Vec<_> = reading.topics.iter().map(|(t, n)| (t.as_str(), *n)).collect();
    let each = ["/views/front", "/log", "/scene", "/tf", "/joints"];
    assert!(each.iter().all(|t| topics.contains(&(t, 7))), "{topics:?}");
}

#[test]
fn the_same_calls_give_the_same_bytes() {
    let (_a, first, _) = recorded();
    let (_b, second, _) = recorded();
    assert_eq!(std::fs::read(first).unwrap(), std::fs::read(second).unwrap());
}

#[test]
fn torn_anywhere_what_was_synced_is_read() {
    let (_dir, path, synced) = recorded();
    let bytes = std::fs::read(&path).unwrap();
    for cut in 1..bytes.len() {
        let reading = trace::read_bytes(&bytes[..cut], "torn").unwrap();
        let stages = synced.iter().filter(|&&s| s <= cut as u64).count().saturating_sub(1);
        assert!(
            reading.events.len() >= 2 * stages,
            "cut at {cut}: {} events",
            reading.events.len()
        );
        assert!(reading.chain_holds);
        assert!(cut < synced[0] as usize || reading.manifest.is_some());
    }
}

#[test]
fn a_flipped_bit_in_a_file_is_noticed() {
    let (_dir, path, _) = recorded();
    let mut bytes = std::fs::read(&path).unwrap();
    let at = bytes.windows(211).position(|w| w == [7; 211]).unwrap();
    bytes[at + 100] ^= 1;
    let torn = trace::read_bytes(&bytes, "flipped").unwrap().torn.unwrap();
    assert!(torn.starts_with("Attachment CRC failed"), "{torn}");
}

#[test]
fn no_bit_of_a_sealed_trace_can_change_unseen() {
    let (_dir, path, _) = recorded_of(1);
    let mut bytes = std::fs::read(&path).unwrap();
    trace::seal::check(&bytes).unwrap();
    for bit in 0..bytes.len() * 8 {
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(trace::seal::check(&bytes).is_err(), "bit {bit} changed unseen");
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn a_flipped_bit_never_ends_the_reader() {
    let (_dir, path, _) = recorded_of(1);
    let mut bytes = std::fs::read(&path).unwrap();
    // Steps that meet every place within a byte; lengths of records are among what is hit.
    for bit in (0..bytes.len() * 8).step_by(13) {
        bytes[bit / 8] ^= 1 << (bit % 8);
        // Any outcome but the end of the program is right.
        let _ = trace::read_bytes(&bytes, "flipped").is_ok();
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn a_trace_cut_anywhere_or_lengthened_has_no_seal() {
    let (_dir, path, _) = recorded_of(1);
    let bytes = std::fs::read(&path).unwrap();
    for cut in 0..bytes.len() {
        assert!(trace::seal::check(&bytes[..cut]).is_err(), "cut at {cut}");
    }
    assert!(trace::seal::check(&[&bytes[..], b"x"].concat()).is_err());
}

#[test]
fn calls_and_pictures_come_back_as_they_were() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("trace.mcap");
    let mut r = Recorder::create(&path, &manifest(), START).unwrap();
    let call = serde_json::json!({ "step": "meshy.submit" });
    let named = r.call(&call, &serde_json::json!({ "type": "object" }), START).unwrap();
    r.image("/input/photo", "png", &[5; 301], START).unwrap();
    r.finish().unwrap();
    let reading = trace::read(&path).unwrap();
    assert_eq!(reading.calls, [call.to_string().into_bytes()]);
    assert_eq!(Digest::of(&reading.calls[0]), named);
    assert_eq!(
        (reading.pictures[0].topic.as_str(), reading.pictures[0].bytes.len()),
        ("/input/photo", 301)
    );
}

#[test]
fn an_event_of_another_run_breaks_the_chain() {
    let dir = tempfile::tempdir().unwrap();
    let of = |seed: u64| {
        let path = dir.path().join(seed.to_string());
        let mut r = Recorder::create(&path, &Manifest { seed, ..manifest() }, START).unwrap();
        r.stage(&event("s", Happening::Started), START).unwrap();
        r.finish().unwrap();
        trace::read(&path).unwrap().events[0].1.previous.clone()
    };
    assert!(of(1).is_some() && of(1) != of(2));
}

#[test]
fn what_is_no_trace_is_refused() {
    let error = trace::read_bytes(b"not a trace", "x.mcap").unwrap_err().to_string();
    assert!(error.starts_with("x.mcap: not a kinfold trace"), "{error}");
    assert!(trace::read_bytes(&[], "empty").is_err());
}
