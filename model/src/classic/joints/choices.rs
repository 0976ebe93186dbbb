//! The axes a joint was chosen among, for a person to choose from.

use object::{DVec3, JointMotion};

use crate::classic::joints::context::JointContext;
use crate::classic::joints::hypotheses::are_one;
use crate::classic::joints::siblings::Ballot;
use crate::classic::joints::sweep::Axis;

/// Most axes that are told of one joint.
pub const MOST: usize = 12;

/// Axes are right within this angle, degrees, and this distance of their lines, a share of the object's longest
/// side: those of evaluation.
const RIGHT_ANGLE: f64 = 15.0;
const RIGHT_LINE: f64 = 0.05;

/// The likeliest axes of one joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Choices {
    /// The part that moves, by its place in the tree.
    pub part: usize,
    /// Which of its joints.
    pub joint: usize,
    /// At most [`MOST`] axes, no two of them one, the likeliest first.
    pub axes: Vec<LikelyAxis>,
}

/// An axis that a joint may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LikelyAxis {
    /// Unit direction, mesh frame; either way round.
    pub direction: DVec3,
    /// A point on it, mesh frame and unit.
    pub pivot: DVec3,
    /// How likely it is among all candidates, 0 to 1; axes that are one for all that matters count together.
    pub probability: f64,
}

impl LikelyAxis {
    /// Whether it is the axis of this joint, to 15° and, for a turn, 5 % of `size`, the object's longest side.
    pub(crate) fn is_one_with(&self, found: &JointMotion, size: f64) -> bool {
        let across = self.direction.cross(found.axis);
        let apart = self.pivot - found.pivot;
        let line = if across.length() < 1e-6 {
            apart.reject_from(found.axis).length()
        } else {
            apart.dot(across.normalize()).abs()
        };
        let is_along = self.direction.dot(found.axis).abs() > RIGHT_ANGLE.to_radians().cos();
        is_along && (!found.kind.turns() || line < RIGHT_LINE * size)
    }
}

/// What a ballot says of the joint of a part, in the mesh's frame and unit.
pub(crate) fn choices(context: &JointContext, ballot: &Ballot) -> Choices {
    let scene = context.scene;
    let axis = |(probability, axis): (f64, Axis)| LikelyAxis {
        direction: axis.direction.normalize(),
        pivot: context.pivot(&axis) * scene.unit + scene.origin,
        probability,
    };
    let axes = distinct(ballot).into_iter().map(axis).collect();
    Choices { part: ballot.part, joint: ballot.joint, axes }
}

/// The likeliest axes, each with the chances of those that are one with it.
pub(super) fn distinct(ballot: &Ballot) -> Vec<(f64, Axis)> {
    let best = ballot.axes.iter().map(|a| a.0).fold(f64::NEG_INFINITY, f64::max);
    let all: f64 = ballot.axes.iter().map(|a| (a.0 - best).exp()).sum();
    let mut ranked: Vec<(f64, Axis)> =
        ballot.axes.iter().map(|&(score, axis)| ((score - best).exp() / all, axis)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut told: Vec<(f64, Axis)> = Vec::new();
    for (chance, axis) in ranked {
        match told.iter_mut().find(|(_, known)| are_one(known, &axis)) {
            Some((sum, _)) => *sum += chance,
            None => told.push((chance, axis)),
        }
    }
    told.sort_by(|a, b| b.0.total_cmp(&a.0));
    told.truncate(MOST);
    told
}

#[cfg(test)]
mod tests {
    use object::JointKind;

    use super::*;
    use crate::classic::lexicon::words::Role;

    #[test]
    fn axes_that_are_one_count_together_and_the_likeliest_comes_first() {
        let axis = |direction, x: f64| Axis { direction, pivot: DVec3::X * x, turns: true };
        let said = [(0.4, DVec3::Z, 0.0), (0.3, DVec3::Z, 0.3), (0.2, -DVec3::Z, 0.301)];
        let some = (0..20).map(|i| (0.005, DVec3::Y, 0.1 * f64::from(i)));
        let axes = said.into_iter().chain(some).map(|(p, d, x)| (f64::ln(p), axis(d, x)));
        let (kind, role) = (JointKind::Revolute, Role::Door);
        let axes = axes.collect();
        let ballot = Ballot { part: 1, joint: 0, kind, role, stem: String::new(), axes };
        let told = distinct(&ballot);
        assert_eq!(told.len(), MOST);
        assert_eq!((told[0].1.pivot.x, told[1].1.pivot.x), (0.3, 0.0));
        assert!((told[0].0 - 0.5).abs() < 1e-12 && (told[1].0 - 0.4).abs() < 1e-12);
    }
}
