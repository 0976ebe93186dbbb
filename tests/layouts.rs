//! A trace in the viewers of others: what `docs/layouts` has for them.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::cases::python_with;
use crate::kinfold::Bench;

fn layouts() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/layouts")
}

/// Every text in a value.
fn texts(value: &Value) -> Vec<&str> {
    match value {
        Value::String(text) => vec![text],
        Value::Array(all) => all.iter().flat_map(texts).collect(),
        Value::Object(all) => all.values().flat_map(texts).collect(),
        _ => vec![],
    }
}

#[test]
fn the_layout_for_foxglove_shows_topics_that_a_trace_has() {
    let text = std::fs::read_to_string(layouts().join("kinfold.foxglove.json")).unwrap();
    let layout: Value = serde_json::from_str(&text).unwrap();
    let panels = layout["configById"].as_object().unwrap();
    let placed = texts(&layout["layout"]);
    let tabs = texts(&layout["configById"]["Tab!kinfold_more"]);
    for panel in panels.keys().map(String::as_str) {
        assert!(placed.contains(&panel) || tabs.contains(&panel), "{panel} is nowhere");
    }
    let trace = Bench::done().trace();
    let known: Vec<_> = trace.topics.iter().map(|(topic, _)| topic.as_str()).collect();
    let shown = panels.values().flat_map(texts).filter(|text| text.starts_with('/'));
    let shown = shown.map(|text| text.split('.').next().unwrap());
    let shown = shown.chain(["/scene"]).collect::<Vec<_>>();
    assert!(shown.len() > 5, "{shown:?}");
    for topic in shown {
        // A run that has nothing to say has no log.
        assert!(topic == "/log" || known.contains(&topic), "{topic} is not in {known:?}");
    }
}

#[test]
fn a_trace_becomes_a_recording_for_rerun_with_surfaces_poses_and_joints() {
    let Some(python) = python_with("rerun, mcap, mcap_protobuf") else { return };
    let bench = Bench::done();
    let run = |args: &[&str]| {
        let mut command = Command::new(&python);
        command.current_dir(bench.path("")).env("HOME", bench.path("")).args(args);
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{args:?}: {said}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let script = layouts().join("trace_to_rerun.py");
    run(&[script.to_str().unwrap(), "out/trace.mcap", "asset.rrd"]);
    let shown = run(&["-m", "rerun", "rrd", "print", "-vv", "asset.rrd"]);
    for found in [
        "/world/body/surface",
        "/world/body/door/surface",
        "Asset3D:blob",
        "Transform3D:quaternion",
        "/joints/door",
        "Scalars:scalars",
        "/pictures/input/photo",
        "/verdict",
        "motion",
    ] {
        assert!(shown.contains(found), "{found} is missing of {shown}");
    }
}
