//! `kinfold make`: what it leaves, what it repeats, what it says.

use std::process::Child;
use std::time::Duration;

use serde_json::Value;

use crate::cabinet::condition;
use crate::kinfold::{Bench, Said, names};

const STAGES: [&str; 13] = [
    "generate-mesh",
    "render-views",
    "propose-condition",
    "select-prompts",
    "articulate",
    "select-measures",
    "shape-parts",
    "build-asset",
    "transfer-appearance",
    "write-urdf",
    "check-in-sim",
    "write-page",
    "write-pictures",
];

#[test]
fn a_run_leaves_a_whole_asset_with_its_trace_and_verdict() {
    let bench = Bench::new();
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    let out = bench.out();
    for name in [
        "asset.urdf",
        "asset.json",
        "verdict.json",
        "viewer.html",
        "parts.png",
        "motion.webp",
        "trace.mcap",
    ] {
        assert!(out.contains_key(name), "{name} is missing from {:?}", names(&out));
    }
    assert_eq!(names(&out).iter().filter(|n| n.starts_with("views/")).count(), 8);
    assert!(names(&out).iter().any(|n| n.starts_with("meshes/")));
    assert!(!names(&out).iter().any(|n| n.ends_with(".partial")), "{:?}", names(&out));
    let verdict: Value = serde_json::from_slice(&out["verdict.json"]).unwrap();
    let tier = verdict["tier"].as_str().unwrap();
    assert_eq!(said.out, format!("out/asset.urdf\ntier {tier}\n"));
}

#[test]
fn the_trace_holds_every_stage_the_pictures_and_the_verdict() {
    let bench = Bench::done();
    let trace = bench.trace();
    assert!(trace.chain_holds && trace.torn.is_none());
    let finished: Vec<_> = trace.events.iter().filter(|(_, e)| !e.outputs.is_empty()).collect();
    let stages: Vec<_> = finished.iter().map(|(_, e)| e.stage.as_str()).collect();
    assert_eq!(stages[0], "photo");
    assert_eq!(&stages[1..], STAGES);
    let topics: Vec<_> = trace.topics.iter().map(|(t, _)| t.as_str()).collect();
    for topic in ["/input/photo", "/views/front", "/scene", "/tf", "/joints", "/verdict"] {
        assert!(topics.contains(&topic), "{topic} is missing from {topics:?}");
    }
    assert!(
        trace.events.is_sorted_by(|(a, _), (b, _)| a < b),
        "every event has a moment of its own"
    );
    let urdf = trace.attachments.iter().find(|a| a.name == "asset.urdf").unwrap();
    assert_eq!(urdf.bytes, bench.out()["asset.urdf"]);
    let listed = finished.iter().flat_map(|(_, e)| &e.outputs);
    let urdf = listed.clone().find(|o| o.name == "asset.urdf").unwrap();
    assert_eq!(urdf.digest, trace::Digest::of(&bench.out()["asset.urdf"]));
}

#[test]
fn the_same_photo_seed_and_clock_give_the_same_bytes_anywhere() {
    let (one, other) = (Bench::done(), Bench::new());
    other.made(&["--quiet"]);
    assert_eq!(names(&one.out()), names(&other.out()));
    assert!(one.out() == other.out(), "the same run gave other bytes");
}

#[test]
fn the_second_run_does_nothing_and_gives_the_same() {
    let bench = Bench::done();
    let (out, finished) = (bench.out(), bench.counts());
    let said = bench.made(&["--json"]);
    let answer: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(answer["outcome"], "done");
    assert!(answer["stages"].as_array().unwrap().iter().all(|s| s["ran"] == false), "{answer}");
    assert!(bench.out() == out);
    let again = bench.counts();
    for stage in STAGES {
        let key = (stage.to_string(), "finished".to_string());
        assert_eq!((again[&key], finished[&key]), (1, 1));
    }
}

#[test]
fn an_edited_condition_repeats_only_what_depends_on_it() {
    let bench = Bench::done();
    let mut edited = condition();
    edited["parts"][1]["material"] = "steel".into();
    bench.cabinet.write_condition(&edited);
    let plan = bench.made(&["--dry-run"]);
    assert_eq!(plan.code, Some(0), "{plan:?}");
    let line = |stage: &str| plan.out.lines().find(|l| l.starts_with(stage)).unwrap().to_string();
    assert_eq!(line("generate-mesh"), "generate-mesh      keep");
    assert_eq!(line("render-views"), "render-views       keep");
    assert_eq!(
        line("propose-condition"),
        "propose-condition  run   what `condition-file/1` reads changed"
    );
    assert_eq!(
        line("select-prompts"),
        "select-prompts     may   input `condition` comes from propose-condition, which runs first"
    );
    assert_eq!(bench.finished("propose-condition"), 1, "a dry run changes nothing");
    bench.made(&[]);
    assert_eq!(bench.finished("generate-mesh"), 1);
    assert_eq!(bench.finished("render-views"), 1);
    let rest =
        STAGES.iter().filter(|s| !["generate-mesh", "render-views", "articulate"].contains(s));
    for stage in rest {
        assert_eq!(bench.finished(stage), 2, "{stage}");
    }
    assert_eq!(bench.finished("articulate"), 1, "a material moves no part");
}

#[test]
fn a_mass_makes_no_shape_anew_and_a_size_articulates_nothing() {
    let bench = Bench::done();
    let made = |what: &str, edit: &dyn Fn(&mut Value)| {
        let mut edited = condition();
        edit(&mut edited);
        bench.cabinet.write_condition(&edited);
        let said = bench.made(&[]);
        assert_eq!(said.code, Some(0), "{what}: {said:?}");
        ["select-measures", "articulate", "shape-parts", "build-asset"].map(|s| bench.finished(s))
    };
    let mass = made("a mass", &|c| c["parts"][0]["mass"] = 9.into());
    assert_eq!(mass, [2, 1, 1, 2]);
    let oak = made("as thick a wall", &|c| c["parts"][1]["material"] = "oak".into());
    assert_eq!(oak, [3, 1, 1, 3]);
    let body = made("what stands still", &|c| c["parts"][0]["material"] = "steel".into());
    assert_eq!(body, [4, 1, 1, 4]);
    let door = made("another wall", &|c| c["parts"][1]["material"] = "steel".into());
    assert_eq!(door, [5, 1, 2, 5]);
    let size = made("a size", &|c| c["size"] = serde_json::json!({ "height": 0.9 }));
    assert_eq!(size, [6, 1, 3, 6]);
}

#[test]
fn a_trace_names_shapes_by_their_digest_alone() {
    let bench = Bench::done();
    let trace = bench.trace();
    let event = trace.events.iter().rfind(|(_, e)| e.stage == "shape-parts").map(|(_, e)| e);
    let outputs: Vec<_> = event.unwrap().outputs.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(outputs, ["shapes.json"]);
    let is_there = |name: &str| trace.attachments.iter().any(|a| a.name == name);
    assert!(is_there("measures.json") && !is_there("shapes.json"));
}

#[test]
fn a_plan_does_not_say_that_articulate_runs_again_after_a_change_of_mass() {
    let bench = Bench::done();
    let mut edited = condition();
    edited["parts"][1]["mass"] = 4.5.into();
    bench.cabinet.write_condition(&edited);
    let plan = bench.made(&["--dry-run"]);
    let articulate = plan.out.lines().find(|l| l.starts_with("articulate")).unwrap();
    assert!(articulate.starts_with("articulate         may   "), "{plan:?}");
    let told =
        "1 of 13 stages would run, 10 more may: those whose inputs come out other than before\n";
    assert!(plan.out.ends_with(told), "{plan:?}");
    let plan: Value = serde_json::from_str(&bench.made(&["--dry-run", "--json"]).out).unwrap();
    let stage = |name: &str| {
        let stages = plan["stages"].as_array().unwrap();
        stages.iter().find(|s| s["stage"] == name).unwrap().clone()
    };
    let told = |name: &str| [stage(name)["run"].clone(), stage(name)["may"].clone()];
    assert_eq!(told("propose-condition"), [true, false]);
    assert_eq!(
        (told("articulate"), told("generate-mesh")),
        ([false, true].map(Into::into), [false, false].map(Into::into))
    );
    bench.made(&[]);
    assert_eq!(bench.finished("articulate"), 1);
}

#[test]
fn an_edit_that_changes_no_meaning_stops_at_the_condition() {
    let bench = Bench::done();
    let pretty = serde_json::to_string_pretty(&condition()).unwrap();
    std::fs::write(&bench.cabinet.condition, pretty).unwrap();
    bench.made(&[]);
    assert_eq!(bench.finished("propose-condition"), 2);
    assert_eq!(bench.finished("articulate"), 1);
}

#[test]
fn a_plan_gives_a_reason_for_every_stage() {
    let bench = Bench::new();
    let plan = bench.made(&["--dry-run"]);
    assert!(plan.out.contains("generate-mesh      run   no record"), "{}", plan.out);
    assert!(plan.out.ends_with("13 of 13 stages would run\n"), "{}", plan.out);
    assert!(!bench.path("state").exists() && !bench.path("out").exists());
    let bench = Bench::done();
    let plan = bench.made(&["--dry-run", "--seed", "5", "--json"]);
    let plan: Value = serde_json::from_str(&plan.out).unwrap();
    let reasons = |stage: &str| {
        let stages = plan["stages"].as_array().unwrap();
        stages.iter().find(|s| s["stage"] == stage).unwrap()["reasons"].clone()
    };
    assert_eq!(reasons("generate-mesh")[0], "seed changed from 0 to 5");
    assert_eq!(
        reasons("render-views")[0],
        "input `mesh` comes from generate-mesh, which runs first"
    );
}

#[test]
fn a_result_whose_bytes_rotted_is_made_again() {
    let bench = Bench::done();
    let before = bench.out();
    let views = crate::kinfold::files(&bench.path("state/cas"));
    let (largest, _) = views.iter().max_by_key(|(_, bytes)| bytes.len()).unwrap();
    std::fs::write(bench.path("state/cas").join(largest), "rotten").unwrap();
    let plan = bench.made(&["--dry-run"]);
    assert!(plan.out.contains("run   its bytes in the store are damaged"), "{}", plan.out);
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(bench.out() == before);
}

fn hold_state(bench: &Bench) -> runner::StateDir {
    runner::StateDir::open(&bench.path("state")).unwrap()
}

#[test]
fn a_second_runner_that_may_not_wait_is_refused_with_advice() {
    let bench = Bench::done();
    let (held, before) = (hold_state(&bench), bench.out());
    let said = bench.made(&["--no-wait"]);
    assert_eq!(said.code, Some(1));
    let whom = format!("is in use by process {} on ", std::process::id());
    assert!(said.err.contains(&whom), "{}", said.err);
    assert!(said.err.contains("hint: without --no-wait this one waits, or"), "{}", said.err);
    assert!(bench.out() == before, "the refused run touched the other's result");
    drop(held);
    assert_eq!(bench.made(&[]).code, Some(0));
}

#[cfg(unix)]
#[test]
fn a_killed_runner_leaves_no_stale_lock() {
    let bench = Bench::new();
    let mut child: Child = bench.make(&[]).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(30));
    child.kill().unwrap();
    child.wait().unwrap();
    drop(hold_state(&bench));
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_run_that_goes_on() {
    let bench = Bench::new();
    let child = bench.make(&[]).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(60));
    let pid = child.id().to_string();
    std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap();
    let said: Said = child.wait_with_output().unwrap().into();
    if said.code == Some(130) {
        assert!(said.err.contains("hint: finished stages are kept"), "{}", said.err);
        assert!(!bench.out().contains_key("asset.urdf"));
    } else {
        assert!(
            matches!(said.code, Some(0) | None),
            "a run that was over, or not yet listening: {said:?}"
        );
    }
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(STAGES.iter().all(|stage| bench.finished(stage) == 1));
}

#[test]
fn the_flow_prints_as_graphviz() {
    let bench = Bench::new();
    let said = bench.made(&["--graph"]);
    assert!(said.out.starts_with("digraph \"image-to-urdf\" {"), "{}", said.out);
    assert!(STAGES.iter().all(|stage| said.out.contains(stage)));
    assert!(!bench.path("out").exists());
}

#[test]
fn files_beside_the_photo_are_not_picked_up() {
    let bench = Bench::new();
    std::fs::copy(&bench.cabinet.mesh, bench.path("mesh.glb")).unwrap();
    std::fs::copy(&bench.cabinet.condition, bench.path("condition.json")).unwrap();
    let mut command = crate::kinfold::program();
    let state = bench.path("state");
    let said: Said = command
        .args(["make"])
        .arg(&bench.cabinet.photo)
        .env("KINFOLD_STATE", state)
        .output()
        .unwrap()
        .into();
    assert_eq!(said.code, Some(2));
    assert!(
        said.err.starts_with("error: nobody to ask for a mesh and a condition"),
        "{}",
        said.err
    );
    assert!(
        said.err.contains("hint: give the object's surface with --mesh FILE.glb"),
        "{}",
        said.err
    );
}

#[test]
fn somebody_elses_folder_is_left_alone() {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("out/meshes")).unwrap();
    std::fs::write(bench.path("out/meshes/mine.obj"), "mine").unwrap();
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(1));
    assert!(
        said.err.contains("hint: choose a new or an empty folder with --out DIR"),
        "{}",
        said.err
    );
    assert_eq!(names(&bench.out()), ["meshes/mine.obj"]);
}
