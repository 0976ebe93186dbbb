//! Whoever says what parts there are, where, of what, and what looks wrong.

use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, OnceLock};

use adapters::asking::pointing::Convention;
use adapters::asking::{Asking, critic, parts, physical};
use adapters::chat::openai::LengthKey;
use adapters::chat::{Anthropic, Codec, Gemini, OpenAi};
use adapters::{AdapterError, Critic, CritiqueQuestion, KinematicQuestion, RenderedView, Vlm};
use object::{
    ArticulatedObject, Condition, DVec3, JointKind, JointMotion, KinematicTree, Mesh, Range,
};
use serde_json::{Value, json};
use trace::Digest;

use super::Script;
use super::services::photo;

const CONDITION: &str = r#"{"schema": "kinfold-condition/1", "parts": [{"name": "body"},
    {"name": "flap", "parent": "body", "joint": "revolute"}]}"#;

/// Asks a model everything; it speaks one of three protocols and writes points in one of two ways. The
/// last one is asked for the three dots alone, whose picture takes longest to draw.
pub fn ask(who: u8, script: Script) -> Result<(), AdapterError> {
    read_alone(&script);
    let (base, model) = ("http://127.0.0.1:8000".to_owned(), "m".to_owned());
    let key = || "canary-key".to_owned().into();
    let codec: Box<dyn Codec> = match who % 3 {
        0 => {
            let (key, length) = (Some(key()), LengthKey::Plain);
            Box::new(OpenAi { base, key, model, temperature: None, length })
        }
        1 => Box::new(Anthropic { base, key: key(), model }),
        _ => Box::new(Gemini { base, key: key(), model }),
    };
    let convention = if who < 3 { Convention::Yx1000 } else { Convention::XyPixels };
    let asking = Asking { codec, transport: Arc::new(script), convention, max_tokens: 4000 };
    if who == 5 {
        return asking.points_at_dots().map(drop);
    }
    let (object, views) = known();
    let question = KinematicQuestion { photo: photo(), mesh: object.mesh(), views };
    let proposed = asking.propose(&question).map(drop);
    let digest = Digest::of(b"object");
    let question = CritiqueQuestion { photo: photo(), object, digest: &digest, views };
    asking.criticise(&question)?;
    proposed
}

/// The parsers by themselves, on each answer as it stands.
fn read_alone(script: &Script) {
    let Ok(answer) = parts::judged(right_parts(), 8) else { unreachable!("a right answer") };
    let (object, _) = known();
    for text in &script.answers {
        let Ok(value) = serde_json::from_slice::<Value>(text) else { continue };
        let _ = parts::judged(value.clone(), 8).is_ok();
        let _ = physical::judged(value.clone(), &answer.parts).is_ok();
        let _ = critic::judged(value, object.tree()).is_ok();
    }
}

/// An answer in the envelope of the protocol that is spoken at an address.
pub fn enveloped(url: &str, text: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(text);
    let answer = if url.ends_with("/chat/completions") {
        json!({ "choices": [{ "finish_reason": "stop", "message": { "content": text } }] })
    } else if url.ends_with("/messages") {
        json!({ "stop_reason": "end_turn", "content": [{ "type": "text", "text": text }] })
    } else {
        json!({ "candidates": [{ "finishReason": "STOP",
            "content": { "parts": [{ "text": text }] } }] })
    };
    answer.to_string().into_bytes()
}

fn right_parts() -> Value {
    let part = |id: &str, parent: Option<&str>, joints: &[&str]| {
        json!({ "id": id, "name": "part", "text": "a part", "parent": parent,
            "joint_types": joints, "motion": "it moves", "visible_views": [1],
            "confidence": "high" })
    };
    json!({ "verdict": "articulated", "category": "box", "description": "a box with a flap",
        "has_canonical_orientation": false, "front_view": 1,
        "parts": [part("p0", None, &[]), part("p1", Some("p0"), &["revolute"])] })
}

/// A body with a flap, and its eight views, of which nobody looks at the pixels.
fn known() -> (&'static ArticulatedObject, &'static [RenderedView]) {
    static KNOWN: OnceLock<(ArticulatedObject, Vec<RenderedView>)> = OnceLock::new();
    let (object, views) = KNOWN.get_or_init(|| {
        let object = flap();
        let picture = view::Picture::blank([100, 100], [200, 200, 200, 255]);
        let png = view::encode_png(&picture).expect("a picture");
        let standard = view::eight_views(&object.mesh().bounds(), 100);
        let view = |v: &view::View| RenderedView { name: v.name.into(), png: png.clone() };
        let views = standard.iter().map(view).collect();
        (object, views)
    });
    (object, views)
}

fn flap() -> ArticulatedObject {
    let corners = [(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, -0.5, 1.0), (-0.5, -0.5, 1.0)];
    let before = corners.map(|(x, y, z)| DVec3::new(x * 0.6, y - 0.1, z * 0.8));
    let behind = corners.map(|(x, y, z)| DVec3::new(x, y, z));
    let points = behind.into_iter().chain(before).collect();
    let faces = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let mesh = Mesh::new(points, faces).expect("a mesh");
    let tree: KinematicTree = Condition::from_json(CONDITION).expect("a condition").tree;
    let range = Range::Limits { lower: 0.0, upper: FRAC_PI_2 };
    let (axis, pivot) = (DVec3::X, DVec3::new(0.0, -0.6, 0.0));
    let turn = JointMotion { kind: JointKind::Revolute, axis, pivot, range };
    let joints = vec![vec![], vec![turn]];
    ArticulatedObject::new(mesh, tree, vec![0, 0, 1, 1], joints).expect("an object")
}
