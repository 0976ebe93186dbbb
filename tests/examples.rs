//! The examples in the repository run as the README says.

use std::path::{Path, PathBuf};

use assert_cmd::Command;

/// The folder of an example.
pub fn folder(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../examples")).join(name)
}

/// The names of all examples, sorted.
pub fn names() -> Vec<String> {
    let entries = std::fs::read_dir(folder("")).unwrap().map(|e| e.unwrap());
    let folders = entries.filter(|e| e.path().join("condition.json").is_file());
    let mut names: Vec<_> = folders.map(|e| e.file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// `kinfold make` on a folder with a photo, a mesh and a condition.
pub fn make(case: &Path, photo: &Path, out: &Path, state: &Path) -> Command {
    let mut command = Command::cargo_bin("kinfold").unwrap();
    command.arg("make").arg(photo);
    command.arg("--mesh").arg(case.join("mesh.glb"));
    command.arg("--condition").arg(case.join("condition.json"));
    command.arg("--out").arg(out).arg("--state").arg(state);
    command
}

/// Makes every example under `out` and returns their URDFs.
pub fn made(out: &Path) -> Vec<PathBuf> {
    let one = |name: &String| {
        let (case, target) = (folder(name), out.join(name));
        make(&case, &case.join("photo.png"), &target, &out.join("state")).assert().success();
        target.join("asset.urdf")
    };
    names().iter().map(one).collect()
}

#[test]
fn every_example_reaches_kinematic_or_better() {
    let out = tempfile::tempdir().unwrap();
    assert!(names().len() >= 3, "at least three examples");
    for urdf in made(out.path()) {
        let verdict = std::fs::read_to_string(urdf.with_file_name("verdict.json")).unwrap();
        let verdict: serde_json::Value = serde_json::from_str(&verdict).unwrap();
        let tier = verdict["tier"].as_str().unwrap();
        assert!(["kinematic", "dynamic", "audited"].contains(&tier), "{}: {tier}", urdf.display());
    }
}
