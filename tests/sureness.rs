//! How sure an asset is: told, asked for, and kept in the ledger.

use serde_json::{Value, json};

use crate::batch::{Batch, number};
use crate::kinfold::CLOCK;

const GIVEN: [&str; 6] =
    ["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "cabinet.json"];

fn made(batch: &Batch, more: &[&str]) -> (Option<i32>, String, Value) {
    let own = ["--clock", CLOCK, "--state", "s", "--out", "made", "--json"];
    let said = batch.say(&[&GIVEN[..], &own, more].concat());
    let answer = serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {said:?}"));
    (said.code, said.err, answer)
}

fn probability(value: &Value) -> f64 {
    let value = value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    assert!((0.0..=1.0).contains(&value), "{value}");
    value
}

#[test]
fn an_asset_says_how_sure_each_part_and_joint_is_and_check_reads_it() {
    let batch = Batch::of(1);
    let (code, _, answer) = made(&batch, &["--min-confidence", "0"]);
    assert_eq!((code, &answer["outcome"]), (Some(0), &json!("done")), "{answer}");
    let whole = probability(&answer["confidence"]);
    let read = |name: &str| -> Value {
        serde_json::from_slice(&std::fs::read(batch.path("made").join(name)).unwrap()).unwrap()
    };
    let asset = read("asset.json");
    assert_eq!(probability(&asset["confidence"]["value"]), whole);
    for link in asset["links"].as_array().unwrap().iter().filter(|l| l.get("visual").is_some()) {
        probability(&link["confidence"]["labels"]["value"]);
    }
    for joint in asset["joints"].as_array().unwrap() {
        probability(&joint["confidence"]["axis"]["value"]);
        probability(&joint["confidence"]["joint"]["value"]);
    }
    let verdict = read("verdict.json");
    let right = verdict["checks"].as_array().unwrap().iter();
    let right: Vec<&Value> =
        right.filter(|c| c["id"].as_str().is_some_and(|id| id.starts_with('R'))).collect();
    assert_eq!(right.len(), 7);
    assert!(right.iter().all(|check| check["severity"] == "warning"), "{right:?}");
    probability(&right[0]["value"]);
}

#[test]
fn an_asset_less_sure_than_asked_for_exits_3_and_says_by_how_much() {
    let batch = Batch::of(1);
    let (code, err, answer) = made(&batch, &["--min-confidence", "1"]);
    assert_eq!((code, &answer["outcome"]), (Some(3), &json!("below the confidence")));
    let reason = answer["reason"].as_str().unwrap();
    assert!(reason.starts_with("confidence 0.") && reason.ends_with("below 1"), "{reason}");
    assert!(err.contains(reason), "{err}");
    let wrong = batch.say(&[&GIVEN[..], &["--min-confidence", "2"]].concat());
    assert_eq!(wrong.code, Some(2));
    assert!(wrong.err.contains("expected a probability from 0 to 1, found `2`"), "{wrong:?}");
}

#[test]
fn one_question_is_asked_with_what_each_answer_adds_to_the_condition() {
    let batch = Batch::of(1);
    let (_, err, answer) = made(&batch, &["--ask"]);
    assert!(err.contains("question: "), "{err}");
    // A plain slab of a door: nothing tells where its hinge is.
    let asked = &answer["question"];
    assert_eq!(asked["words"], "How does `door` move?", "{asked}");
    let answers = asked["answers"].as_array().unwrap();
    assert!(answers.len() >= 2, "{asked}");
    let change = &answers[0]["change"];
    assert_eq!(change["part"], "door", "{asked}");
    // What is printed can be put into the condition as it is, and is certain then.
    let mut told: Value =
        serde_json::from_slice(&std::fs::read(batch.path("cabinet.json")).unwrap()).unwrap();
    told["schema"] = json!("kinfold-condition/2");
    let parts = told["parts"].as_array_mut().unwrap();
    let door = parts.iter_mut().find(|part| part["name"] == "door").unwrap();
    for (field, value) in change["set"].as_object().unwrap() {
        door[field] = value.clone();
    }
    batch.write("told.json", told.to_string());
    let given = ["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "told.json"];
    let said = batch.say(&[&given[..], &["--state", "s", "--out", "told"]].concat());
    assert_eq!(said.code, Some(0), "{said:?}");
    let asset = std::fs::read(batch.path("told").join("asset.json")).unwrap();
    let asset: Value = serde_json::from_slice(&asset).unwrap();
    let sure = &asset["joints"][0]["confidence"];
    assert_eq!(
        [&sure["axis"]["value"], &sure["way"]["value"]],
        [&json!(1.0), &json!(1.0)],
        "{sure}"
    );
    let (_, err, quiet) = made(&batch, &[]);
    assert!(quiet.get("question").is_none() && !err.contains("question:"), "{err}");
}

#[test]
fn what_is_less_sure_than_its_line_asks_lies_in_quarantine_and_the_ledger_says_how_sure() {
    let batch = Batch::of(1);
    let mut strict = Batch::given("strict", 1);
    strict["min_confidence"] = json!(1.0);
    let mut wrong = Batch::given("wrong", 2);
    wrong["min_confidence"] = json!(1.5);
    let mut text = std::fs::read_to_string(batch.path("items.jsonl")).unwrap();
    text.push_str(&format!("{strict}\n{wrong}\n"));
    batch.write("items.jsonl", text);
    let (said, answer) = batch.ran(&["--min-confidence", "0"]);
    assert_eq!((said.code, number(&answer, "accepted")), (Some(3), 1), "{said:?}");
    assert!(
        said.err.contains("`min_confidence` is a probability from 0 to 1, found 1.5"),
        "{said:?}"
    );
    let reason = std::fs::read(batch.path("out/quarantine/strict/reason.json")).unwrap();
    let reason: Value = serde_json::from_slice(&reason).unwrap();
    assert!(reason["reason"].as_str().unwrap().starts_with("confidence 0."), "{reason}");
    assert_eq!((&reason["class"], &reason["stage"]), (&json!("model"), &json!("articulate")));
    assert_eq!(batch.ask("SELECT count(*) FROM items WHERE confidence BETWEEN 0 AND 1"), "2");
    assert_eq!(batch.say(&["audit", "out"]).code, Some(0));
    batch.say(&["batch", "report", "out"]);
    let mut sure = Vec::new();
    workflow::batch::index::read(&batch.path("out/index.parquet"), |row| {
        sure.extend(row.number("confidence"));
    })
    .unwrap();
    assert_eq!(sure.len(), 2, "{sure:?}");
    assert!(sure.iter().all(|p| (0.0..=1.0).contains(p)), "{sure:?}");
}
