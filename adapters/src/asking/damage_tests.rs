//! Every question, answered with damage of every kind: a result or an error, never a panic, and
//! nothing told that a terminal would obey.

use std::sync::{Arc, Mutex};

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use trace::Digest;

use super::tests::{Script, asking, mesh, parts, physical, points, views};
use super::*;
use crate::contract::tests::flap;
use crate::damage::{misshapen, torn};
use crate::photo::tests::png;
use crate::{Critic, CritiqueQuestion, Photo, Request, Response, Transport, TransportError};

/// How answers are damaged.
#[derive(Clone, Copy, Debug)]
enum Damage {
    /// They stay JSON.
    Shape,
    /// They need not be anything.
    Bytes,
}

/// A model that knows the answers, of which some are damaged on their way, in what it says or in the
/// envelope it comes in.
struct Damaging {
    damage: Damage,
    rng: Mutex<Pcg64Mcg>,
}

impl Transport for Damaging {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let mut rng = self.rng.lock().unwrap();
        let mut harmed = |bytes: Vec<u8>| match (rng.random_range(0..4), self.damage) {
            (0, Damage::Shape) => misshapen(&bytes, &mut rng),
            (0, Damage::Bytes) => torn(&bytes, &mut rng),
            _ => bytes,
        };
        let said = harmed(right(&request.step).to_string().into_bytes());
        let said = String::from_utf8_lossy(&said).into_owned();
        let body = json!({ "choices": [{ "finish_reason": "stop", "message": { "content": said } }],
            "usage": { "prompt_tokens": 7, "completion_tokens": 5 } });
        let body = harmed(body.to_string().into_bytes());
        Ok(Response { status: 200, headers: vec![], body })
    }
}

fn right(step: &str) -> Value {
    match step.split(['.', '/']).nth(1) {
        Some("kinematics") => parts(),
        Some("points") => points(),
        Some("physical") => physical(),
        Some("critic") => {
            let flag = json!({ "part_id": "p1", "fault": "limit", "reason": "it stops too early" });
            json!({ "flags": [flag] })
        }
        _ => json!({ "points": [{ "label": "red", "point": [620, 140] },
            { "label": "green", "point": [230, 710] }, { "label": "blue", "point": [860, 550] }] }),
    }
}

/// Asks everything many times through damage; gives what was told where nothing came of it.
fn told_of(damage: Damage, times: u64) -> Vec<String> {
    let (photo, digest, object) =
        (Photo::read(png(40, 40), "p").unwrap(), Digest::of(b"object"), flap());
    let (mesh, views) = (mesh(), views());
    let about_parts = KinematicQuestion { photo: &photo, mesh: &mesh, views: &views };
    let about_motion =
        CritiqueQuestion { photo: &photo, object: &object, digest: &digest, views: &views };
    let (mut told, plain) = (vec![], asking(&Arc::<Script>::default()));
    for seed in 0..times {
        let rng = Mutex::new(Pcg64Mcg::seed_from_u64(seed));
        let transport: Arc<dyn Transport> = Arc::new(Damaging { damage, rng });
        let asking = Asking { codec: plain.codec.clone(), transport, ..plain };
        let answers = [
            asking.propose(&about_parts).map(drop),
            asking.points_at_dots().map(drop),
            asking.criticise(&about_motion).map(drop),
        ];
        told.extend(answers.into_iter().filter_map(Result::err).map(|e| format!("{e} {e:?}")));
    }
    told
}

#[test]
fn no_damaged_answer_makes_a_judge_panic_or_tell_what_a_terminal_obeys() {
    for damage in [Damage::Shape, Damage::Bytes] {
        let told = told_of(damage, 150);
        assert!(told.len() > 50, "the damage must be felt, found {} errors", told.len());
        for told in told {
            assert!(!told.contains('\u{1b}'), "a terminal would obey: {told}");
            assert!(told.len() < 8000, "{} bytes: {}", told.len(), &told[..200]);
        }
    }
}

#[test]
fn an_answer_that_is_wrong_everywhere_is_not_told_in_full() {
    let flag = json!({ "part_id": "x".repeat(2000), "fault": "none", "reason": "\u{1b}[2J" });
    let wrong = json!({ "flags": vec![flag; 500] }).to_string();
    let steps = ["vlm.critic/0", "vlm.critic/1", "vlm.critic/2"];
    let answers = steps.map(|step| (step, wrong.clone())).into();
    let script = Arc::new(Script { answers, ..Script::default() });
    let (photo, digest) = (Photo::read(png(40, 40), "p").unwrap(), Digest::of(b"object"));
    let (object, views) = (flap(), views());
    let question =
        CritiqueQuestion { photo: &photo, object: &object, digest: &digest, views: &views };
    let told = asking(&script).criticise(&question).unwrap_err().to_string();
    assert!(told.contains("and 493 more") && told.len() < 4000, "{} bytes: {told}", told.len());
    let asked = script.asked.lock().unwrap();
    let repair = asked[1].1["messages"][3]["content"][0]["text"].as_str().unwrap();
    assert!(repair.len() < 20_000, "{} bytes", repair.len());
}
