//! Training survives a kill: the same command goes on and ends with the bytes of an undisturbed run.
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
