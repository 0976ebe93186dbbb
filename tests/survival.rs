//! A good result survives a bad run: an output folder changes by one step, when all is done.
#![cfg(unix)]

use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::batch::Batch;
use crate::batch_failures::Disk;
use crate::cabinet::condition;
use crate::folders::tree;
use crate::kinfold::{Bench, CLOCK, Said, files, names};

/// Runs something over a good asset: exit code, and the asset as it was.
fn survives(bench: &Bench, what: &str, code: i32, run: impl FnOnce() -> Said) -> Said {
    let before = tree(&bench.path("out"));
    let said = run();
    assert_eq!(said.code, Some(code), "{what}: {said:?}");
    assert!(tree(&bench.path("out")) == before, "{what} changed the good asset");
    said
}

fn over(bench: &Bench, photo: &str, more: &[&str]) -> Said {
    let mut command = crate::kinfold::program();
    command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
    command.args(["make", photo, "--out", "out", "--clock", CLOCK]).args(more);
    command.output().unwrap().into()
}

/// Photos are often called alike: the second asset took the first one's place without a word.
#[test]
fn a_photo_of_the_same_name_takes_nobodys_place_where_no_folder_was_named() {
    let bench = Bench::done();
    let other = bench.path("other");
    std::fs::create_dir(&other).unwrap();
    image::RgbImage::from_pixel(64, 64, image::Rgb([9, 9, 9]))
        .save(other.join("photo.png"))
        .unwrap();
    let make = |photo: &str, more: &[&str]| -> Said {
        let mut command = crate::kinfold::program();
        command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
        command.args(["make", photo, "--mesh", "cabinet.glb", "--condition", "cabinet.json"]);
        command.args(["--clock", CLOCK]).args(more).output().unwrap().into()
    };
    let first = make("photo.png", &[]);
    assert_eq!(first.code, Some(0), "{first:?}");
    let before = files(&bench.path("photo.kinfold"));
    let refused = make("other/photo.png", &[]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.err.contains("found one of another photo") && refused.err.contains("--out"));
    assert!(files(&bench.path("photo.kinfold")) == before);
    assert_eq!(make("photo.png", &[]).code, Some(0), "the same photo again");
    // Who names the folder means it, and is told.
    let named = make("other/photo.png", &["--out", "photo.kinfold"]);
    assert_eq!(named.code, Some(0), "{named:?}");
    assert!(named.err.contains("an asset of another photo stood there"), "{named:?}");
}

#[test]
fn a_good_asset_survives_typos_missing_files_and_misuse() {
    let bench = Bench::done();
    let files = ["--mesh", "cabinet.glb", "--condition", "cabinet.json"];
    let gone = ["--mesh", "cabinet.glb", "--condition", "cabinte.json"];
    let no_mesh = ["--mesh", "cabinet.json", "--condition", "cabinet.json"];
    let mut failed = 0;
    for (what, photo, more, code) in [
        ("a typo in the photo's name", "phto.png", &files[..], 1),
        ("no photo", "cabinet.json", &files[..], 1),
        ("a missing condition", "photo.png", &gone[..], 1),
        ("no mesh", "photo.png", &no_mesh[..], 1),
        ("nobody to ask", "photo.png", &[][..], 2),
        ("an unknown flag", "photo.png", &["--tear", "static"][..], 2),
        ("a dry run", "photo.png", &[&files[..], &["--dry-run"]].concat()[..], 0),
    ] {
        let said = survives(&bench, what, code, || over(&bench, photo, more));
        if code == 1 {
            failed += 1;
            let place = format!("out.failed/{failed}/trace.mcap");
            assert!(
                said.err.contains(&format!("hint: the trace of this run is {place}")),
                "{said:?}"
            );
            let reading = trace::read(&bench.path(&place)).unwrap();
            assert!(reading.chain_holds && reading.torn.is_none(), "{what}");
        }
    }
    assert_eq!(bench.made(&[]).code, Some(0));
}

#[test]
fn failed_runs_are_bounded_in_number_and_leave_nothing_else() {
    let bench = Bench::done();
    let before = tree(&bench.path(""));
    for _ in 0..7 {
        assert_eq!(over(&bench, "gone.png", &["--mesh", "a", "--condition", "b"]).code, Some(1));
    }
    let left = files(&bench.path("out.failed"));
    let traces = names(&left).into_iter().filter(|n| n.ends_with("trace.mcap"));
    let numbers: Vec<_> = traces.map(|n| n.split('/').next().unwrap()).collect();
    assert_eq!(numbers, ["3", "4", "5", "6", "7"]);
    let others = |of: &std::collections::BTreeMap<String, Vec<u8>>| -> Vec<String> {
        let outside = |n: &&String| !n.starts_with("state") && !n.starts_with("out.failed");
        of.keys().filter(outside).cloned().collect()
    };
    assert_eq!(others(&tree(&bench.path(""))), others(&before));
}

#[test]
fn ctrl_c_and_sigkill_leave_the_good_asset_and_the_trace_beside() {
    for signal in ["-INT", "-TERM", "-KILL"] {
        let bench = Bench::done();
        let mut edited = condition();
        edited["parts"][1]["material"] = "steel".into();
        bench.cabinet.write_condition(&edited);
        let before = tree(&bench.path("out"));
        let child = bench.make(&["--seed", "7"]).spawn().unwrap();
        // From its first moment a run has a trace beside the asset.
        let (trace, began) = (bench.path("out.failed/1/trace.mcap"), Instant::now());
        while !trace.exists() && began.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_micros(200));
        }
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        let said: Said = child.wait_with_output().unwrap().into();
        if said.code == Some(0) {
            continue; // it was over by then
        }
        assert!(matches!(said.code, Some(130) | None), "{signal}: {said:?}");
        assert!(tree(&bench.path("out")) == before, "{signal} changed the good asset");
        assert!(trace.exists(), "{signal}");
        assert_eq!(bench.made(&[]).code, Some(0));
        assert!(names(&bench.out()).contains(&"asset.urdf"));
    }
}

#[test]
fn a_full_disk_leaves_the_good_asset_as_it_was() {
    let Some(disk) = Disk::of("40m") else { return };
    let bench = Bench::done();
    let out = disk.path().join("out");
    let make = |more: &[&str]| -> Said {
        let mut command = crate::kinfold::program();
        command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
        command.args(["make", "photo.png", "--mesh", "cabinet.glb"]);
        command.args(["--condition", "cabinet.json", "--clock", CLOCK, "--out"]).arg(&out);
        command.args(more).output().unwrap().into()
    };
    assert_eq!(make(&[]).code, Some(0));
    let before = tree(&out);
    let all: usize = before.values().map(Vec::len).sum();
    // Fill the disk so that less and less of a second asset fits.
    for left in [all * 3 / 4, all / 2, all / 4, 8192, 0] {
        let filler = disk.path().join("filler");
        let _ = std::fs::remove_file(&filler);
        let free = free(disk.path());
        std::fs::write(&filler, vec![0; free.saturating_sub(left as u64) as usize]).unwrap();
        let said = make(&["--seed", "5"]);
        assert_eq!(said.code, Some(1), "{left} bytes: {said:?}");
        assert!(said.err.contains("error: "), "{said:?}");
        assert!(tree(&out) == before, "{left} bytes left changed the good asset");
        std::fs::remove_file(&filler).unwrap();
    }
    assert_eq!(make(&["--seed", "5"]).code, Some(0));
    assert!(tree(&out) != before);
}

/// Bytes that are free on a disk.
fn free(path: &std::path::Path) -> u64 {
    let told = Command::new("df").args(["--output=avail", "-B1"]).arg(path).output().unwrap();
    let text = String::from_utf8(told.stdout).unwrap();
    text.lines().nth(1).unwrap().trim().parse().unwrap()
}

#[test]
fn a_disk_that_may_not_be_written_leaves_the_good_asset_as_it_was() {
    let Some(disk) = Disk::of("40m") else { return };
    let bench = Bench::done();
    let out = disk.path().join("out");
    for (name, bytes) in bench.out() {
        std::fs::create_dir_all(out.join(&name).parent().unwrap()).unwrap();
        std::fs::write(out.join(name), bytes).unwrap();
    }
    let remount = |how: &str| {
        let option = format!("remount,{how}");
        assert!(
            Command::new("mount")
                .args(["-o", &option])
                .arg(disk.path())
                .status()
                .unwrap()
                .success()
        );
    };
    let before = tree(&out);
    remount("ro");
    let mut command = crate::kinfold::program();
    command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
    command.args(["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "cabinet.json"]);
    let said: Said = command.arg("--out").arg(&out).output().unwrap().into();
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.to_lowercase().contains("read-only file system"), "{said:?}");
    assert!(tree(&out) == before);
    remount("rw");
    // The disk itself is a folder that nothing can take the place of.
    let mut command = crate::kinfold::program();
    command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
    command.args(["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "cabinet.json"]);
    let said: Said = command.arg("--out").arg(disk.path()).output().unwrap().into();
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("is a disk of its own"), "{said:?}");
}

#[test]
fn an_accepted_asset_of_a_batch_survives_a_bad_manifest() {
    let batch = Batch::of(2);
    assert_eq!(batch.ran(&[]).0.code, Some(0));
    let before = tree(&batch.path("out/assets"));
    batch.write("broken.json", "{\"schema\": \"kinfold-condition/1\", \"parts\": []}");
    let mut broken = Batch::given("k001", 1);
    broken["condition"] = "broken.json".into();
    batch.write("items.jsonl", format!("{}\n{broken}\n", Batch::given("k000", 0)));
    let (said, answer) = batch.ran(&[]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert_eq!(answer["failed"], 1);
    assert!(tree(&batch.path("out/assets")) == before, "the good asset changed");
    assert!(batch.path("out/quarantine/k001/trace.mcap").exists());
    let audit = batch.say(&["audit", "out"]);
    assert_eq!(audit.code, Some(0), "{audit:?}");
    // And it is audited, though its last row is of the failure.
    let urdf = batch.path("out/assets/k001/asset.urdf");
    let text = std::fs::read_to_string(&urdf).unwrap();
    std::fs::write(&urdf, format!("{text}\n")).unwrap();
    let audit = batch.say(&["audit", "out"]);
    assert_eq!(audit.code, Some(1), "{audit:?}");
    assert!(
        audit.err.contains("asset.urdf was changed")
            || audit.out.contains("asset.urdf was changed"),
        "{audit:?}"
    );
    std::fs::write(&urdf, text).unwrap();
    // A good line again takes its place, with the notes beside it.
    batch.write("out/assets/k001/notes.txt", "mine");
    let mut steel = condition();
    steel["parts"][1]["material"] = "steel".into();
    batch.write("steel.json", steel.to_string());
    let mut good = Batch::given("k001", 1);
    good["condition"] = "steel.json".into();
    batch.write("items.jsonl", format!("{}\n{good}\n", Batch::given("k000", 0)));
    assert_eq!(batch.ran(&[]).0.code, Some(0));
    let after = tree(&batch.path("out/assets"));
    assert_eq!(after["k001/notes.txt"], b"mine");
    assert!(after["k001/asset.urdf"] != before["k001/asset.urdf"]);
    assert!(!batch.path("out/quarantine/k001").exists());
}

#[test]
fn an_asset_below_its_tier_says_why_and_takes_no_better_ones_place() {
    let bench = Bench::new();
    let mut huge = condition();
    huge["size"] = json!({ "height": 15.0 });
    bench.cabinet.write_condition(&huge);
    // Nothing better stands: it is published, and the exit code says that it is not what was asked.
    let said = bench.made(&["--json"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    let answer: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(
        (&answer["outcome"], &answer["published"]),
        (&json!("below the tier"), &json!(true))
    );
    let reason = answer["reason"].as_str().unwrap();
    assert!(
        reason.starts_with("the asset reaches tier parse, asked for kinematic: U2 "),
        "{reason}"
    );
    assert!(said.err.lines().any(|line| line == reason), "{said:?}");
    assert!(bench.out().contains_key("asset.urdf"));
    // The tier that it reaches may be asked for.
    let said = bench.made(&["--tier", "parse"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    // A better one takes its place, and it does not come back.
    bench.cabinet.write_condition(&condition());
    assert_eq!(bench.made(&[]).code, Some(0));
    bench.cabinet.write_condition(&huge);
    let said = survives(&bench, "a lower tier", 3, || bench.made(&[]));
    assert!(said.out.starts_with("out.failed/1/asset.urdf\ntier parse\n"), "{said:?}");
    assert!(
        said.err.contains("not published, because an asset of tier dynamic stands there"),
        "{said:?}"
    );
    for name in ["asset.urdf", "verdict.json", "trace.mcap"] {
        assert!(bench.path("out.failed/1").join(name).is_file(), "{name}");
    }
    // Of what stands there and says nothing about itself, nobody knows that it is worse.
    std::fs::write(bench.path("out/verdict.json"), "{}").unwrap();
    survives(&bench, "an unknown tier", 3, || bench.made(&[]));
    let said = bench.made(&["--tier", "audited"]);
    assert_eq!(said.code, Some(2), "{said:?}");
}

#[test]
fn check_agrees_with_makes_exit_on_every_object_and_tier() {
    let out = tempfile::tempdir().unwrap();
    let mut objects: Vec<_> = crate::examples::names()
        .iter()
        .map(|name| crate::examples::folder(name))
        .map(|case| [case.join("photo.png"), case.join("mesh.glb"), case.join("condition.json")])
        .collect();
    for (n, height) in [0.6, 15.0, 0.006].into_iter().enumerate() {
        let folder = out.path().join(format!("cabinet-{n}"));
        std::fs::create_dir(&folder).unwrap();
        let cabinet = crate::cabinet::Cabinet::write(&folder);
        let mut sized = condition();
        sized["size"]["height"] = height.into();
        cabinet.write_condition(&sized);
        objects.push([cabinet.photo, cabinet.mesh, cabinet.condition]);
    }
    let mut seen = std::collections::BTreeSet::new();
    for (n, [photo, mesh, given]) in objects.iter().enumerate() {
        for tier in ["parse", "static", "kinematic", "dynamic"] {
            let made = out.path().join(format!("out-{n}"));
            let mut command = crate::kinfold::program();
            command.arg("make").arg(photo).arg("--mesh").arg(mesh).arg("--condition").arg(given);
            command.arg("--state").arg(out.path().join("state")).arg("--out").arg(&made);
            let said: Said = command.args(["--tier", tier, "--json"]).output().unwrap().into();
            let answer: serde_json::Value = serde_json::from_str(&said.out).unwrap();
            let mut command = crate::kinfold::program();
            command.args(["check", "--tier", tier]).arg(answer["urdf"].as_str().unwrap());
            let checked: Said = command.output().unwrap().into();
            let lost = !answer["losses"].as_array().unwrap().is_empty();
            let expected: &[i32] = match (said.code, lost) {
                (Some(0), _) => &[0],
                (Some(3), false) => &[3, 1],
                (Some(3), true) => &[0, 3, 1],
                _ => panic!("{photo:?} {tier}: {said:?}"),
            };
            let code = checked.code.unwrap();
            assert!(expected.contains(&code), "{photo:?} {tier}: {said:?} but {checked:?}");
            seen.insert(said.code);
        }
    }
    assert_eq!(seen.len(), 2, "objects on both sides of a tier: {seen:?}");
}
