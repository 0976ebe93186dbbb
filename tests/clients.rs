//! Other people's simulators load what we write, with every joint and every shape.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::cases;

/// One line of `clients.py`.
pub struct Answer {
    pub client: String,
    pub file: PathBuf,
    pub json: Value,
}

impl Answer {
    pub fn count(&self, key: &str) -> u64 {
        self.json[key].as_u64().unwrap_or_else(|| panic!("{}: {}", self.client, self.json))
    }
}

/// Asks every client about every file.
pub fn ask(python: &Path, files: &[PathBuf]) -> Vec<Answer> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/clients.py");
    let output = Command::new(python).arg(script).args(files).output().unwrap();
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer = |line: &str| {
        let json: Value = serde_json::from_str(line).unwrap();
        let text = |key: &str| json[key].as_str().unwrap().to_string();
        Answer { client: text("client"), file: text("file").into(), json }
    };
    lines.lines().map(answer).collect()
}

/// Links with collision and moving joints of a URDF, as its text has them.
pub fn counts(urdf: &Path) -> (u64, u64) {
    let text = std::fs::read_to_string(urdf).unwrap();
    let count = |pattern: &str| text.matches(pattern).count() as u64;
    let moving = ["revolute", "continuous", "prismatic"];
    (count("<collision"), moving.iter().map(|kind| count(&format!("type=\"{kind}\""))).sum())
}

#[test]
fn simulators_load_the_examples_with_every_joint_and_shape() {
    let Some(python) = cases::python() else { return };
    let out = tempfile::tempdir().unwrap();
    let urdfs: Vec<_> = crate::examples::made(out.path());
    for answer in ask(&python, &urdfs) {
        let (shapes, joints) = counts(&answer.file);
        assert!(shapes > 0);
        assert_eq!(answer.count("joints"), joints, "{} {}", answer.client, answer.file.display());
        assert_eq!(answer.count("shapes"), shapes, "{} {}", answer.client, answer.file.display());
    }
}

#[test]
fn pythons_mcap_reader_opens_a_trace_with_every_stage_present() {
    let Some(python) = cases::python() else { return };
    let out = tempfile::tempdir().unwrap();
    let urdf = crate::examples::made(out.path()).swap_remove(0);
    let answers = ask(&python, &[urdf.with_file_name("trace.mcap")]);
    let stages = answers[0].json["stages"].as_array().unwrap();
    let flow = ["generate-mesh", "render-views", "propose-condition", "articulate"];
    for stage in flow.into_iter().chain(["build-asset", "write-urdf", "check-in-sim"]) {
        assert!(stages.iter().any(|s| s == stage), "{stage} is missing of {stages:?}");
    }
    let topics = answers[0].json["topics"].as_object().unwrap();
    for topic in ["/stage", "/scene", "/tf", "/joints", "/verdict", "/input/photo"] {
        assert!(topics.contains_key(topic), "{topic} is missing of {:?}", topics.keys());
    }
}
