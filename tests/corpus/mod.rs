//! Show that the checker misses nothing and raises no false alarm: good assets of many kinds, and
//! the same with one defect each.

mod defects;
mod good;
mod model;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::kinfold::program;
use defects::DEFECTS;
use model::Model;

/// Writes every good asset below a folder, each into its own; their URDFs.
pub fn written(folder: &Path) -> Vec<PathBuf> {
    let one = |(name, model): (&str, Model)| {
        model.write(&folder.join(name), name);
        folder.join(name).join(format!("{name}.urdf"))
    };
    good::all().into_iter().map(one).collect()
}

/// Writes assets below a folder, each into its own, and checks the folder: verdicts by name.
fn verdicts(folder: &Path, assets: &[(&str, Model)]) -> BTreeMap<String, Value> {
    for (name, model) in assets {
        model.write(&folder.join(name), name);
    }
    let mut command = program();
    let output = command.args(["check", "--tier", "dynamic", "--json"]).arg(folder).output();
    let text = String::from_utf8(output.unwrap().stdout).unwrap();
    let one = |line: &str| {
        let answer: Value = serde_json::from_str(line).unwrap();
        let file = Path::new(answer["file"].as_str().unwrap()).file_stem().unwrap();
        (file.to_str().unwrap().to_owned(), answer["verdict"].clone())
    };
    let verdicts: BTreeMap<_, _> = text.lines().map(one).collect();
    assert_eq!(verdicts.len(), assets.len(), "every asset has a name and a verdict of its own");
    verdicts
}

fn check<'a>(verdict: &'a Value, id: &str) -> &'a Value {
    let checks = verdict["checks"].as_array().unwrap();
    checks.iter().find(|c| c["id"] == id).unwrap_or_else(|| panic!("no check {id}"))
}

fn holds(verdict: &Value, id: &str) -> bool {
    ["pass", "warn"].contains(&check(verdict, id)["status"].as_str().unwrap())
}

/// What counts against a verdict, for the reader of a failed test.
fn told(verdict: &Value) -> String {
    let bad = |c: &&Value| {
        c["severity"] == "error" && ["fail", "unknown"].contains(&c["status"].as_str().unwrap())
    };
    let one = |c: &Value| format!("\n    {} {} {}", c["id"], c["status"], c["evidence"][0]);
    verdict["checks"].as_array().unwrap().iter().filter(bad).map(one).collect()
}

#[test]
fn good_assets_of_many_kinds_reach_dynamic() {
    let folder = tempfile::tempdir().unwrap();
    let assets = good::all();
    assert!(assets.len() >= 10);
    let verdicts = verdicts(folder.path(), &assets);
    let alarms = verdicts.iter().filter(|(_, v)| v["tier"] != "dynamic");
    let alarms: Vec<_> = alarms.map(|(name, v)| format!("{name}: {}", told(v))).collect();
    assert!(alarms.is_empty(), "{} false alarms:\n{}", alarms.len(), alarms.join("\n"));
}

#[test]
fn every_defect_is_caught_by_its_check_which_passes_without_it() {
    let folder = tempfile::tempdir().unwrap();
    assert!(DEFECTS.len() >= 40);
    let spoilt = |&(name, _, good, change): &defects::Defect| {
        let mut model = good();
        change(&mut model);
        (name, model)
    };
    let assets: Vec<_> = DEFECTS.iter().map(spoilt).collect();
    let found = verdicts(&folder.path().join("spoilt"), &assets);
    let sound: Vec<_> = DEFECTS.iter().map(|&(name, _, good, _)| (name, good())).collect();
    let sound = verdicts(&folder.path().join("sound"), &sound);
    let missed = DEFECTS.iter().filter(|(name, id, ..)| {
        holds(&found[*name], id) || !holds(&sound[*name], id) || found[*name]["tier"] == "dynamic"
    });
    let missed: Vec<_> =
        missed.map(|(name, id, ..)| format!("{name}, {id}: {}", told(&found[*name]))).collect();
    assert!(missed.is_empty(), "{} missed:\n{}", missed.len(), missed.join("\n"));
}
