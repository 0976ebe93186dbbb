//! Places an axis by several labellings of the same surface, not by one alone.
//!
//! Wrong labels move an axis, though seldom all the same way. So an axis that is likely under most
//! labellings is likely right. Its direction is left to the labelling that is kept.

use object::DVec3;

use crate::classic::joints::siblings::Ballot;
use crate::classic::joints::sweep::Axis;

/// How much other labellings count together; the rest is the labelling that is kept.
const OTHERS: f64 = 0.5;
/// Directions are one within this angle: cos 8°.
const SAME_DIRECTION: f64 = 0.990_268;
/// Lines are one within this distance, a share of the object's diagonal.
const SAME_LINE: f64 = 0.02;
/// What only other labellings show is a candidate if one of them gives it this chance.
const SHOWN: f64 = 0.05;
/// No axis is less likely than this.
const LEAST: f64 = 1e-9;

/// A chance and its axis.
type Chance = (f64, Axis);

/// The ballot of a joint after what its candidates are worth under other labellings is heard: for each,
/// its own chance, and the chance of what is near it there, on average. Of candidates with one direction
/// the best is as likely as the best was before, and the others are as much less so as this says. Axes
/// that only others show come last.
pub fn united(own: Ballot, others: &[&Ballot]) -> Ballot {
    if others.is_empty() {
        return own;
    }
    let mine = chances(&own);
    let theirs: Vec<Vec<Chance>> = others.iter().map(|other| chances(other)).collect();
    let heard = |axis: &Axis| {
        let all: f64 = theirs.iter().map(|chances| near(axis, chances)).sum();
        OTHERS * all / theirs.len() as f64
    };
    let worth = |&(chance, axis): &Chance| ((1.0 - OTHERS) * chance + heard(&axis), axis);
    let mut all: Vec<Chance> = mine.iter().map(worth).collect();
    for &(chance, axis) in theirs.iter().flatten() {
        if chance >= SHOWN && all.iter().all(|(_, known)| !are_one(known, &axis)) {
            all.push((heard(&axis), axis));
        }
    }
    let score = |&(chance, axis): &Chance| {
        let share = chance / best_along(&axis, &all).max(LEAST);
        ((best_along(&axis, &mine) * share).max(LEAST).ln(), axis)
    };
    Ballot { axes: all.iter().map(score).collect(), ..own }
}

/// The chance of the likeliest axis with this direction.
fn best_along(axis: &Axis, chances: &[Chance]) -> f64 {
    let along = chances.iter().filter(|(_, other)| are_along(axis, other));
    along.map(|(chance, _)| *chance).fold(0.0, f64::max)
}

/// How likely each candidate is among the others.
fn chances(ballot: &Ballot) -> Vec<Chance> {
    let best = ballot.axes.iter().map(|a| a.0).fold(f64::NEG_INFINITY, f64::max);
    let all: f64 = ballot.axes.iter().map(|a| (a.0 - best).exp()).sum();
    ballot.axes.iter().map(|a| ((a.0 - best).exp() / all, a.1)).collect()
}

/// The chance that one of the axes near this one is right.
fn near(axis: &Axis, chances: &[Chance]) -> f64 {
    chances.iter().filter(|(_, other)| are_one(axis, other)).map(|(chance, _)| chance).sum()
}

/// Whether two axes are one for all that matters; pivots lie beside the part.
pub(crate) fn are_one(a: &Axis, b: &Axis) -> bool {
    are_along(a, b) && (!a.turns || apart(a, b) < SAME_LINE)
}

pub(crate) fn are_along(a: &Axis, b: &Axis) -> bool {
    a.direction.dot(b.direction).abs() > SAME_DIRECTION
}

/// How far two nearly parallel lines are from each other near their pivots.
fn apart(a: &Axis, b: &Axis) -> f64 {
    let off = |axis: &Axis, at: DVec3| axis.radius(at);
    off(a, b.pivot).min(off(b, a.pivot))
}

#[cfg(test)]
mod tests {
    use object::JointKind;

    use super::*;
    use crate::classic::lexicon::words::Role;

    const UP: DVec3 = DVec3::Z;

    /// A door's ballot: chances of axes by direction and place along x.
    fn door(axes: &[(f64, DVec3, f64)]) -> Ballot {
        let axis = |direction, x: f64| Axis { direction, pivot: DVec3::X * x, turns: true };
        let axes = axes.iter().map(|&(chance, way, x)| (chance.ln(), axis(way, x))).collect();
        let (kind, role) = (JointKind::Revolute, Role::Door);
        Ballot { part: 1, joint: 0, kind, role, stem: String::new(), axes }
    }

    fn best(ballot: &Ballot) -> Axis {
        let likelier = |a: Chance, b: Chance| if b.0 > a.0 { b } else { a };
        ballot.axes.iter().copied().reduce(likelier).unwrap().1
    }

    #[test]
    fn what_most_labellings_say_is_followed() {
        let own = door(&[(0.55, UP, 0.0), (0.45, UP, 0.3)]);
        let others =
            [door(&[(0.1, UP, 0.0), (0.9, UP, 0.3)]), door(&[(0.3, UP, 0.001), (0.7, UP, 0.301)])];
        assert_eq!(best(&own).pivot.x, 0.0);
        assert_eq!(best(&united(own, &others.each_ref())).pivot.x, 0.3);
    }

    #[test]
    fn the_direction_is_left_as_it_is() {
        let own = door(&[(0.6, UP, 0.0), (0.4, DVec3::Y, 0.0)]);
        let others = [door(&[(0.1, UP, 0.0), (0.9, DVec3::Y, 0.0)])];
        assert_eq!(best(&united(own, &others.each_ref())).direction, UP);
    }

    #[test]
    fn what_only_others_show_is_a_candidate() {
        let others = [door(&[(0.04, UP, 0.0), (0.96, UP, 0.3)])];
        let own = door(&[(0.4, UP, 0.0), (0.3, UP, 0.1), (0.3, UP, -0.1)]);
        let heard = united(own, &others.each_ref());
        assert_eq!((heard.axes.len(), best(&heard).pivot.x), (4, 0.3));
    }

    #[test]
    fn what_nobody_else_sees_stays_as_it_is() {
        let own = door(&[(0.4, UP, 0.0), (0.3, UP, 0.3), (0.3, UP, 0.31)]);
        assert_eq!(united(own.clone(), &[]).axes, own.axes);
        let heard = united(own, &[&door(&[(1.0, UP, 0.0)])]);
        assert_eq!(best(&heard).pivot.x, 0.0);
    }
}
