//! The real engines, where they are installed: every measured rule asks one, and the small files are
//! refused by those of which that is forecast, and by no others.
//!
//! `KINFOLD_ENGINES` names Pythons, parted by colons; else the repository's `.venv` and `.venv-usd`
//! are looked into. `engines/requirements.txt` says what to install.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use forecast::{Client, Outside, RULES, Severity, Source, forecast};

use crate::peculiarities;

/// A client, its script, and what its Python must import.
const ENGINES: [(Client, &str, &str); 7] = [
    (Client::Mujoco, "engines/check_mujoco.py", "mujoco"),
    (Client::Pybullet, "engines/check_pybullet.py", "pybullet"),
    (Client::Drake, "engines/check_drake.py", "pydrake"),
    (Client::Newton, "engines/check_newton.py", "newton, pxr, trimesh"),
    (Client::Isaac, "engines/check_isaac.py", "urdf_usd_converter"),
    (Client::Sapien, "engines/check_sapien.py", "sapien"),
    (Client::Rerun, "engines/check_rerun.py", "rerun.urdf"),
];

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A Python that imports these; without one the test says that it skips.
fn python(modules: &str) -> Option<PathBuf> {
    let pythons: Vec<PathBuf> = match std::env::var("KINFOLD_ENGINES") {
        Ok(list) => list.split(':').map(PathBuf::from).collect(),
        Err(_) => [".venv", ".venv-usd"].map(|v| here("..").join(v).join("bin/python")).to_vec(),
    };
    let imports = |python: &PathBuf| {
        let run = Command::new(python).args(["-c", &format!("import {modules}")]).output();
        run.is_ok_and(|o| o.status.success())
    };
    let found = pythons.into_iter().find(imports);
    if found.is_none() {
        println!("SKIPPED: no Python of KINFOLD_ENGINES imports {modules}");
    }
    found
}

fn run(python: &Path, script: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(python);
    command.arg(here(script)).args(arguments).env("PYTHONDONTWRITEBYTECODE", "1");
    command.output().unwrap()
}

/// What a script said of rules or files: the word in front of each.
fn words(output: &Output) -> BTreeMap<String, String> {
    let text = String::from_utf8_lossy(&output.stdout);
    let lines = text.lines().filter_map(|l| l.split_once(' '));
    lines.map(|(word, of)| (of.to_string(), word.to_string())).collect()
}

#[test]
fn every_measured_rule_holds_in_the_real_engine() {
    let mut wrong = String::new();
    for (client, script, modules) in ENGINES {
        let Some(python) = python(modules) else { continue };
        let output = run(&python, script, &[]);
        let said = words(&output);
        let rules = RULES.iter().copied().flatten();
        let mut asked = 0;
        for rule in rules.filter(|r| r.client == client && r.source == Source::Measured(script)) {
            asked += 1;
            if said.get(rule.id).map(String::as_str) != Some("ok") {
                let text = String::from_utf8_lossy(&output.stdout);
                let line = text.lines().find(|l| l.starts_with(&format!("FAILED {}", rule.id)));
                wrong += &format!("\n{}", line.unwrap_or(rule.id));
            }
        }
        println!("{}: {asked} rules asked", client.label());
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Files that an engine refuses for a reason of its own, which no rule promises: one that needs a
/// device to draw, which a test machine lacks.
fn is_drawn_by_sapien(client: Client, text: &str) -> bool {
    client == Client::Sapien && text.contains("<visual")
}

#[test]
fn files_are_refused_by_those_engines_of_which_it_is_forecast() {
    let folder = tempfile::tempdir().unwrap();
    let files = peculiarities::all();
    let paths: Vec<_> = files.iter().map(|f| f.write(folder.path())).collect();
    let mut wrong = String::new();
    for (client, _, modules) in ENGINES {
        let Some(python) = python(modules) else { continue };
        let mut refused = BTreeMap::new();
        for (file, path) in files.iter().zip(&paths) {
            let said = forecast(path, &[client], Outside::Refused).unwrap().remove(0);
            if said.rules > 0 && !is_drawn_by_sapien(client, &file.text) && is_read(client, file) {
                let is = said.findings.iter().any(|f| f.severity == Severity::Refused);
                refused.insert(path.display().to_string(), is);
            }
        }
        let mut arguments = vec![client.name()];
        arguments.extend(refused.keys().map(String::as_str));
        let output = run(&python, "engines/loads.py", &arguments);
        let said = words(&output);
        for (path, is) in &refused {
            let expected = if *is { "refused" } else { "loaded" };
            let found = said.get(path).map_or("nothing", String::as_str);
            if found != expected {
                let errors = String::from_utf8_lossy(&output.stderr);
                let why = errors.lines().find(|l| l.starts_with(path.as_str())).unwrap_or_default();
                wrong +=
                    &format!("\n{}: {found}, forecast {expected}: {path} {why}", client.name());
            }
        }
        println!("{}: {} files loaded or refused as forecast", client.label(), refused.len());
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// The converter of Isaac Sim's importer reads URDF alone.
fn is_read(client: Client, file: &peculiarities::Peculiar) -> bool {
    client != Client::Isaac || file.extension == "urdf"
}
