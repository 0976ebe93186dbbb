//! The critic against a model that answers from a script, rightly and in every wrong way.

use std::sync::Arc;

use object::{Condition, KinematicTree};
use serde_json::{Value, json};
use trace::Digest;

use super::critic::judged;
use super::tests::{Script, asking};
use crate::contract::{check_critic, tests::flap};
use crate::critic::{JointFault, MAX_REASON, Remark};
use crate::photo::tests::png;
use crate::{AdapterError, Critic, CritiqueQuestion, Photo, RenderedView};

fn flags() -> Value {
    json!({ "flags": [{ "part_id": "p1", "fault": "axis", "reason": "it turns the other way" }] })
}

fn criticise(
    answers: &[(&'static str, Value)],
) -> (Result<Vec<Remark>, AdapterError>, Arc<Script>) {
    let answers = answers.iter().map(|(step, v)| (*step, v.to_string())).collect();
    let script = Arc::new(Script { answers, ..Script::default() });
    let (photo, object) = (Photo::read(png(40, 40), "p").unwrap(), flap());
    let view = |name: &str| RenderedView { name: name.into(), png: png(50, 50) };
    let views = ["at rest", "every joint at its upper limit"].map(view);
    let digest = Digest::of(b"object");
    let question =
        CritiqueQuestion { photo: &photo, object: &object, digest: &digest, views: &views };
    let asking = asking(&script);
    let made = asking.criticise(&question);
    if made.is_ok() {
        check_critic(&asking, &question).unwrap().unwrap();
    }
    (made, script)
}

#[test]
fn a_right_answer_is_a_remark_on_each_part_that_moves() {
    let (remarks, script) = criticise(&[("vlm.critic/0", flags())]);
    let asked = script.asked.lock().unwrap();
    let reason = "it turns the other way".to_owned();
    let expected = Remark { part: "flap".into(), fault: JointFault::Axis, reason };
    assert_eq!(remarks.unwrap(), [expected]);
    let content = asked[0].1["messages"][1]["content"].as_array().unwrap();
    assert_eq!(content.len(), 4, "words, the photo and two pictures");
    let words = content[0]["text"].as_str().unwrap();
    assert!(words.contains("at rest; every joint at its upper limit"), "{words}");
    assert!(
        words.contains("- p1 (\"flap\", on \"body\"): turns about an axis along right"),
        "{words}"
    );
    assert!(!words.contains("- p0"), "what does not move is not asked about: {words}");
}

#[test]
fn a_wrong_answer_goes_back_with_its_faults_and_one_that_stays_wrong_fails() {
    let wrong = json!({ "flags": [{ "part_id": "p0", "fault": "none", "reason": "" }] });
    let answers = [("vlm.critic/0", wrong.clone()), ("vlm.critic/1", flags())];
    let (remarks, script) = criticise(&answers);
    assert_eq!(remarks.unwrap().len(), 1);
    let messages = script.asked.lock().unwrap()[1].1["messages"].to_string();
    assert!(messages.contains("F01") && messages.contains("p1 has no flag"), "{messages}");
    let stays = ["vlm.critic/0", "vlm.critic/1", "vlm.critic/2"].map(|s| (s, wrong.clone()));
    let error = criticise(&stays).0.unwrap_err().to_string();
    assert!(error.contains("critic: still wrong after 2 rounds of repair"), "{error}");
}

fn tree() -> KinematicTree {
    let text = r#"{"schema": "kinfold-condition/1", "parts": [{"name": "body"},
        {"name": "lid", "parent": "body", "joint": "revolute"},
        {"name": "foot", "parent": "body"},
        {"name": "drawer", "parent": "body", "joint": "prismatic"}]}"#;
    Condition::from_json(text).unwrap().tree
}

fn two() -> Value {
    let flag = |id: &str| json!({ "part_id": id, "fault": "none", "reason": "" });
    json!({ "flags": [flag("p3"), flag("p1")] })
}

/// The codes of the rules a changed answer breaks.
fn codes(change: impl Fn(&mut Value)) -> Vec<&'static str> {
    let mut value = two();
    change(&mut value);
    judged(value, &tree()).err().unwrap_or_default().iter().map(|f| f.code).collect()
}

#[test]
fn every_rule_about_flags_is_kept() {
    assert!(codes(|_| ()).is_empty());
    assert_eq!(codes(|v| v["flags"][0]["part_id"] = json!("p9")), ["F01", "F02"]);
    assert_eq!(codes(|v| v["flags"][0]["part_id"] = json!("p2")), ["F01", "F02"]);
    assert_eq!(codes(|v| v["flags"][0]["part_id"] = json!("p01")), ["F01", "F02"]);
    assert_eq!(codes(|v| v["flags"][0]["part_id"] = json!("p1")), ["F02", "F02"]);
    assert_eq!(codes(|v| v["flags"] = json!([])), ["F02", "F02"]);
    assert_eq!(codes(|v| v["flags"][1]["fault"] = json!("limit")), ["F03"]);
    assert_eq!(codes(|v| v["flags"][1]["fault"] = json!("colour")), ["J02"]);
    assert_eq!(codes(|v| v["flags"][1]["more"] = json!(1)), ["J02"]);
}

#[test]
fn remarks_come_in_the_order_of_parts_with_reasons_a_terminal_may_show() {
    let mut value = two();
    value["flags"][0]["fault"] = json!("joint_type");
    value["flags"][0]["reason"] = json!(format!(" \u{1b}[2Jit\nturns{}", " on".repeat(200)));
    let remarks = judged(value, &tree()).unwrap();
    let parts: Vec<_> = remarks.iter().map(|r| r.part.as_str()).collect();
    assert_eq!(parts, ["lid", "drawer"]);
    let reason = &remarks[1].reason;
    assert!(reason.starts_with("[2Jit turns on"), "{reason}");
    assert!(reason.ends_with('…') && reason.chars().count() <= MAX_REASON, "{reason}");
}

#[test]
fn faults_stand_in_the_order_in_which_they_are_looked_for() {
    let words = JointFault::WORDS.map(|w| serde_json::from_value::<JointFault>(json!(w)).unwrap());
    assert!(words.is_sorted());
    assert_eq!(words[4], JointFault::None);
}

#[test]
fn the_words_of_the_question_are_in_the_critics_identity_and_in_nobody_elses() {
    let asking = asking(&Arc::default());
    let (critic, vlm) =
        (Critic::identity(&asking).unwrap(), crate::Vlm::identity(&asking).unwrap());
    assert!(critic.starts_with("openai-chat/1 some-vlm"), "{critic}");
    let prompts =
        |id: &str| id.split("prompts ").nth(1).unwrap().split(' ').next().unwrap().to_owned();
    assert_ne!(prompts(&critic), prompts(&vlm));
}
