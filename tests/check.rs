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
