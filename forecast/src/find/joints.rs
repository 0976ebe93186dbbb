//! Joints: ranges, axes, kinds, what they say of motors and followers.

use std::collections::{BTreeMap, BTreeSet};

use crate::find::place::{at, at_joint};
use crate::read::urdf::{Joint, Limit, Urdf};
use crate::rule::Place;

/// How far an axis' length may be from 1: the rounding of numbers with four digits.
const ROUNDING: f64 = 1e-3;
/// What URDF knows, and `spherical`, which some readers do.
const KINDS: [&str; 7] =
    ["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical"];

fn which(urdf: &Urdf, is: impl Fn(&Joint) -> bool, found: impl Fn(&Joint) -> String) -> Vec<Place> {
    urdf.joints.iter().filter(|j| is(j)).map(|j| at_joint(j, &found(j))).collect()
}

fn kind(joint: &Joint) -> String {
    joint.kind.clone()
}

fn is_driven(joint: &Joint) -> bool {
    joint.has_range() || joint.kind == "continuous"
}

fn range(limit: Option<Limit>) -> (Option<f64>, Option<f64>) {
    limit.map_or((None, None), |l| (l.lower, l.upper))
}

fn told(joint: &Joint) -> String {
    match range(joint.limit) {
        (Some(lower), Some(upper)) => format!("{lower} .. {upper}"),
        (Some(lower), None) => format!("lower {lower} alone"),
        (None, Some(upper)) => format!("upper {upper} alone"),
        (None, None) if joint.limit.is_some() => "no lower, no upper".to_string(),
        (None, None) => "no <limit>".to_string(),
    }
}

/// Fixed joints.
pub(crate) fn fixed(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| j.kind == "fixed", |j| j.child.clone())
}

/// Joints that a motor could drive: revolute, continuous, prismatic.
pub(crate) fn movable(urdf: &Urdf) -> Vec<Place> {
    which(urdf, is_driven, kind)
}

/// Joints that no transmission names.
pub(crate) fn without_transmission(urdf: &Urdf) -> Vec<Place> {
    let named: BTreeSet<_> = urdf.transmissions.iter().map(|(name, _)| name.as_str()).collect();
    which(urdf, |j| is_driven(j) && !named.contains(j.name.as_str()), kind)
}

/// Transmissions of joints whose effort is 0.
pub(crate) fn transmission_without_effort(urdf: &Urdf) -> Vec<Place> {
    let weak = urdf.joints.iter().filter(|j| j.limit.is_some_and(|l| l.effort == Some(0.0)));
    let weak: BTreeSet<_> = weak.map(|j| j.name.as_str()).collect();
    let found = urdf.transmissions.iter().filter(|(name, _)| weak.contains(name.as_str()));
    found.map(|(name, line)| at("transmission", name, *line, "effort 0")).collect()
}

/// Joints whose effort is 0.
pub(crate) fn effort_zero(urdf: &Urdf) -> Vec<Place> {
    let zero = |j: &Joint| j.limit.is_some_and(|l| l.effort == Some(0.0));
    which(urdf, |j| is_driven(j) && zero(j), |_| "effort 0".to_string())
}

/// Joints with a speed limit.
pub(crate) fn with_velocity(urdf: &Urdf) -> Vec<Place> {
    let speed = |j: &Joint| j.limit.and_then(|l| l.velocity);
    which(
        urdf,
        |j| is_driven(j) && speed(j).is_some(),
        |j| speed(j).map_or_else(String::new, |v| format!("velocity {v}")),
    )
}

/// Joints with an effort.
pub(crate) fn with_effort(urdf: &Urdf) -> Vec<Place> {
    let effort = |j: &Joint| j.limit.and_then(|l| l.effort);
    which(
        urdf,
        |j| is_driven(j) && effort(j).is_some(),
        |j| effort(j).map_or_else(String::new, |e| format!("effort {e}")),
    )
}

/// Joints with an effort or a speed limit.
pub(crate) fn with_strength(urdf: &Urdf) -> Vec<Place> {
    let is = |l: Limit| l.effort.is_some() || l.velocity.is_some();
    which(urdf, |j| is_driven(j) && j.limit.is_some_and(is), kind)
}

/// Continuous joints with a range.
pub(crate) fn continuous_with_range(urdf: &Urdf) -> Vec<Place> {
    let both = |j: &Joint| matches!(range(j.limit), (Some(_), Some(_)));
    which(urdf, |j| j.kind == "continuous" && both(j), told)
}

/// Ranges whose ends are equal.
pub(crate) fn range_empty(urdf: &Urdf) -> Vec<Place> {
    let equal = |j: &Joint| matches!(range(j.limit), (Some(a), Some(b)) if a == b);
    which(urdf, |j| j.has_range() && equal(j), told)
}

/// Revolute and prismatic joints without lower and upper end.
pub(crate) fn range_missing(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| j.has_range() && range(j.limit) == (None, None), told)
}

/// The same, with a `<limit>`.
pub(crate) fn range_missing_in_limit(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| j.has_range() && j.limit.is_some() && range(j.limit) == (None, None), told)
}

/// Revolute and prismatic joints without `<limit>`.
pub(crate) fn limit_missing(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| j.has_range() && j.limit.is_none(), told)
}

/// Ranges of which one end is written.
pub(crate) fn range_one_sided(urdf: &Urdf) -> Vec<Place> {
    let one = |j: &Joint| matches!(range(j.limit), (Some(_), None) | (None, Some(_)));
    which(urdf, |j| j.has_range() && one(j), told)
}

/// Ranges of which only the lower end is written.
pub(crate) fn range_without_upper(urdf: &Urdf) -> Vec<Place> {
    let one = |j: &Joint| matches!(range(j.limit), (Some(_), None));
    which(urdf, |j| j.has_range() && one(j), told)
}

/// Slides with a `<limit>` that lacks one end or both.
pub(crate) fn slide_range_incomplete(urdf: &Urdf) -> Vec<Place> {
    let whole = |j: &Joint| matches!(range(j.limit), (Some(_), Some(_)));
    which(urdf, |j| j.kind == "prismatic" && j.limit.is_some() && !whole(j), told)
}

/// Hinges with a `<limit>` that lacks one end or both.
pub(crate) fn hinge_range_incomplete(urdf: &Urdf) -> Vec<Place> {
    let whole = |j: &Joint| matches!(range(j.limit), (Some(_), Some(_)));
    which(urdf, |j| j.kind == "revolute" && j.limit.is_some() && !whole(j), told)
}

/// Revolute and prismatic joints with a `<limit>` that lacks one end or both.
pub(crate) fn range_incomplete(urdf: &Urdf) -> Vec<Place> {
    let whole = |j: &Joint| matches!(range(j.limit), (Some(_), Some(_)));
    which(urdf, |j| j.has_range() && j.limit.is_some() && !whole(j), told)
}

/// Joints of which effort or velocity is not written.
pub(crate) fn strength_missing(urdf: &Urdf) -> Vec<Place> {
    let mut places = limit_missing(urdf);
    places.extend(limit_incomplete(urdf));
    places
}

/// `<limit>` without effort or without velocity.
pub(crate) fn limit_incomplete(urdf: &Urdf) -> Vec<Place> {
    let part = |l: Limit| l.effort.is_none() || l.velocity.is_none();
    let found = |j: &Joint| match j.limit.and_then(|l| l.effort) {
        None => "no effort".to_string(),
        Some(_) => "no velocity".to_string(),
    };
    which(urdf, |j| is_driven(j) && j.limit.is_some_and(part), found)
}

fn length(joint: &Joint) -> f64 {
    joint.axis.map_or(1.0, |a| a.iter().map(|x| x * x).sum::<f64>().sqrt())
}

/// Axes without a direction.
pub(crate) fn axis_zero(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| is_driven(j) && length(j) == 0.0, |_| "axis 0 0 0".to_string())
}

/// Slides along an axis that is not of length 1.
pub(crate) fn axis_long(urdf: &Urdf) -> Vec<Place> {
    let long = |j: &Joint| length(j) > 0.0 && (length(j) - 1.0).abs() > ROUNDING;
    which(urdf, |j| j.kind == "prismatic" && long(j), |j| format!("axis of length {}", length(j)))
}

/// Floating joints.
pub(crate) fn floating(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| j.kind == "floating", kind)
}

/// Floating joints whose origin is not the parent's.
pub(crate) fn floating_off(urdf: &Urdf) -> Vec<Place> {
    let off = |j: &Joint| j.origin.iter().any(|x| *x != 0.0);
    which(urdf, |j| j.kind == "floating" && off(j), |j| format!("origin {:?}", j.origin))
}

/// Planar joints.
pub(crate) fn planar(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| j.kind == "planar", kind)
}

/// Planar joints with a range.
pub(crate) fn planar_with_range(urdf: &Urdf) -> Vec<Place> {
    let both = |j: &Joint| matches!(range(j.limit), (Some(_), Some(_)));
    which(urdf, |j| j.kind == "planar" && both(j), told)
}

/// Floating and planar joints.
pub(crate) fn floating_or_planar(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| matches!(j.kind.as_str(), "floating" | "planar"), kind)
}

/// Kinds that URDF does not know.
pub(crate) fn unknown(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| !KINDS.contains(&j.kind.as_str()), kind)
}

/// The same, and planar ones.
pub(crate) fn unknown_or_planar(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| j.kind == "planar" || !KINDS.contains(&j.kind.as_str()), kind)
}

/// Joints that follow another one.
pub(crate) fn followers(urdf: &Urdf) -> Vec<Place> {
    which(urdf, |j| j.mimic.is_some(), leader)
}

fn leader(joint: &Joint) -> String {
    joint.mimic.as_ref().map_or_else(String::new, |m| format!("follows {}", m.joint))
}

/// The joints by their names.
fn by_name(urdf: &Urdf) -> BTreeMap<&str, &Joint> {
    urdf.joints.iter().map(|j| (j.name.as_str(), j)).collect()
}

fn led_by<'u>(joints: &BTreeMap<&str, &'u Joint>, follower: &Joint) -> Option<&'u Joint> {
    joints.get(follower.mimic.as_ref()?.joint.as_str()).copied()
}

/// Followers on their leader's parent, for whom it matters which way round they are coupled.
pub(crate) fn followers_beside(urdf: &Urdf) -> Vec<Place> {
    let matters = |j: &Joint| {
        j.mimic.as_ref().is_some_and(|m| {
            m.multiplier != 0.0
                && ((m.multiplier * m.multiplier - 1.0).abs() > ROUNDING
                    || (m.multiplier > 0.0 && m.offset != 0.0))
        })
    };
    let joints = by_name(urdf);
    let beside = |j: &Joint| led_by(&joints, j).is_some_and(|l| l.parent == j.parent);
    which(urdf, |j| matters(j) && beside(j), leader)
}

/// Followers neither on their leader's parent nor on what the leader carries.
pub(crate) fn followers_apart(urdf: &Urdf) -> Vec<Place> {
    let joints = by_name(urdf);
    let apart =
        |j: &Joint| led_by(&joints, j).is_some_and(|l| l.parent != j.parent && l.child != j.parent);
    which(urdf, apart, leader)
}

/// Joints with friction.
pub(crate) fn with_friction(urdf: &Urdf) -> Vec<Place> {
    let rubs = |j: &Joint| j.dynamics.and_then(|(_, f)| f).filter(|f| *f != 0.0);
    which(
        urdf,
        |j| is_driven(j) && rubs(j).is_some(),
        |j| rubs(j).map_or_else(String::new, |f| format!("friction {f}")),
    )
}

/// `<dynamics>` without damping.
pub(crate) fn dynamics_without_damping(urdf: &Urdf) -> Vec<Place> {
    let bare = |j: &Joint| matches!(j.dynamics, Some((None, _)));
    which(urdf, |j| is_driven(j) && bare(j), |_| "no damping".to_string())
}

/// `<safety_controller>`s.
pub(crate) fn safety(urdf: &Urdf) -> Vec<Place> {
    let lines = urdf.joints.iter().filter_map(|j| Some((j, j.safety?)));
    lines.map(|(j, line)| at("safety_controller", &j.name, line, "")).collect()
}
