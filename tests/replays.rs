//! A trace says what was asked and answered, gives the same bytes again, and gives tampering away.
#![cfg(unix)]

use std::path::{Path, PathBuf};

use object::Condition;
use serde_json::Value;

use crate::cabinet::Cabinet;
use crate::cases;
use crate::kinfold::{Bench, CLOCK, Said, files, program_in, say};
use crate::server::Server;
use crate::services::{Object, config};

/// A folder in which an asset was made of nothing but a photo.
pub struct Made {
    folder: tempfile::TempDir,
    pub server: Server,
}

impl Made {
    fn of(photo: &Path, object: Object) -> (Self, Said) {
        Self::with(photo, object.serve(), "")
    }

    /// The same with a server and with more lines in its section of the configuration.
    pub fn with(photo: &Path, server: Server, more: &str) -> (Self, Said) {
        let folder = tempfile::tempdir().unwrap();
        std::fs::copy(photo, folder.path().join("photo.png")).unwrap();
        let config = format!("{}{more}", config(server.port));
        std::fs::write(folder.path().join("kinfold.toml"), config).unwrap();
        let this = Self { folder, server };
        let said = this.make("out");
        (this, said)
    }

    /// The cabinet, made of a photo and a server's answers.
    pub fn cabinet() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let cabinet = Cabinet::write(folder.path());
        let text = std::fs::read_to_string(&cabinet.condition).unwrap();
        let object = Object::of(&cabinet.mesh, &Condition::from_json(&text).unwrap());
        let (made, said) = Self::of(&cabinet.photo, object);
        assert_eq!(said.code, Some(0), "{said:?}");
        made
    }

    pub fn make(&self, out: &str) -> Said {
        let mut command = program_in(self.folder.path());
        command.env("KINFOLD_STATE", self.path("state"));
        command.args(["make", "photo.png", "--out", out, "--clock", CLOCK]);
        command.output().unwrap().into()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn trace(&self) -> String {
        self.path("out/trace.mcap").display().to_string()
    }
}

/// Runs the trace again without a network and compares what it ships with what was shipped.
pub fn replays_to_the_same_bytes(made: &Made) {
    let asked = made.server.asked().len();
    let again = made.path("again").display().to_string();
    let said = say(&["trace", "replay", &made.trace(), "--out", &again]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(said.out.lines().all(|l| l.ends_with(" same")), "{}", said.out);
    let (first, second) = (files(&made.path("out")), files(&made.path("again")));
    assert!(first.keys().eq(second.keys()), "{:?} {:?}", first.keys(), second.keys());
    assert!(first == second, "a replay gives the same bytes");
    assert_eq!(made.server.asked().len(), asked, "a replay asks nobody");
}

#[test]
fn what_was_made_from_a_photo_alone_replays_without_a_network() {
    let made = Made::cabinet();
    assert_eq!(made.server.count("POST", "/send"), 1);
    assert_eq!(made.server.count("POST", "/v1"), 3);
    replays_to_the_same_bytes(&made);
    let trace = trace::read(&made.path("out/trace.mcap")).unwrap();
    let steps: Vec<_> = trace
        .calls
        .iter()
        .map(|c| {
            let call: Value = serde_json::from_slice(c).unwrap();
            call["step"].as_str().unwrap().to_owned()
        })
        .collect();
    let expected =
        ["hunyuan.submit", "hunyuan.status", "vlm.kinematics/0", "vlm.points/0", "vlm.physical/0"];
    assert_eq!(steps, expected);
}

#[test]
fn a_second_run_that_asks_nobody_leaves_the_trace_of_the_first() {
    let made = Made::cabinet();
    assert_eq!(made.make("second").code, Some(0));
    assert_eq!(made.server.asked().len(), 5, "nobody is asked again");
    assert!(files(&made.path("out")) == files(&made.path("second")));
}

#[test]
fn a_run_with_given_files_replays_and_verifies() {
    let bench = Bench::done();
    let trace = bench.path("out/trace.mcap").display().to_string();
    let again = bench.path("again").display().to_string();
    let said = say(&["trace", "replay", &trace, "--out", &again]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(files(&bench.path("again")) == bench.out());
    let verified = say(&["trace", "verify", &trace, "--verbose"]);
    assert_eq!(verified.code, Some(0), "{verified:?}");
    assert!(verified.out.contains(" asset.urdf\n"), "{}", verified.out);
}

#[test]
fn a_changed_missing_or_strange_file_does_not_follow_from_the_trace() {
    let bench = Bench::done();
    let trace = bench.path("out/trace.mcap").display().to_string();
    let told = || {
        let said = say(&["trace", "verify", &trace]);
        assert_eq!(said.code, Some(1), "{said:?}");
        said.err
    };
    let urdf = bench.path("out/asset.urdf");
    let whole = std::fs::read(&urdf).unwrap();
    std::fs::write(&urdf, [&whole[..], b"\n"].concat()).unwrap();
    assert!(told().contains("asset.urdf does not follow: the trace says "));
    std::fs::remove_file(&urdf).unwrap();
    assert!(told().contains("asset.urdf cannot be read"));
    std::fs::write(&urdf, whole).unwrap();
    std::fs::write(bench.path("out/meshes/extra.obj"), "v 0 0 0").unwrap();
    assert!(told().contains("meshes/extra.obj is not a file of this run"));
}

/// Flips bits all over a trace, at steps that are no multiple of a byte's, and in each of its last
/// bytes, where nothing but the index stands.
fn no_flipped_bit_goes_unseen(made: &Made, flips: usize) {
    let bytes = std::fs::read(made.path("out/trace.mcap")).unwrap();
    let bits = bytes.len() * 8;
    let spread = (0..flips).map(|n| n * (bits / flips) + n % 8);
    for bit in spread.chain([0, 65, bits - 1, bits - 64, bits - 100, bits - 300]) {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let path = made.path("out/flipped.mcap");
        std::fs::write(&path, flipped).unwrap();
        let said = say(&["trace", "verify", &path.display().to_string()]);
        assert_eq!(said.code, Some(1), "bit {bit} of {bits} changed unseen: {said:?}");
        std::fs::remove_file(path).unwrap();
    }
}

#[test]
fn a_flipped_bit_anywhere_makes_verify_fail() {
    no_flipped_bit_goes_unseen(&Made::cabinet(), 40);
}

#[test]
fn two_runs_are_told_apart_by_stage_request_and_number() {
    let bench = Bench::done();
    let one = bench.path("one.mcap").display().to_string();
    std::fs::copy(bench.path("out/trace.mcap"), &one).unwrap();
    let trace = bench.path("out/trace.mcap").display().to_string();
    let same = say(&["trace", "diff", &one, &trace]);
    assert_eq!((same.code, same.out.as_str()), (Some(0), "no difference\n"));
    let mut heavier = crate::cabinet::condition();
    heavier["parts"][1]["mass"] = 3.5.into();
    bench.cabinet.write_condition(&heavier);
    bench.made(&[]);
    let other = say(&["trace", "diff", &one, &trace]);
    assert_eq!(other.code, Some(1), "{other:?}");
    assert!(other.out.contains("propose-condition: condition.json"), "{}", other.out);
    assert!(other.out.contains("-> 3.5"), "{}", other.out);
}

#[test]
fn every_artefact_can_be_taken_out_of_a_trace() {
    let bench = Bench::done();
    let trace = bench.path("out/trace.mcap").display().to_string();
    let listed = say(&["trace", "extract", &trace]);
    assert_eq!(listed.code, Some(0), "{listed:?}");
    let mesh = listed.out.lines().find(|l| l.contains("meshes/")).unwrap();
    let mesh = mesh.rsplit(' ').next().unwrap();
    for name in ["asset.urdf", "condition.json", mesh] {
        let out = bench.path("taken");
        let to = out.display().to_string();
        let said = say(&["trace", "extract", &trace, name, "--out", &to, "--force"]);
        assert_eq!(said.code, Some(0), "{said:?}");
        let shipped = bench.out().get(name).cloned();
        assert!(shipped.is_none_or(|s| s == std::fs::read(&out).unwrap()), "{name}");
    }
    let none = say(&["trace", "extract", &trace, "nothing.txt"]);
    assert_eq!(none.code, Some(1));
    assert!(none.err.contains("no stage made `nothing.txt`"), "{}", none.err);
}

/// Three photos of the development cases whose answers are made from their condition files.
#[test]
fn three_real_photos_go_from_servers_to_verdicts_and_their_traces_hold() {
    let Some(shared) = cases::shared() else { return };
    for name in ["paper__hy-eval-026", "paper__hy-eval-041", "paper__assets-54ca4"] {
        let case = shared.join("data/cases/dev").join(name);
        let Ok(text) = std::fs::read_to_string(case.join("condition.json")) else {
            eprintln!("SKIPPED: no case at {}", case.display());
            continue;
        };
        let condition = Condition::from_json(&text).unwrap();
        let object = Object::of(&case.join("mesh.glb"), &condition);
        let (made, said) = Made::of(&case.join("image.png"), object);
        assert!(matches!(said.code, Some(0 | 3)), "{name}: {said:?}");
        replays_to_the_same_bytes(&made);
        let verified = say(&["trace", "verify", &made.trace()]);
        assert_eq!(verified.code, Some(0), "{name}: {verified:?}");
        no_flipped_bit_goes_unseen(&made, 10);
    }
}
