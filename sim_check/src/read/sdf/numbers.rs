//! Numbers of SDFormat: between tags, with the word for what has no end.

use glamx::{DPose3, DQuat, DVec3};

use super::tree::{Element, is_true};
use crate::read::draft::{Faults, MAX_LENGTH};
use crate::read::xml::shown;

/// From here on a limit is none: the format's own word for it, 1e16, where no `inf` is written.
const ENDLESS: f64 = 1e16;

/// A broken number of one element, which is not there for the checks.
pub(super) fn flaw(faults: &mut Faults, of: &Element, what: impl std::fmt::Display) {
    faults.numbers.push(format!("{}: {what}", of.at()));
}

/// The numbers an element says; `None` where one of them is none or there are not so many.
pub(super) fn numbers(faults: &mut Faults, of: &Element, count: usize) -> Option<Vec<f64>> {
    let words: Vec<&str> = of.text.split_whitespace().collect();
    if words.len() != count {
        let (text, found) = (shown(&of.text), words.len());
        flaw(faults, of, format!("`{text}` must be {count} numbers, found {found}"));
        return None;
    }
    let mut all = Vec::with_capacity(count);
    for word in words {
        match word.parse::<f64>() {
            Ok(value) if value.abs() <= MAX_LENGTH => all.push(value),
            Ok(value) if value.is_finite() => {
                flaw(faults, of, format!("{value} is beyond {MAX_LENGTH:e}"));
                return None;
            }
            Ok(_) => {
                flaw(faults, of, format!("`{}` is not finite", shown(word)));
                return None;
            }
            Err(_) => {
                let hint = if word.contains(',') { " (a comma is no decimal point)" } else { "" };
                flaw(faults, of, format!("`{}` is not a number{hint}", shown(word)));
                return None;
            }
        }
    }
    Some(all)
}

/// Three numbers.
pub(super) fn vector(faults: &mut Faults, of: &Element) -> Option<DVec3> {
    numbers(faults, of, 3).map(|n| DVec3::new(n[0], n[1], n[2]))
}

/// One number in an element, or what stands for it where nothing is said.
pub(super) fn number(faults: &mut Faults, of: &Element, tag: &str, unsaid: f64) -> f64 {
    let Some(told) = of.child(tag).filter(|c| !c.text.is_empty()) else { return unsaid };
    numbers(faults, told, 1).map_or(unsaid, |n| n[0])
}

/// One number that must be said.
pub(super) fn due(faults: &mut Faults, of: &Element, tag: &str) -> f64 {
    if of.said(tag).is_none() {
        flaw(faults, of, format!("has no `{tag}`"));
    }
    number(faults, of, tag, 0.0)
}

/// A limit in an element; `None` where nothing is said, or that there is none.
pub(super) fn end(faults: &mut Faults, of: &Element, tag: &str) -> Option<f64> {
    let told = of.child(tag).filter(|c| !c.text.is_empty())?;
    match told.text.parse::<f64>() {
        Ok(value) if value.is_nan() => {
            flaw(faults, told, "`nan` is no limit");
            None
        }
        Ok(value) => (value.abs() < ENDLESS).then_some(value),
        Err(_) => {
            flaw(faults, told, format!("`{}` is not a number", shown(&told.text)));
            None
        }
    }
}

/// Where an element stands in the frame it is told in.
pub(super) fn pose(faults: &mut Faults, of: &Element) -> DPose3 {
    let Some(pose) = of.child("pose").filter(|p| !p.text.is_empty()) else {
        return DPose3::identity();
    };
    let is_quaternion = pose.get("rotation_format") == Some("quat_xyzw");
    let count = if is_quaternion { 7 } else { 6 };
    let Some(n) = numbers(faults, pose, count) else { return DPose3::identity() };
    let at = DVec3::new(n[0], n[1], n[2]);
    if is_quaternion {
        let told = DQuat::from_xyzw(n[3], n[4], n[5], n[6]);
        let length = told.length();
        if !(length > 1e-9 && length.is_finite()) {
            flaw(faults, pose, "its quaternion is no turn");
            return DPose3::identity();
        }
        return DPose3::from_parts(at, told.normalize());
    }
    let unit = if pose.get("degrees").is_some_and(is_true) { 1f64.to_radians() } else { 1.0 };
    let [roll, pitch, yaw] = [n[3], n[4], n[5]].map(|a| a * unit);
    let turn =
        DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch) * DQuat::from_rotation_x(roll);
    DPose3::from_parts(at, turn)
}

/// The frame that an element's pose is told in, where it says one.
pub(super) fn relative_to(of: &Element) -> Option<String> {
    let pose = of.child("pose")?;
    pose.get("relative_to").or(pose.get("frame")).map(str::to_owned)
}
