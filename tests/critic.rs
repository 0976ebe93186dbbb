//! The optional critic: it flags, it is recorded, and whatever becomes of it nothing else changes.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

use object::Condition;
use serde_json::{Value, json};

use crate::cabinet::Cabinet;
use crate::kinfold::{Said, files, names, say};
use crate::replays::{Made, replays_to_the_same_bytes};
use crate::server::Server;
use crate::services::{self, Object};

const ON: &str = "critic = true\n";

/// A cabinet made of nothing but a photo, by a server whose answers are changed so.
fn made(more: &str, change: impl Fn(&mut Object)) -> (Made, Said) {
    let folder = tempfile::tempdir().unwrap();
    let (cabinet, mut object) = cabinet(folder.path());
    change(&mut object);
    Made::with(&cabinet.photo, object.serve(), more)
}

fn cabinet(folder: &Path) -> (Cabinet, Object) {
    let cabinet = Cabinet::write(folder);
    let text = std::fs::read_to_string(&cabinet.condition).unwrap();
    let object = Object::of(&cabinet.mesh, &Condition::from_json(&text).unwrap());
    (cabinet, object)
}

fn out(made: &Made) -> BTreeMap<String, Vec<u8>> {
    files(&made.path("out"))
}

fn critique(made: &Made) -> Value {
    serde_json::from_slice(&out(made)["critic.json"]).unwrap()
}

/// The key of every stage, by its name.
fn keys(made: &Made, out: &str) -> BTreeMap<String, String> {
    let trace = trace::read(&made.path(out).join("trace.mcap")).unwrap();
    trace.events.into_iter().map(|(_, e)| (e.stage, e.key)).collect()
}

/// Makes it again, from the same state directory, with these lines in its section.
fn again(made: &Made, more: &str, out: &str) -> Said {
    let config = format!("{}{more}", services::config(made.server.port));
    std::fs::write(made.path("kinfold.toml"), config).unwrap();
    made.make(out)
}

#[test]
fn a_critic_flags_and_changes_nothing_else() {
    let (made, plain) = made("", |_| ());
    let said = again(&made, ON, "with");
    assert_eq!((plain.code, said.code), (Some(0), Some(0)), "{said:?}");
    assert_eq!(made.server.count("POST", "/v1"), 4, "nobody is asked anything again");
    let warning =
        "warning: part `door`: the direction of the axis looks wrong: it turns sideways\n";
    assert!(said.err.ends_with(warning), "{}", said.err);
    assert_eq!(said.out.replace("with/", "out/"), plain.out);
    let (mut with_it, mut without_it) = (files(&made.path("with")), out(&made));
    let critique: Value = serde_json::from_slice(&with_it.remove("critic.json").unwrap()).unwrap();
    let door = json!({ "part": "door", "fault": "axis", "reason": "it turns sideways" });
    assert_eq!(critique, json!({ "remarks": [door] }));
    assert!(with_it.remove("trace.mcap") != without_it.remove("trace.mcap"));
    // The marker names the files of each.
    assert!(with_it.remove(".kinfold") != without_it.remove(".kinfold"));
    assert_eq!(names(&with_it), names(&without_it));
    assert!(with_it == without_it, "the asset and its verdict are as they were");
    let mut with_it = keys(&made, "with");
    with_it.remove("criticise").unwrap();
    assert_eq!(with_it, keys(&made, "out"), "no other stage has another key");
}

#[test]
fn a_critique_is_recorded_replayed_and_verified() {
    let (made, _) = made(ON, |_| ());
    replays_to_the_same_bytes(&made);
    let trace = trace::read(&made.path("out/trace.mcap")).unwrap();
    let (_, event) =
        trace.events.iter().find(|(_, e)| e.stage == "criticise" && !e.outputs.is_empty()).unwrap();
    assert_eq!((event.calls.len(), event.outputs[0].name.as_str()), (1, "critic.json"));
    assert!(event.notes[0].contains("it turns sideways"), "{:?}", event.notes);
    let call: Value = serde_json::from_slice(trace.calls.last().unwrap()).unwrap();
    assert_eq!(call["step"], "vlm.critic/0");
    let manifest = trace.manifest.unwrap();
    assert!(manifest.parameters["critic"].as_str().unwrap().contains("some-vlm"));
    let verify = || say(&["trace", "verify", &made.trace()]);
    let verified = say(&["trace", "verify", &made.trace(), "--verbose"]);
    assert_eq!(verified.code, Some(0), "{verified:?}");
    assert!(verified.out.contains(" critic.json\n"), "{}", verified.out);
    std::fs::write(made.path("out/critic.json"), "{\"remarks\": []}").unwrap();
    let tampered = verify();
    assert!(tampered.err.contains("critic.json does not follow"), "{tampered:?}");
}

#[test]
fn without_the_setting_nothing_tells_of_a_critic() {
    let (made, _) = made("", |_| ());
    assert_eq!(made.server.count("POST", "/v1"), 3, "nobody else is asked");
    let trace = trace::read(&made.path("out/trace.mcap")).unwrap();
    assert!(trace.events.iter().all(|(_, e)| e.stage != "criticise"));
    let manifest = serde_json::to_string(&trace.manifest.unwrap()).unwrap();
    assert!(!manifest.contains("critic"), "{manifest}");
    assert_eq!(again(&made, "critic = false\n", "off").code, Some(0));
    assert_eq!(made.server.count("POST", "/v1"), 3);
    assert!(files(&made.path("off")) == out(&made), "off is as if there were no such word");
    std::fs::write(made.path("out/critic.json"), "{}").unwrap();
    let strange = say(&["trace", "verify", &made.trace()]);
    assert!(strange.err.contains("critic.json is not a file of this run"), "{strange:?}");
}

/// A critique was asked for and did not come: the run says why and is none the worse for it.
fn is_lost(made: &Made, said: &Said, why: &str) {
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(said.err.contains("warning: no critique: ") && said.err.contains(why), "{}", said.err);
    let told = critique(made);
    assert!(told["no_critique"].as_str().unwrap().contains(why), "{told}");
    assert!(out(made).contains_key("asset.urdf"));
    replays_to_the_same_bytes(made);
    let verified = say(&["trace", "verify", &made.trace()]);
    assert_eq!(verified.code, Some(0), "{verified:?}");
}

#[test]
fn a_critic_who_refuses_is_gone_without() {
    let (made, said) = made(ON, |object| object.flags = services::Said::Refusal);
    is_lost(&made, &said, "a refusal: I cannot judge that");
    assert_eq!(made.server.count("POST", "/v1"), 4, "a refusal is no fault to repair");
}

#[test]
fn a_critic_whose_answer_stays_wrong_is_gone_without() {
    let none = json!({ "flags": [] });
    let (made, said) = made(ON, |object| object.flags = services::Said::Answer(none.clone()));
    is_lost(&made, &said, "p1 has no flag");
    assert_eq!(made.server.count("POST", "/v1"), 6, "it was asked and sent back twice");
}

#[test]
fn a_budget_that_is_used_up_leaves_no_critique() {
    let (made, said) = made(&format!("{ON}[budget]\ncalls = 4\n"), |_| ());
    is_lost(&made, &said, "the budget of 4 calls is used up");
    assert_eq!(made.server.count("POST", "/v1"), 3);
}

#[test]
fn a_lost_critique_is_asked_for_again_by_the_next_run() {
    let folder = tempfile::tempdir().unwrap();
    let (cabinet, object) = cabinet(folder.path());
    let refuses = Object { flags: services::Said::Refusal, ..object.clone() };
    let critics = Mutex::new(0);
    let server = Server::start(move |asked| {
        let body = serde_json::from_slice::<Value>(&asked.body).unwrap_or_default();
        let schema = body.pointer("/response_format/json_schema/name");
        let first = schema == Some(&json!("critic")) && {
            let mut times = critics.lock().unwrap();
            *times += 1;
            *times == 1
        };
        if first { refuses.answer(asked) } else { object.answer(asked) }
    });
    let (made, said) = Made::with(&cabinet.photo, server, ON);
    assert!(said.err.contains("no critique"), "{said:?}");
    let again = made.make("out");
    assert_eq!(again.code, Some(0), "{again:?}");
    assert!(again.err.contains("it turns sideways"), "{again:?}");
    assert_eq!(made.server.count("POST", "/v1"), 5, "nothing else is asked again");
    replays_to_the_same_bytes(&made);
    assert_eq!(made.make("out").code, Some(0));
    assert_eq!(made.server.count("POST", "/v1"), 5, "what was answered is kept");
}

#[test]
fn nobody_criticises_a_condition_that_was_given() {
    let bench = crate::kinfold::Bench::new();
    let config = format!("{}{ON}", services::config(9));
    std::fs::write(bench.path("kinfold.toml"), config).unwrap();
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(!bench.out().contains_key("critic.json"));
}
