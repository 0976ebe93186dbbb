//! The schemas of our questions, in the subset that every service takes: flat, all keys required,
//! no unknown keys, no bounds. Bounds are rules of ours.

use serde_json::{Value, json};

use crate::critic::JointFault;

/// An object with these keys and no others.
fn object(keys: &[(&str, Value)]) -> Value {
    let names: Vec<_> = keys.iter().map(|(name, _)| *name).collect();
    let properties: serde_json::Map<_, _> =
        keys.iter().map(|(name, schema)| ((*name).to_owned(), schema.clone())).collect();
    json!({ "type": "object", "additionalProperties": false, "required": names,
        "properties": properties })
}

fn list(items: &Value) -> Value {
    json!({ "type": "array", "items": items })
}

fn words(allowed: &[&str]) -> Value {
    json!({ "type": "string", "enum": allowed })
}

fn a(kind: &str) -> Value {
    json!({ "type": kind })
}

fn maybe(kind: &str) -> Value {
    json!({ "type": [kind, "null"] })
}

/// The answer to "which parts are there": [`super::parts::PartsAnswer`].
pub fn kinematics() -> Value {
    let part = object(&[
        ("id", a("string")),
        ("name", a("string")),
        ("text", a("string")),
        ("parent", maybe("string")),
        ("joint_types", list(&words(&["prismatic", "revolute"]))),
        ("motion", a("string")),
        ("visible_views", list(&a("integer"))),
        ("confidence", words(&["high", "medium", "low"])),
    ]);
    let verdicts = ["articulated", "rigid", "deformable", "multiple_objects", "unclear"];
    object(&[
        ("verdict", words(&verdicts)),
        ("category", a("string")),
        ("description", a("string")),
        ("has_canonical_orientation", a("boolean")),
        ("front_view", maybe("integer")),
        ("parts", list(&part)),
    ])
}

/// The answer to "where are they", a point under the key the model is used to.
pub fn points(key: &str) -> Value {
    let point = object(&[
        ("part_id", a("string")),
        ("view", a("integer")),
        (key, list(&a("integer"))),
        ("label", a("string")),
    ]);
    object(&[("points", list(&point)), ("not_visible", list(&a("string")))])
}

/// The answer to "where are the three dots".
pub fn dots(key: &str) -> Value {
    let point = object(&[("label", a("string")), (key, list(&a("integer")))]);
    object(&[("points", list(&point))])
}

/// The answer to "which joints look wrong".
pub fn critic() -> Value {
    let flag = object(&[
        ("part_id", a("string")),
        ("fault", words(&JointFault::WORDS)),
        ("reason", a("string")),
    ]);
    object(&[("flags", list(&flag))])
}

/// The answer to "how large, of what, how heavy": [`super::physical::PhysicalAnswer`].
pub fn physical() -> Value {
    let scale = object(&[
        ("dimension", words(&["height", "width", "depth"])),
        ("meters_min", a("number")),
        ("meters_best", a("number")),
        ("meters_max", a("number")),
        ("basis", a("string")),
    ]);
    let materials = [
        "wood",
        "engineered_wood",
        "plastic",
        "steel",
        "aluminium",
        "brass",
        "glass",
        "ceramic",
        "stone",
        "rubber",
        "foam",
        "fabric",
        "leather",
        "cardboard",
        "electronics_mixed",
        "other",
    ];
    let part = object(&[
        ("part_id", a("string")),
        ("material", words(&materials)),
        ("density_kg_m3", a("number")),
        ("construction", words(&["solid", "hollow_shell", "panel", "mixed"])),
        ("wall_thickness_m", maybe("number")),
        ("mass_kg_min", a("number")),
        ("mass_kg_max", a("number")),
        ("static_friction", a("number")),
        ("dynamic_friction", a("number")),
    ]);
    object(&[("scale", scale), ("parts", list(&part))])
}
