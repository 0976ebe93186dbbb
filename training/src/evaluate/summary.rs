//! Many rows in one: means over the objects of a set, and over all.

use serde::Serialize;

use super::case::object_of;
use super::{Row, Set};
use crate::metrics::calibration::{self, Calibration};
use crate::metrics::scores::RIGHT_IOU;
use crate::metrics::{JointComparison, OpeningShares, Scores};

/// Means over objects; what no object has is none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Rows.
    pub cases: usize,
    /// Rows without a prediction, counted at their worst.
    pub failed: usize,
    /// Objects: a case and its fused twin are one, each counting half.
    pub objects: f64,
    /// Parts of the same number together; none where numbers say nothing.
    pub identity: Option<Means>,
    /// Parts together by centroid.
    pub hungarian: Means,
    /// Joints one by one, parts together as [`Row::joints`] has them.
    pub by_joint: JointMeans,
    /// Whether what the articulator says of how sure it is agrees with the truth; none where it says nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub confidence: Option<Sureness>,
}

/// How sure an articulator said it was, against what was so; every part, joint and object counts alike.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sureness {
    /// Of parts: a point IoU of at least [`RIGHT_IOU`].
    pub parts: Calibration,
    /// Of joints: axis, line and way right.
    pub joints: Calibration,
    /// Of objects: [`Scores::fully_right`].
    pub objects: Calibration,
    /// Share of all objects that are said to be right with at least [`ACCEPTED`].
    pub accepted: f64,
    /// Share of those that are.
    pub accepted_right: Option<f64>,
}

/// What is at least so likely right is accepted.
pub const ACCEPTED: f64 = 0.9;

impl Sureness {
    fn of(rows: &[(f64, &Row)]) -> Option<Self> {
        let rows = rows.iter().map(|(_, row)| *row);
        let points = rows.clone().flat_map(|row| &row.points);
        let parts = points.filter_map(|p| Some((p.confidence?, p.iou >= RIGHT_IOU)));
        let joints = rows.clone().flat_map(|row| &row.joints);
        let joints = joints.filter_map(|j| Some((j.confidence?, j.joint.is_right())));
        let objects = rows.filter_map(|r| Some((r.confidence?, r.scores().fully_right?)));
        let objects: Vec<_> = objects.collect();
        let (accepted, right) = calibration::accepted(&objects, ACCEPTED);
        (!objects.is_empty()).then(|| Self {
            parts: Calibration::of(&parts.collect::<Vec<_>>()),
            joints: Calibration::of(&joints.collect::<Vec<_>>()),
            accepted: accepted as f64 / objects.len() as f64,
            accepted_right: right,
            objects: Calibration::of(&objects),
        })
    }
}

/// Means over objects of [`Scores`], joints per object first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Means {
    /// [`Scores::precision`].
    pub precision: Option<f64>,
    /// [`Scores::recall`].
    pub recall: Option<f64>,
    /// [`Scores::giou`].
    pub giou: Option<f64>,
    /// [`Scores::chamfer`].
    pub chamfer: Option<f64>,
    /// [`Scores::box_iou`].
    pub box_iou: Option<f64>,
    /// [`Scores::point_iou`].
    pub point_iou: Option<f64>,
    /// [`Scores::moved_giou`].
    pub moved_giou: Option<f64>,
    /// [`Scores::moved_points`].
    pub moved_points: Option<f64>,
    /// Share of objects that are [`Scores::fully_right`].
    pub fully_right: Option<f64>,
    /// [`Scores::moved_chamfer`].
    pub moved_chamfer: Option<f64>,
    /// [`Scores::moved_overall`].
    pub moved_overall: Option<f64>,
    /// Angles, lines and shares of objects that have joints.
    pub joints: JointMeans,
}

/// What became of joints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointMeans {
    /// True joints.
    pub joints: usize,
    /// Those with a counterpart of their type.
    pub compared: usize,
    /// AE, degrees, of those compared.
    pub angle: Option<f64>,
    /// LE, unit cube, of those compared that turn.
    pub line: Option<f64>,
    /// Share within 15°.
    pub near: Option<f64>,
    /// Share within 15° and, for turns, 0.05: the headline.
    pub found: Option<f64>,
    /// Which way those found open that truly go one way, over all joints as [`Row::joints`] has them, however
    /// parts are paired otherwise.
    pub opening: OpeningShares,
}

impl Summary {
    /// Sums up the rows of one set; none if there are none.
    pub fn of_set(rows: &[Row], set: Set) -> Option<Self> {
        Self::of(rows.iter().filter(|r| r.set == set).map(|r| (1.0, r)).collect())
    }

    /// Sums up all rows; a case and its fused twin share one vote.
    pub fn of_all(rows: &[Row]) -> Option<Self> {
        let twins =
            |row: &Row| rows.iter().filter(|r| object_of(&r.case) == object_of(&row.case)).count();
        Self::of(rows.iter().map(|r| (1.0 / twins(r) as f64, r)).collect())
    }

    fn of(rows: Vec<(f64, &Row)>) -> Option<Self> {
        Some(Self {
            cases: rows.len(),
            failed: rows.iter().filter(|(_, r)| r.error.is_some()).count(),
            objects: rows.iter().map(|(weight, _)| weight).sum(),
            identity: Means::of(&rows, |r| r.identity.as_ref()),
            hungarian: Means::of(&rows, |r| Some(&r.hungarian))?,
            by_joint: JointMeans::by_joint(&rows),
            confidence: Sureness::of(&rows),
        })
    }
}

/// Mean of what there is, each by its weight.
fn mean(values: impl Iterator<Item = (f64, Option<f64>)>) -> Option<f64> {
    let known = values.filter_map(|(weight, value)| Some((weight, value?)));
    let (weight, sum) = known.fold((0.0, 0.0), |(w, s), (weight, v)| (w + weight, s + weight * v));
    (weight > 0.0).then(|| sum / weight)
}

/// Which way joints open, parts together as [`Row::joints`] has them.
fn opening(rows: &[(f64, &Row)]) -> OpeningShares {
    let of = |&(weight, row): &(f64, &Row)| {
        let known: Vec<_> = row.joints.iter().filter_map(|j| j.joint.opening_if_found()).collect();
        known.into_iter().map(move |opening| (weight, opening))
    };
    OpeningShares::of(rows.iter().flat_map(of))
}

impl Means {
    /// None where no row has such scores.
    fn of(rows: &[(f64, &Row)], scores: fn(&Row) -> Option<&Scores>) -> Option<Self> {
        let known: Vec<(f64, &Scores)> =
            rows.iter().filter_map(|&(weight, row)| Some((weight, scores(row)?))).collect();
        let over = |value: fn(&Scores) -> Option<f64>| {
            mean(known.iter().map(|&(weight, scores)| (weight, value(scores))))
        };
        let total = |count: fn(&Scores) -> usize| known.iter().map(|(_, s)| count(s)).sum();
        (!known.is_empty()).then(|| Self {
            precision: over(|s| Some(s.precision)),
            recall: over(|s| Some(s.recall)),
            giou: over(|s| Some(s.giou)),
            chamfer: over(|s| Some(s.chamfer)),
            box_iou: over(|s| Some(s.box_iou)),
            point_iou: over(|s| s.point_iou),
            moved_giou: over(|s| Some(s.moved_giou)),
            moved_points: over(|s| Some(s.moved_points)),
            fully_right: over(|s| s.fully_right.map(|right| f64::from(u8::from(right)))),
            moved_chamfer: over(|s| Some(s.moved_chamfer)),
            moved_overall: over(|s| Some(s.moved_overall)),
            joints: JointMeans {
                joints: total(|s| s.joints.joints),
                compared: total(|s| s.joints.compared),
                angle: over(|s| s.joints.angle),
                line: over(|s| s.joints.line),
                near: over(|s| s.joints.near),
                found: over(|s| s.joints.found),
                opening: opening(rows),
            },
        })
    }
}

impl JointMeans {
    fn by_joint(rows: &[(f64, &Row)]) -> Self {
        let joints = || rows.iter().flat_map(|(w, row)| row.joints.iter().map(|j| (*w, &j.joint)));
        let over = |value: fn(&JointComparison) -> Option<f64>| {
            mean(joints().map(|(weight, joint)| (weight, value(joint))))
        };
        let yes = |holds: bool| Some(f64::from(u8::from(holds)));
        Self {
            joints: joints().count(),
            compared: joints().filter(|(_, j)| j.angle.is_some()).count(),
            angle: over(|j| j.angle),
            line: over(|j| j.line),
            near: mean(joints().map(|(weight, j)| (weight, yes(j.is_near())))),
            found: mean(joints().map(|(weight, j)| (weight, yes(j.is_found())))),
            opening: opening(rows),
        }
    }
}
