//! `kinfold check` and `kinfold trace show`: anybody's files, exit codes that mean something.

use serde_json::Value;

use crate::kinfold::{Bench, say};

const BROKEN: &str = "<robot name=\"r\"><link name=\"a\"/><link name=\"a\"/></robot>";

#[test]
fn a_made_asset_checks_as_its_verdict_says() {
    let bench = Bench::done();
    let urdf = bench.path("out/asset.urdf");
    let said = say(&["check", urdf.to_str().unwrap(), "--json"]);
    let verdict: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(verdict["profile"], "simready-urdf 1.0");
    let reached = verdict["tier"].as_str().unwrap();
    let made: Value = serde_json::from_slice(&bench.out()["verdict.json"]).unwrap();
    assert_eq!(made["tier"].as_str().unwrap(), reached);
    let above = ["kinematic", "dynamic", "audited"].contains(&reached);
    let expected = if above {
        0
    } else if reached == "none" {
        1
    } else {
        3
    };
    assert_eq!(said.code, Some(expected), "tier {reached}");
    let said = say(&["check", urdf.to_str().unwrap(), "--tier", "audited"]);
    assert!(matches!(said.code, Some(1 | 3)), "nobody audited it: {said:?}");
    assert!(said.err.contains("asked for audited"), "{}", said.err);
}

#[test]
fn the_mjcf_of_an_asset_is_judged_like_its_urdf() {
    let bench = Bench::done();
    bench.made(&["--export", "mjcf"]);
    let verdict = |file: &str| -> Value {
        let said = say(&["check", bench.path(file).to_str().unwrap(), "--json"]);
        serde_json::from_str(&said.out).unwrap()
    };
    let [urdf, mjcf] = ["out/asset.urdf", "out/asset.xml"].map(verdict);
    assert_eq!(mjcf["tier"], urdf["tier"], "{mjcf:#}");
    assert_eq!(mjcf["moving_joints"], urdf["moving_joints"]);
    let [one, other] = [&urdf, &mjcf].map(|v| v["checks"].as_array().unwrap());
    for (one, other) in one.iter().zip(other).filter(|(c, _)| c["id"].as_str().unwrap() < "L") {
        let (id, status) = (&one["id"], [&one["status"], &other["status"]]);
        assert_eq!(status[0], status[1], "{id}: {} {}", one["evidence"], other["evidence"]);
    }
}

#[test]
fn a_broken_urdf_exits_1_and_says_what_is_broken() {
    let bench = Bench::new();
    let path = bench.path("broken.urdf");
    std::fs::write(&path, BROKEN).unwrap();
    let said = say(&["check", path.to_str().unwrap()]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.out.contains("tier none"), "{}", said.out);
    let said = say(&["check", "nowhere.urdf"]);
    assert_eq!((said.code, said.out.as_str()), (Some(1), ""));
    assert!(said.err.starts_with("error: nowhere.urdf: "), "{}", said.err);
}

/// A bench with two URDFs below `robots`: the made one, and a broken one.
fn robots() -> Bench {
    let bench = Bench::done();
    let folder = bench.path("robots/deep");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::rename(bench.path("out"), bench.path("robots/made")).unwrap();
    std::fs::write(folder.join("broken.urdf"), BROKEN).unwrap();
    bench
}

#[test]
fn a_folder_is_checked_file_by_file_and_the_worst_decides() {
    let bench = robots();
    let [folder, report] = ["robots", "report.xml"].map(|n| bench.path(n).display().to_string());
    let said = say(&["check", &folder, "--tier", "static", "--junit", &report, "--jobs", "2"]);
    let lines: Vec<_> = said.out.lines().collect();
    assert_eq!((said.code, lines.len()), (Some(1), 3), "{said:?}");
    assert!(lines[0].starts_with("none ") && lines[0].contains("broken.urdf  F3"), "{lines:?}");
    assert!(lines[1].ends_with("made/asset.urdf"), "{lines:?}");
    assert_eq!(lines[2], "1 of 2 reach static");
    let report = std::fs::read_to_string(&report).unwrap();
    assert_eq!(report.matches("<testsuite ").count(), 2);
    assert!(report.contains("<failure ") && report.contains("made/asset.urdf"), "{report}");
    let alone = say(&["check", &folder, "--tier", "static", "--json", "--jobs", "1"]);
    let both = say(&["check", &folder, "--tier", "static", "--json", "--jobs", "2"]);
    assert_eq!(alone.out, both.out);
    assert!(alone.out.lines().all(|l| serde_json::from_str::<Value>(l).is_ok()));
    let said = say(&["check", bench.path("state").to_str().unwrap()]);
    assert_eq!(said.code, Some(1));
    assert!(said.err.contains("no model in it\nhint: files that end in .urdf"), "{}", said.err);
}

#[test]
fn a_waived_failure_stands_in_the_verdict_and_lowers_no_tier() {
    let bench = Bench::done();
    let path = bench.path("out/asset.urdf");
    let urdf = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, urdf.replacen("velocity=\"", "velocity=\"-", 1)).unwrap();
    let file = path.to_str().unwrap();
    let said = say(&["check", file, "--tier", "static"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    let args = ["check", file, "--tier", "static", "--json", "--waive", "J4=it is a sketch"];
    let said = say(&args);
    let verdict: Value = serde_json::from_str(&said.out).unwrap();
    let j4 = verdict["checks"].as_array().unwrap().iter().find(|c| c["id"] == "J4").unwrap();
    assert_eq!((&j4["status"], &j4["waived"]), (&"fail".into(), &"it is a sketch".into()));
    assert_eq!(verdict["counts"]["waived"], 1);
    let said = say(&["check", file, "--tier", "static", "--waive", "T1=never"]);
    assert!(said.err.contains("--waive T1: nothing failed it"), "{}", said.err);
    assert_eq!(say(&["check", file, "--waive", "J4="]).code, Some(2));
}

#[test]
fn a_check_that_takes_too_long_is_stopped_and_unknown() {
    let bench = Bench::done();
    let path = bench.path("out/asset.urdf");
    let said = say(&["check", path.to_str().unwrap(), "--deadline", "0.001"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.out.contains("the check took longer than 0.001 s and was stopped"), "{said:?}");
    assert!(said.out.contains(", 0 passed\n"), "{}", said.out);
}

#[test]
fn meshes_outside_the_folder_are_refused_unless_allowed() {
    let bench = Bench::done();
    let folder = bench.path("out/urdf");
    std::fs::create_dir_all(&folder).unwrap();
    let urdf = std::fs::read_to_string(bench.path("out/asset.urdf")).unwrap();
    let path = folder.join("asset.urdf");
    std::fs::write(&path, urdf.replace("meshes/", "../meshes/")).unwrap();
    let file = path.to_str().unwrap();
    let refused = say(&["check", file]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.out.contains("leaves the package with `..`"), "{}", refused.out);
    let allowed = say(&["check", file, "--allow-outside", "--tier", "static"]);
    assert_eq!(allowed.code, Some(0), "{allowed:?}");
    assert!(allowed.out.contains("lies outside the package, which was allowed"));
}

#[test]
fn a_trace_is_shown_whole_or_torn() {
    let bench = Bench::done();
    let path = bench.path("out/trace.mcap");
    let said = say(&["trace", "show", path.to_str().unwrap()]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(said.out.contains("articulate         finished"), "{}", said.out);
    assert!(said.out.lines().last().unwrap().starts_with("verdict: tier "), "{}", said.out);
    let bytes = std::fs::read(&path).unwrap();
    let torn = bench.path("torn.mcap");
    std::fs::write(&torn, &bytes[..bytes.len() / 2]).unwrap();
    let said = say(&["trace", "show", torn.to_str().unwrap(), "--json"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    let shown: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(shown["manifest"]["flow"], "image-to-urdf");
    assert!(said.err.contains("incomplete"), "{}", said.err);
    let said = say(&["trace", "show", bench.cabinet.photo.to_str().unwrap()]);
    assert_eq!(said.code, Some(1));
    assert!(said.err.contains("not a kinfold trace"), "{}", said.err);
}

#[test]
fn the_printed_schema_accepts_the_condition_and_refuses_a_typo() {
    let schema: Value = serde_json::from_str(&say(&["schema", "condition"]).out).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let mut condition = crate::cabinet::condition();
    assert!(validator.is_valid(&condition));
    condition["parts"][1]["join"] = "revolute".into();
    assert!(!validator.is_valid(&condition));
}
