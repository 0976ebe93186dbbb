//! The pose a model is judged at: the one it is written in, unless that lies outside its limits.
//!
//! Knees and elbows often cannot be straight. Such a model is told anew from a pose within its
//! limits: the one the file declares (a keyframe of MJCF), else the end of each range nearest to
//! what is written. Every joint remembers what the file calls that pose.

use std::collections::BTreeMap;

use glamx::DVec3;

use crate::robot::{Joint, Motion, Robot};

/// How far the rest pose may lie outside the limits, for rounding.
pub(crate) const REST: f64 = 1e-9;

/// Moves the rest pose within the limits where it lies outside, and notes which joints cannot be
/// moved at all.
pub(crate) fn settle(robot: &mut Robot, declared: &BTreeMap<String, f64>, name: &str) {
    hold(robot);
    let inside = robot.joints.iter().all(|j| holds(j, 0.0));
    if inside {
        return;
    }
    let told = |j: &Joint| declared.get(&j.name).copied();
    let is_sound = |j: &Joint| told(j).is_some_and(|q| holds(j, q)) || !j.kind.has_axis();
    let is_declared = !declared.is_empty() && robot.joints.iter().all(is_sound);
    if is_declared {
        robot.beside.declared = Some(name.to_owned());
    }
    let mut rest: Vec<f64> = robot.joints.iter().map(nearest).collect();
    if is_declared {
        rest = robot.joints.iter().map(|j| told(j).unwrap_or(0.0)).collect();
    } else {
        follow(robot, &mut rest);
    }
    for (joint, at) in robot.joints.iter_mut().zip(&rest) {
        shift(joint, *at);
    }
    for j in 0..robot.joints.len() {
        let Some(mut mimic) = robot.joints[j].mimic else { continue };
        let leads = rest[mimic.joint];
        mimic.offset += mimic.multiplier * leads - rest[j];
        robot.joints[j].mimic = Some(mimic);
    }
}

/// Why a joint has no range to be moved through.
fn hold(robot: &mut Robot) {
    for joint in robot.joints.iter_mut().filter(|j| j.kind.has_axis() && j.held.is_none()) {
        let fault = match joint.axis == DVec3::ZERO {
            true => Some("axis has no direction".to_owned()),
            false => range_fault(joint),
        };
        joint.held = fault.map(|fault| format!("cannot be moved: {fault}"));
    }
}

/// What is wrong with a joint's range, if anything.
pub(crate) fn range_fault(joint: &Joint) -> Option<String> {
    if !matches!(joint.kind, Motion::Revolute | Motion::Prismatic) {
        return None;
    }
    let Some((lower, upper)) = joint.limits_as_written() else {
        return Some("has no <limit>".into());
    };
    let shown = crate::verdict::figure;
    let range = || format!("limits {} to {}", shown(lower), shown(upper));
    (lower >= upper).then(|| format!("{} are not ordered", range()))
}

/// Whether a value lies within a joint's limits; of a joint that has none, or none in order, every
/// value does.
fn holds(joint: &Joint, q: f64) -> bool {
    let limited = matches!(joint.kind, Motion::Revolute | Motion::Prismatic);
    let Some(limit) = joint.limit.filter(|l| limited && l.lower < l.upper) else { return true };
    limit.lower <= q + REST && limit.upper >= q - REST
}

/// The value within the limits that is nearest to 0.
fn nearest(joint: &Joint) -> f64 {
    match joint.limit.filter(|_| !holds(joint, 0.0)) {
        Some(limit) => 0f64.clamp(limit.lower, limit.upper),
        None => 0.0,
    }
}

/// Followers stand where their leader puts them; where a follower's limits leave that out, it is
/// the leader that the follower's range does not fit.
fn follow(robot: &Robot, rest: &mut [f64]) {
    for _ in 0..robot.joints.len() {
        for j in 0..robot.joints.len() {
            if let Some(mimic) = robot.joints[j].mimic {
                rest[j] = mimic.multiplier * rest[mimic.joint] + mimic.offset;
            }
        }
    }
}

/// The same joint, told from a value of it.
fn shift(joint: &mut Joint, at: f64) {
    if at == 0.0 || !at.is_finite() {
        return;
    }
    joint.origin *= joint.motion(at);
    joint.rest += at;
    if let Some(limit) = &mut joint.limit {
        limit.lower -= at;
        limit.upper -= at;
        // The end it stands at is 0 itself.
        let near = |v: f64| if v.abs() <= REST { 0.0 } else { v };
        (limit.lower, limit.upper) = (near(limit.lower), near(limit.upper));
    }
    if let Some(spring) = &mut joint.spring {
        spring.at -= at;
    }
}
