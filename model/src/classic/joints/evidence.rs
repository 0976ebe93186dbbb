//! What speaks for a joint as it was found: how likely its axis is against others, whether other labellings
//! agree, and how sure the ways it goes are.

use object::Range;

use crate::classic::joints::choices::distinct;
use crate::classic::joints::context::JointContext;
use crate::classic::joints::hypotheses::{are_along, are_one};
use crate::classic::joints::range::{Travel, is_pressed, usual};
use crate::classic::joints::siblings::Ballot;
use crate::classic::joints::sweep::Axis;
use crate::classic::learned::pack::place;
use crate::classic::lexicon::words::Role;

/// What is told of a joint, in order.
pub(crate) const NAMES: [&str; 38] = [
    "chance",
    "chance_next",
    "chance_along",
    "chance_along_next",
    "own_chance",
    "own_chance_along",
    "united_chance",
    "united_chance_along",
    "agree",
    "agree_along",
    "others_chance",
    "candidates",
    "turns",
    "endless",
    "way",
    "way_next",
    "way_both",
    "amount",
    "reach",
    "one_way",
    "stuck",
    "rough",
    "free_opening",
    "free_closing",
    "to_the_eye",
    "gap",
    "shut",
    "handle",
    "along_extent",
    "extent",
    "carries",
    "siblings",
    "known_word",
    "pressed",
    "shutter",
    "drawer",
    "round",
    "lever",
];
/// The numbers of [`NAMES`] that say how likely the axis and the way are.
pub(crate) const CHANCE: usize = place(&NAMES, "chance");
pub(crate) const WAY: usize = place(&NAMES, "way");
/// How many numbers that are.
pub(crate) const COUNT: usize = NAMES.len();

/// What was heard of a joint before its siblings were.
#[derive(Clone)]
pub(crate) struct Heard {
    /// By the labels that are kept.
    pub own: Ballot,
    /// By others.
    pub others: Vec<Ballot>,
    /// By all of them.
    pub united: Ballot,
}

/// The numbers of [`NAMES`] of one joint: what was heard of it, its candidates at last, and how it moves.
pub(crate) fn evidence(
    context: &JointContext,
    (heard, voted): (&Heard, &Ballot),
    travel: &Travel,
) -> [f64; COUNT] {
    let mut all = [0.0; COUNT];
    let chances = chances((heard, voted), &travel.axis);
    let told = chances.into_iter().chain(motion(context, voted.role, travel));
    all.iter_mut().zip(told).for_each(|(to, from)| *to = from);
    all
}

/// How likely an axis is against others, and whether other labellings agree.
fn chances((heard, voted): (&Heard, &Ballot), axis: &Axis) -> [f64; 12] {
    let Heard { own, others, united } = heard;
    let last = distinct(voted);
    let (one, along) = chance_of(voted, axis);
    let next = last.iter().find(|(_, other)| !are_one(other, axis)).map_or(0.0, |l| l.0);
    let along_next = last.iter().find(|(_, other)| !are_along(other, axis));
    let along_next = along_next.map_or(0.0, |(_, other)| chance_of(voted, other).1);
    let (own_one, own_along) = chance_of(own, axis);
    let (united_one, united_along) = chance_of(united, axis);
    let heard: Vec<&Ballot> = others.iter().filter(|b| !b.axes.is_empty()).collect();
    let share = |is: &dyn Fn(&Ballot) -> f64| match heard.len() {
        0 => 1.0,
        count => heard.iter().map(|b| is(b)).sum::<f64>() / count as f64,
    };
    let is_best = |ballot: &Ballot, is: fn(&Axis, &Axis) -> bool| {
        let likelier = |a: (f64, Axis), b: (f64, Axis)| if b.0 > a.0 { b } else { a };
        let best = ballot.axes.iter().copied().reduce(likelier);
        truth(best.is_some_and(|(_, other)| is(&other, axis)))
    };
    [
        one,
        next,
        along,
        along_next,
        own_one,
        own_along,
        united_one,
        united_along,
        share(&|b| is_best(b, are_one)),
        share(&|b| is_best(b, are_along)),
        share(&|b| chance_of(b, axis).0),
        (1.0 + voted.axes.len() as f64).ln(),
    ]
}

/// How a joint moves, and what its axis is to the part.
fn motion(context: &JointContext, role: Role, travel: &Travel) -> [f64; 26] {
    let axis = &travel.axis;
    let length = context.length(axis);
    let is_endless = travel.range == Range::Continuous;
    let (lower, upper) = match travel.range {
        Range::Limits { lower, upper } => (lower, upper),
        Range::Continuous => (0.0, 0.0),
    };
    let span = upper - lower;
    let far = upper.max(-lower);
    let opening = if upper >= -lower { *axis } else { axis.reversed() };
    let reach = usual(role, axis.turns);
    let limit = reach.open.max(reach.close) * length;
    let free = |axis: &Axis| match is_endless {
        true => 0.0,
        false => context.firmly_free(axis, limit) / limit,
    };
    let to_the_eye = context.comes_to_the_eye(&opening);
    let radius = context.body.probes.iter().map(|&p| axis.radius(p)).fold(1e-6, f64::max);
    let handle = context.grip.or(context.handle).filter(|_| axis.turns);
    let extent = context.body.bounds.size().max_element();
    let (low, high) = context.body.extent(axis.direction);
    let said = travel.said.unwrap_or_default();
    [
        truth(axis.turns),
        truth(is_endless),
        said.way,
        said.next,
        said.both,
        said.amount,
        span / length,
        if span > 0.0 { far / span } else { 0.0 },
        truth(travel.stuck),
        truth(travel.rough),
        free(&opening),
        free(&opening.reversed()),
        to_the_eye.map_or(0.0, |is| 2.0 * truth(is) - 1.0),
        if axis.turns { context.gap(axis) } else { 0.0 },
        truth(context.is_shut(axis)),
        handle.map_or(-1.0, |at| axis.radius(at) / radius),
        (high - low) / extent.max(1e-6),
        extent,
        truth(context.carries),
        context.siblings as f64,
        truth(role != Role::Other),
        truth(is_pressed(axis, role)),
        truth(matches!(role, Role::Door | Role::FallDoor | Role::Lid | Role::Flap)),
        truth(role == Role::Drawer),
        truth(matches!(role, Role::Wheel | Role::Knob | Role::Pointer)),
        truth(role == Role::Lever),
    ]
}

fn truth(is: bool) -> f64 {
    f64::from(u8::from(is))
}

/// The chance of all candidates that are one with an axis, and of all along it.
fn chance_of(ballot: &Ballot, axis: &Axis) -> (f64, f64) {
    let best = ballot.axes.iter().map(|a| a.0).fold(f64::NEG_INFINITY, f64::max);
    let all: f64 = ballot.axes.iter().map(|a| (a.0 - best).exp()).sum();
    let (mut one, mut along) = (0.0, 0.0);
    for (score, other) in &ballot.axes {
        let chance = (score - best).exp() / all;
        one += if are_one(other, axis) { chance } else { 0.0 };
        along += if are_along(other, axis) { chance } else { 0.0 };
    }
    (one, along)
}

#[cfg(test)]
mod tests {
    use object::{DVec3, JointKind};

    use super::*;

    #[test]
    fn candidates_that_are_one_count_together_and_those_along_count_once_more() {
        let axis = |direction, x: f64| Axis { direction, pivot: DVec3::X * x, turns: true };
        let said = [(0.4, DVec3::Z, 0.0), (0.1, -DVec3::Z, 0.001), (0.3, DVec3::Z, 0.3)];
        let axes = said.into_iter().chain([(0.2, DVec3::Y, 0.0)]);
        let axes = axes.map(|(p, d, x)| (f64::ln(p), axis(d, x))).collect();
        let (kind, role) = (JointKind::Revolute, Role::Door);
        let ballot = Ballot { part: 1, joint: 0, kind, role, stem: String::new(), axes };
        let (one, along) = chance_of(&ballot, &axis(DVec3::Z, 0.0));
        assert!((one - 0.5).abs() < 1e-12 && (along - 0.8).abs() < 1e-12, "{one}, {along}");
    }
}
