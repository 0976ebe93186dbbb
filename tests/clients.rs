//! Other people's simulators load what we write, with every joint and every shape and without a
//! warning.
//!
//! `KINFOLD_ASSETS` names a folder of assets made with every format (one folder each) to be loaded
//! besides the examples.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::Value;

use crate::cases;

/// One line of `clients.py`.
pub struct Answer {
    pub client: String,
    pub file: PathBuf,
    pub json: Value,
}

/// Warnings that stand: URDF has dry friction and we write it, Drake's plant has none.
const EXCUSED: &[&str] = &["does not currently support non-zero joint friction"];

/// The folders of assets named by `KINFOLD_ASSETS`, sorted; none where it is not set.
pub fn more_assets() -> Vec<PathBuf> {
    let Some(folder) = std::env::var_os("KINFOLD_ASSETS") else { return vec![] };
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let mut folders: Vec<_> = entries.filter(|e| e.join("asset.urdf").is_file()).collect();
    folders.sort();
    folders
}

/// Asks every client about every file, two files at a time; answers in the order of files.
pub fn ask_all(python: &Path, files: &[PathBuf]) -> Vec<Answer> {
    let (next, answers) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    let work = || loop {
        let index = next.fetch_add(1, Ordering::Relaxed);
        let Some(file) = files.get(index) else { return };
        let found = ask(python, std::slice::from_ref(file));
        answers.lock().unwrap().insert(index, found);
    };
    std::thread::scope(|s| {
        s.spawn(work);
        s.spawn(work);
    });
    answers.into_inner().unwrap().into_values().flatten().collect()
}

/// Asks every client about every file.
pub fn ask(python: &Path, files: &[PathBuf]) -> Vec<Answer> {
    said(Command::new(python).arg(SCRIPT).args(files))
}

/// Asks one client about one file.
pub fn ask_one(python: &Path, client: &str, file: &Path) -> Answer {
    let mut answers = said(Command::new(python).arg(SCRIPT).args(["--only", client]).arg(file));
    assert_eq!(answers.len(), 1, "{client} {}", file.display());
    answers.remove(0)
}

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/clients.py");

fn said(command: &mut Command) -> Vec<Answer> {
    let output = command.output().unwrap();
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

/// What is wrong with an answer about a URDF: other counts than the file's, or a warning.
fn complaint(answer: &Answer) -> Option<String> {
    let (shapes, joints) = counts(&answer.file);
    let found = ["joints", "shapes"].map(|key| answer.json[key].as_u64());
    let warnings = answer.json["warnings"].as_array().into_iter().flatten();
    let is_excused = |w: &&Value| EXCUSED.iter().any(|e| w.as_str().unwrap().contains(e));
    let warnings: Vec<_> = warnings.filter(|w| !is_excused(w)).collect();
    let is_good = found == [Some(joints), Some(shapes)] && shapes > 0 && warnings.is_empty();
    let (client, file, error) = (&answer.client, answer.file.display(), &answer.json["error"]);
    (!is_good).then(|| format!("{client} {file}: {found:?} {warnings:?} {error}"))
}

#[test]
fn simulators_load_made_assets_with_every_joint_and_shape_and_no_warning() {
    let out = tempfile::tempdir().unwrap();
    let mut urdfs: Vec<_> = crate::examples::made(out.path());
    urdfs.extend(more_assets().into_iter().map(|folder| folder.join("asset.urdf")));
    let all = "mujoco, pybullet, pinocchio, pydrake, yourdfpy";
    let pythons = [cases::python_with(all), cases::python_of_usd()];
    for python in pythons.into_iter().flatten() {
        let answers = ask_all(&python, &urdfs);
        let clients: BTreeSet<_> = answers.iter().map(|a| a.client.as_str()).collect();
        eprintln!("{} assets in {clients:?}", urdfs.len());
        let complaints: Vec<_> = answers.iter().filter_map(complaint).collect();
        assert!(complaints.is_empty(), "{}:\n{}", complaints.len(), complaints.join("\n"));
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
    for stage in
        flow.into_iter().chain(["shape-parts", "build-asset", "write-urdf", "check-in-sim"])
    {
        assert!(stages.iter().any(|s| s == stage), "{stage} is missing of {stages:?}");
    }
    let topics = answers[0].json["topics"].as_object().unwrap();
    for topic in ["/stage", "/scene", "/tf", "/joints", "/verdict", "/input/photo"] {
        assert!(topics.contains_key(topic), "{topic} is missing of {:?}", topics.keys());
    }
}
