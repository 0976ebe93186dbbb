//! Joints as `truth.json` of a development case has them.

use object::{DVec3, JointKind, JointMotion, Range};
use serde_json::Value;

/// A joint, z up; nothing where it does not move or is not told as expected. An end that is not told is far
/// enough: 3 rad, 0.1 units.
pub(crate) fn motion(joint: &Value) -> Option<JointMotion> {
    let vector = |v: &Value| {
        let at = |i: usize| v[i].as_f64();
        Some(DVec3::new(at(0)?, -at(2)?, at(1)?))
    };
    let (lower, upper) = (joint["lower"].as_f64(), joint["upper"].as_f64());
    let limits = |span: f64| {
        let (lower, upper) = (lower.unwrap_or(-span).min(0.0), upper.unwrap_or(span).max(0.0));
        (upper > lower).then_some(Range::Limits { lower, upper })
    };
    let (kind, range) = match joint["type"].as_str()? {
        "continuous" => (JointKind::Continuous, Range::Continuous),
        "revolute" => (JointKind::Revolute, limits(3.0)?),
        _ => (JointKind::Prismatic, limits(0.1)?),
    };
    let axis = vector(&joint["axis"])?.normalize();
    Some(JointMotion { kind, axis, pivot: vector(&joint["pivot"])?, range })
}
