//! Training and fits survive a kill: the same command goes on and ends with the bytes of an undisturbed run.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::kinfold::{Said, files, program};

/// A network of a few thousand numbers, and a handful of our own objects.
const TINY: &str = "\
out = 'OUT'
cache = 'samples'
seed = 3
steps = 60
batch = 2
queries = 48
augment = { turn = false, scale = 0.0, shift = 0.0, no_normals = 0.0, merge = 0.0 }
network = { width = 24, heads = 2, blocks = 1, points = 96, tokens = 12 }
schedule = { rate = 4e-3, warmup = 5 }
sample = { even = 300, least = 24 }
every = { curve = 5, checkpoint = 5, validation = 30 }
[[source]]
name = 'ours'
procedural = 3
[validation]
objects = 2
source = { name = 'ours-too', procedural = 2 }
";

fn write(folder: &Path, name: &str) {
    std::fs::write(folder.join(format!("{name}.toml")), TINY.replace("OUT", name)).unwrap();
}

fn train(folder: &Path, name: &str) -> Command {
    let mut command = program();
    command.current_dir(folder).args(["train", &format!("{name}.toml"), "--json"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn done(folder: &Path, name: &str) -> Said {
    train(folder, name).output().unwrap().into()
}

/// Waits until a run has saved something new, then kills it.
fn kill_after_a_checkpoint(mut child: Child, out: &Path) {
    let saved = || std::fs::read(out.join("checkpoint.safetensors")).unwrap_or_default();
    let (before, began) = (saved(), Instant::now());
    while saved() == before && child.try_wait().unwrap().is_none() {
        assert!(began.elapsed() < Duration::from_secs(300), "no checkpoint after five minutes");
        std::thread::sleep(Duration::from_millis(5));
    }
    // It may have ended by itself.
    let _ = child.kill();
    child.wait().unwrap();
}

fn losses(out: &BTreeMap<String, Vec<u8>>) -> Vec<f64> {
    let curve = String::from_utf8(out["curves.csv"].clone()).unwrap();
    curve.lines().skip(1).map(|l| l.split(',').nth(1).unwrap().parse().unwrap()).collect()
}

#[test]
fn a_training_killed_twice_ends_with_the_bytes_of_an_undisturbed_one_and_learns() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "whole");
    write(folder, "killed");
    let said = done(folder, "whole");
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(said.out.contains("\"finished\":true"), "{}", said.out);
    for _ in 0..2 {
        let child = train(folder, "killed").spawn().unwrap();
        kill_after_a_checkpoint(child, &folder.join("killed"));
    }
    assert_eq!(done(folder, "killed").code, Some(0));
    let [whole, mut killed] = ["whole", "killed"].map(|name| files(&folder.join(name)));
    killed.retain(|name, _| !name.ends_with(".partial"));
    assert!(whole == killed, "{:?} and {:?}", whole.keys(), killed.keys());
    let losses = losses(&whole);
    let (first, last) = (losses[0], losses[losses.len() - 1]);
    assert!(last < 0.7 * first, "the loss went from {first} to {last}");
}

#[test]
fn a_configuration_that_will_not_do_is_named_with_its_rule() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), TINY.replace("steps = 60", "steps = 0")).unwrap();
    let said = done(folder.path(), "a");
    assert_eq!(said.code, Some(1));
    assert!(said.err.contains("a.toml: `steps` must be between 1 and"), "{}", said.err);
    let said = done(folder.path(), "missing");
    assert!(said.code == Some(1) && said.err.contains("missing.toml"), "{}", said.err);
}

/// Ranges of eight of our own objects, by trees that take a while.
const FIT: &str = "\
fit = 'ranges'
out = 'run'
pack = 'ranges.pack'
[model]
ways = 10
[model.families]
each = 2
without = [WITHOUT]
[model.growth]
trees = 30
leaves = 15
rate = 0.1
questions = 0.7
features = 0.5
curve = 0.1
hold = 1.0
seed = 7
";

fn write_fit(folder: &Path, with: &str) {
    let kept = ["drawer_unit", "storage_box", "desk", "suitcase"];
    let others = training::procedural::names().filter(|name| !kept.contains(name));
    let others: Vec<String> = others.map(|name| format!("'{name}'")).collect();
    let text = format!("{with}{}", FIT.replace("WITHOUT", &others.join(", ")));
    std::fs::write(folder.join("ranges.toml"), text).unwrap();
}

/// How many models a run has finished.
fn finished(folder: &Path) -> usize {
    std::fs::read_dir(folder.join("run/finished")).map_or(0, Iterator::count)
}

#[test]
fn a_fit_killed_twice_ends_with_the_bytes_of_an_undisturbed_one() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let [whole, killed] = folders.each_ref().map(|folder| folder.path());
    write_fit(whole, "");
    write_fit(killed, "");
    let said = done(whole, "ranges");
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(said.out.contains("\"finished\":true"), "{}", said.out);
    for _ in 0..2 {
        let (before, began) = (finished(killed), Instant::now());
        let mut child = train(killed, "ranges").spawn().unwrap();
        while finished(killed) == before && child.try_wait().unwrap().is_none() {
            assert!(began.elapsed() < Duration::from_secs(300), "no model after five minutes");
            std::thread::sleep(Duration::from_millis(5));
        }
        let _ = child.kill();
        child.wait().unwrap();
    }
    assert_eq!(done(killed, "ranges").code, Some(0));
    let [whole, killed] =
        [whole, killed].map(|folder| std::fs::read(folder.join("ranges.pack")).unwrap());
    assert!(whole == killed, "{} and {} bytes", whole.len(), killed.len());
}

#[test]
fn a_recipe_that_will_not_do_is_named_with_its_field() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_fit(folder, "speed = 1\n");
    let said = done(folder, "ranges");
    assert_eq!(said.code, Some(1));
    assert!(said.err.contains("ranges.toml") && said.err.contains("`speed`"), "{}", said.err);
    std::fs::write(folder.join("ranges.toml"), "fit = 'rangers'\n").unwrap();
    let said = done(folder, "ranges");
    assert!(said.code == Some(1) && said.err.contains("`fit` must be one of"), "{}", said.err);
    assert!(!folder.join("run").exists(), "nothing is begun");
}
