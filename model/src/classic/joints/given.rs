//! What a person says of a joint is kept as it is, and what is not said follows from it.

use object::Range;
use object::condition::GivenJoint;

use crate::classic::joints::context::JointContext;
use crate::classic::joints::range::{Travel, usual};
use crate::classic::joints::scene::Scene;
use crate::classic::joints::sweep::Axis;
use crate::classic::lexicon::words::Role;

/// Candidates within 14° of a direction that is given tell where its axis lies.
const ALONG: f64 = 0.97;
/// Candidates that pass a pivot that is given within this tell its axis' direction: a share of the object's
/// diagonal, and as far as two lines count as one ([`crate::classic::joints::hypotheses`]).
const THROUGH: f64 = 0.02;
/// What goes no farther than this the one way, as a share of the other, opens the other way.
const HARDLY: f64 = 0.05;

/// Candidates with their scores in the light of what is given: those that agree with it, moved onto it.
pub(crate) fn narrowed(
    axes: Vec<(f64, Axis)>,
    given: &GivenJoint,
    scene: &Scene,
    turns: bool,
) -> Vec<(f64, Axis)> {
    let pivot = given.pivot.map(|p| (p - scene.origin) / scene.unit);
    let best = axes.iter().map(|(score, _)| *score).fold(f64::NEG_INFINITY, f64::max);
    let moved = |axis: &Axis| Axis {
        direction: given.axis.unwrap_or(axis.direction),
        pivot: pivot.unwrap_or(axis.pivot),
        turns,
    };
    match (given.axis, pivot) {
        (None, None) => axes,
        (Some(direction), Some(pivot)) => {
            let score = if best.is_finite() { best } else { 0.0 };
            vec![(score, Axis { direction, pivot, turns })]
        }
        _ => {
            let agrees = |axis: &Axis| match (given.axis, pivot) {
                (Some(direction), _) => axis.direction.dot(direction).abs() > ALONG,
                (_, Some(pivot)) => !turns || axis.radius(pivot) < THROUGH,
                _ => true,
            };
            let some = axes.iter().any(|(_, axis)| agrees(axis));
            let kept = axes.iter().filter(|(_, axis)| !some || agrees(axis));
            kept.map(|(score, axis)| (*score, moved(axis))).collect()
        }
    }
}

/// A motion that was found, with what is given in its place. Scene units.
pub(crate) fn kept(
    context: &JointContext,
    found: Travel,
    given: &GivenJoint,
    role: Role,
) -> Travel {
    let mut travel = found;
    if let Some(direction) = given.axis {
        if travel.axis.direction.dot(direction) < 0.0 {
            travel = travel.reversed();
        }
        travel.axis.direction = direction;
    }
    let slide = if travel.axis.turns { 1.0 } else { context.scene.unit };
    if let Some(range) = given.range {
        let range = range.scaled(1.0 / slide);
        return Travel { range, stuck: false, rough: false, ..travel };
    }
    let Some(open_by) = given.open_by else { return travel };
    let (mut lower, mut upper) = travel.range.ends();
    if given.axis.is_none() && upper < HARDLY * -lower {
        // What only goes back from where it is shown, and is shown as open by so much, opens that way.
        travel = travel.reversed();
        (lower, upper) = travel.range.ends();
    }
    let open_by = open_by / slide;
    let whole = usual(role, travel.axis.turns).open * context.length(&travel.axis);
    let ahead = if open_by > 0.0 { upper.min((whole - open_by).max(0.0)) } else { upper };
    // A range is never empty: what is shown shut and finds no way goes as far as others of its kind.
    let none = open_by <= 0.0 && ahead <= 0.0;
    let upper = if none { whole.max(-lower) } else { ahead };
    Travel { range: Range::Limits { lower: -open_by, upper }, stuck: false, ..travel }
}

/// What is given of the joints of every part, lengths in the mesh's unit; empty where nothing is given.
pub(crate) fn of_parts(
    condition: &object::Condition,
    part_of_condition: &[Option<usize>],
    scale: f64,
) -> Vec<Vec<GivenJoint>> {
    let count = part_of_condition.iter().flatten().max().map_or(0, |last| last + 1);
    let mut given = vec![Vec::new(); count];
    let of = condition.tree.parts().iter().zip(&condition.prompts).zip(part_of_condition);
    for ((part, prompt), place) in of {
        let Some(slot) = place.and_then(|place| given.get_mut(place)) else { continue };
        *slot = prompt
            .joints
            .iter()
            .zip(&part.joints)
            .map(|(joint, kind)| if kind.turns() { *joint } else { in_units(joint, scale) })
            .collect();
    }
    given
}

/// A slide's lengths in the mesh's unit, of which one has `scale` metres.
fn in_units(joint: &GivenJoint, scale: f64) -> GivenJoint {
    let range = joint.range.map(|range| range.scaled(1.0 / scale));
    GivenJoint { range, open_by: joint.open_by.map(|open| open / scale), ..*joint }
}
