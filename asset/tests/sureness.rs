//! How sure an object was stands in the files of its asset, in the asset's own frame and by its links' names.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]

mod cabinet;

use asset::{Amendment, Asset, Measures, finish, shape};
use cabinet::{BODY, CAP, DOOR, MAP, cabinet, condition};
use object::confidence::{Doubt, JointConfidence, OtherAxis, PartConfidence};
use object::{Confidence, DVec3, Origin};
use serde_json::Value;

/// Sure of all but the door and the cap.
fn confidence() -> Confidence {
    let object = cabinet();
    let sure = |part: usize| {
        let joint = |motion: &object::JointMotion| {
            let way = (motion.range != object::Range::Continuous).then_some(0.9);
            let line = motion.kind.turns().then_some(0.95);
            let instead = OtherAxis { axis: DVec3::X, pivot: DVec3::ONE, chance: 0.5 };
            JointConfidence { axis: 0.99, line, way, joint: 0.9, instead: Some(instead) }
        };
        let joints = object.joints(part).iter().map(joint).collect();
        PartConfidence { labels: 0.98, doubt: None, joints }
    };
    let mut parts: Vec<PartConfidence> = (0..object.tree().len()).map(sure).collect();
    let at = DVec3::new(1.0, 0.985, 1.3);
    parts[DOOR].doubt = Some(Doubt { other: BODY, chance: 0.4, share: 0.5, at });
    parts[DOOR].labels = 0.45;
    parts[DOOR].joints[0].axis = 1.0;
    parts[CAP].joints[1].joint = 0.25;
    Confidence { object: 0.2, parts }
}

fn built() -> Asset {
    let shapes = shape(&cabinet(), &Measures::of(&condition()), &MAP, 0).unwrap();
    let shapes = shapes.with_confidence(Some(confidence()));
    let stored = serde_json::to_string(&shapes).unwrap();
    let read = serde_json::from_str(&stored).unwrap();
    assert!(shapes == read, "it is stored with the shapes");
    finish(read, &condition(), Origin::Model).unwrap()
}

fn sidecar(asset: &Asset) -> Value {
    serde_json::from_slice(&asset.to_urdf().files["asset.json"]).unwrap()
}

fn entry(sidecar: &Value, list: &str, name: &str) -> Value {
    let entries = sidecar[list].as_array().unwrap();
    entries.iter().find(|entry| entry["name"] == name).unwrap()["confidence"].clone()
}

#[test]
fn every_link_and_joint_says_how_sure_it_is_and_by_whom() {
    let sidecar = sidecar(&built());
    assert_eq!(sidecar["confidence"]["value"], 0.2);
    assert_eq!(sidecar["confidence"]["origin"], "model");
    let door = entry(&sidecar, "links", "door");
    assert_eq!((&door["labels"]["value"], &door["doubt"]["other"]), (&0.45.into(), &"body".into()));
    assert_eq!((&door["doubt"]["chance"]["value"]), &Value::from(0.4));
    let turn = entry(&sidecar, "joints", "door_turn");
    assert_eq!((&turn["axis"]["value"], &turn["axis"]["origin"]), (&1.0.into(), &"user".into()));
    assert_eq!(turn["line"]["origin"], "model");
    let [slide, turn] =
        ["Drawer_cap_slide", "Drawer_cap_turn"].map(|j| entry(&sidecar, "joints", j));
    assert_eq!((&slide["joint"]["value"], &turn["joint"]["value"]), (&0.9.into(), &0.25.into()));
    assert!(slide.get("line").is_none() && turn.get("way").is_none(), "{slide} {turn}");
}

#[test]
fn what_is_doubtful_is_placed_where_it_is_in_the_asset() {
    let asset = built();
    let at = &entry(&sidecar(&asset), "links", "door")["doubt"]["at"]["value"];
    let at: Vec<f64> = at.as_array().unwrap().iter().filter_map(Value::as_f64).collect();
    let wanted = asset.turn * (asset.scale.value * DVec3::new(1.0, 0.985, 1.3)) + asset.offset;
    assert!((DVec3::from_slice(&at) - wanted).length() < 1e-12, "{at:?}, {wanted}");
}

#[test]
fn a_joint_that_was_turned_round_is_as_likely_right_as_it_was_wrong() {
    let flipped = built().amended("door_turn", Amendment::Flip, ["", ""], "C5").unwrap();
    let turn = entry(&sidecar(&flipped), "joints", "door_turn");
    let way = turn["way"]["value"].as_f64().unwrap();
    assert!((way - 0.1).abs() < 1e-12 && turn["joint"]["value"].as_f64() == Some(way), "{turn}");
}

#[test]
fn an_object_of_which_nothing_is_known_says_nothing() {
    let sidecar = sidecar(&cabinet::built());
    assert!(sidecar.get("confidence").is_none());
    assert!(!sidecar.to_string().contains("confidence"));
}
