//! All measures of one object in one row.

use std::collections::BTreeMap;

use serde::Serialize;

use super::compare::{Closeness, Comparison};
use super::joints::{JointComparison, JointScores};
use super::{Rules, mean};

/// A part is right from this point IoU on; a guess.
pub const RIGHT_IOU: f64 = 0.75;

/// The measures of one object under one matching of its parts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scores {
    /// Share of predicted parts whose match has a rest gIoU of at least 0.
    pub precision: f64,
    /// Share of true parts whose match has a rest gIoU of at least 0.
    pub recall: f64,
    /// gIoU of parts at rest.
    pub giou: f64,
    /// PC: Chamfer distance of parts at rest.
    pub chamfer: f64,
    /// The paper's mIoU: IoU of the parts' boxes at rest.
    pub box_iou: f64,
    /// IoU of the parts' points, mean over the parts of both sides; none where the two surfaces are
    /// not the same.
    pub point_iou: Option<f64>,
    /// gIoU of parts, joints at their upper ends.
    pub moved_giou: f64,
    /// gIoU of boxes around the points of parts, every joint opened the true way: not of the paper.
    /// See [`super::moved_points_giou`].
    pub moved_points: f64,
    /// Whether nothing is wrong: the point IoU of every true part is at least [`RIGHT_IOU`], every
    /// joint is found, and what goes one way opens that way. None where the two surfaces are not the
    /// same.
    pub fully_right: Option<bool>,
    /// PC, joints at their upper ends.
    pub moved_chamfer: f64,
    /// OC: Chamfer distance of the whole objects, joints at their upper ends.
    pub moved_overall: f64,
    /// The joints.
    pub joints: JointScores,
}

impl Scores {
    /// Sums up a comparison; `points` are [`point_ious`], where both surfaces are the same.
    pub fn of(
        comparison: &Comparison,
        points: Option<&PointIous>,
        moved_points: f64,
        joints: &[JointComparison],
    ) -> Self {
        let c = comparison;
        let valid = c.matched.iter().filter(|m| m.rest.giou[0] >= 0.0).count() as f64;
        let share = |parts: usize| if parts == 0 { 0.0 } else { valid / parts as f64 };
        let punished = Some(c.half_diagonal);
        let giou = c.both_ways(Some(-1.0), |m, way| m.rest.giou[way]);
        Self {
            precision: share(c.predicted),
            recall: share(c.truth),
            giou: if giou.is_nan() { -1.0 } else { giou },
            chamfer: c.both_ways(punished, |m, _| m.rest.chamfer),
            box_iou: c.both_ways(Some(0.0), |m, _| m.rest.iou),
            point_iou: points.and_then(|p| p.mean),
            moved_giou: moved_giou(c),
            moved_points,
            fully_right: points.map(|p| {
                p.of_true.values().all(|&iou| iou >= RIGHT_IOU)
                    && joints.iter().all(JointComparison::is_right)
            }),
            moved_chamfer: over_poses(c, |i| c.both_ways(punished, |m, _| at(&m.moved, i).chamfer)),
            moved_overall: c.overall_moved.last().copied().unwrap_or(f64::NAN),
            joints: JointScores::of(joints),
        }
    }

    /// What is left of an object nobody predicted: every part unmatched, every joint missing.
    pub fn nothing(half_diagonal: f64, surface_is_same: bool, joints: &[JointComparison]) -> Self {
        Self {
            precision: 0.0,
            recall: 0.0,
            giou: -1.0,
            chamfer: half_diagonal,
            box_iou: 0.0,
            point_iou: surface_is_same.then_some(0.0),
            moved_giou: -1.0,
            moved_points: -1.0,
            fully_right: surface_is_same.then_some(false),
            moved_chamfer: half_diagonal,
            moved_overall: half_diagonal,
            joints: JointScores::of(joints),
        }
    }
}

fn at(moved: &[Closeness], pose: usize) -> Closeness {
    let nowhere = Closeness { giou: [f64::NAN; 2], iou: f64::NAN, chamfer: f64::NAN };
    moved.get(pose).copied().unwrap_or(nowhere)
}

/// The last pose, or what the public code writes down: the mean over all of them.
fn over_poses(c: &Comparison, value: impl Fn(usize) -> f64) -> f64 {
    let poses = 0..c.rules.shares().len();
    match c.rules {
        Rules::Paper => poses.last().map_or(f64::NAN, value),
        Rules::RefCompat => mean(poses.map(value)).unwrap_or(f64::NAN),
    }
}

/// As [`over_poses`]; the public code's list holds every pose but the first twice.
fn moved_giou(c: &Comparison) -> f64 {
    let value = |i: usize| c.both_ways(Some(-1.0), |m, way| at(&m.moved, i).giou[way]);
    match c.rules {
        Rules::Paper => over_poses(c, value),
        Rules::RefCompat => {
            let last = c.rules.shares().len();
            mean((0..last).chain(1..last).map(value)).unwrap_or(f64::NAN)
        }
    }
}

/// How far the points of parts agree.
#[derive(Clone, Debug, PartialEq)]
pub struct PointIous {
    /// Mean over the parts of both sides; none where there are no points.
    pub mean: Option<f64>,
    /// Of every true part with points, by number; 0 without a counterpart.
    pub of_true: BTreeMap<u16, f64>,
}

/// The IoU of parts' points: `predicted` and `truth` hold, for each point of the one surface, its part
/// on either side; `pairs` who goes with whom.
pub fn point_ious(predicted: &[u16], truth: &[u16], pairs: &[(u16, u16)]) -> PointIous {
    let count = |of: &mut dyn Iterator<Item = (u16, u16)>| {
        let mut counts = BTreeMap::<(u16, u16), f64>::new();
        of.for_each(|key| *counts.entry(key).or_default() += 1.0);
        counts
    };
    let both = count(&mut predicted.iter().copied().zip(truth.iter().copied()));
    let found = count(&mut predicted.iter().map(|&p| (p, 0)));
    let wanted = count(&mut truth.iter().map(|&t| (t, 0)));
    let size = |of: &BTreeMap<(u16, u16), f64>, key| of.get(&key).copied().unwrap_or(0.0);
    let iou = |&(p, t): &(u16, u16)| {
        let shared = size(&both, (p, t));
        shared / (size(&found, (p, 0)) + size(&wanted, (t, 0)) - shared)
    };
    let unmatched = (found.len() + wanted.len()).saturating_sub(2 * pairs.len());
    let mut of_true: BTreeMap<u16, f64> = wanted.keys().map(|&(t, _)| (t, 0.0)).collect();
    of_true.extend(pairs.iter().map(|pair| (pair.1, iou(pair))));
    PointIous {
        mean: mean(pairs.iter().map(iou).chain(std::iter::repeat_n(0.0, unmatched))),
        of_true,
    }
}
