//! Predicted joints against the true ones of matched parts: angle, distance, range.

use object::{DVec3, JointKind};
use serde::Serialize;

use super::body::{Body, Motion};
use super::mean;
use super::opening::{Opening, OpeningShares};

/// An axis this near the true one counts as found, degrees.
pub const NEAR_ANGLE: f64 = 15.0;
/// And this near as a line, for a turn; unit cube.
pub const NEAR_LINE: f64 = 0.05;

/// One true joint and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointComparison {
    /// The true part it moves.
    pub part: u16,
    /// Its kind.
    pub kind: JointKind,
    /// Angle between the axes whichever way they point, degrees, 0 to 90; none if the part went
    /// unmatched or has no joint that turns (or slides) as this one.
    pub angle: Option<f64>,
    /// Distance of the axes as endless lines, unit cube; turns only.
    pub line: Option<f64>,
    /// Overlap of the ranges over their union, the prediction turned to the true axis's side; none
    /// where either has no ends, or no length.
    pub range: Option<f64>,
    /// The ends of the prediction, turned to the true axis's side: radians, or lengths of the unit
    /// cube.
    pub ends: Option<[f64; 2]>,
    /// The true ends.
    pub true_ends: [f64; 2],
    /// Which way it opens; none of a joint that goes both ways, or that has no counterpart.
    pub opening: Option<Opening>,
}

impl JointComparison {
    /// A true joint nobody predicted.
    pub fn missing(part: u16, wanted: &Motion) -> Self {
        compare(part, wanted, None)
    }

    /// Whether the axis points the right way.
    pub fn is_near(&self) -> bool {
        self.angle.is_some_and(|a| a <= NEAR_ANGLE)
    }

    /// Whether the axis points the right way and, for a turn, lies in the right place.
    pub fn is_found(&self) -> bool {
        self.is_near() && self.line.is_none_or(|l| l <= NEAR_LINE)
    }

    /// Whether the axis is found and, if the joint goes one way alone, opens that way.
    pub fn is_right(&self) -> bool {
        self.is_found() && self.opening.is_none_or(|o| o == Opening::Right)
    }

    /// Which way a joint opens whose axis is found.
    pub fn opening_if_found(&self) -> Option<Opening> {
        self.opening.filter(|_| self.is_found())
    }
}

/// Every joint of the true parts listed in `parts`, against the predicted part each is matched
/// with, if any.
pub fn compare_joints(
    predicted: &Body,
    truth: &Body,
    parts: impl IntoIterator<Item = (u16, Option<u16>)>,
) -> Vec<JointComparison> {
    let motions = |body: &Body, part: u16| {
        body.links().get(usize::from(part)).map_or_else(Vec::new, |link| link.motions.clone())
    };
    let mut all = Vec::new();
    for (part, found) in parts {
        let candidates = found.map_or_else(Vec::new, |p| motions(predicted, p));
        let wanted = motions(truth, part);
        for (place, motion) in wanted.iter().enumerate() {
            let found = counterpart(&wanted, place, &candidates).map(|i| &candidates[i]);
            all.push(compare(part, motion, found));
        }
    }
    all
}

/// Which of `others` goes with one of a part's motions: the first that turns with the first, and so on.
pub(super) fn counterpart(motions: &[Motion], place: usize, others: &[Motion]) -> Option<usize> {
    let turns = motions[place].kind.turns();
    let before = motions[..place].iter().filter(|m| m.kind.turns() == turns).count();
    let alike = others.iter().enumerate().filter(|(_, m)| m.kind.turns() == turns);
    alike.map(|(i, _)| i).nth(before)
}

fn compare(part: u16, wanted: &Motion, found: Option<&Motion>) -> JointComparison {
    let line = found.filter(|_| wanted.kind.turns()).map(|m| distance(m, wanted));
    JointComparison {
        part,
        kind: wanted.kind,
        angle: found.map(|m| m.axis.dot(wanted.axis).abs().min(1.0).acos().to_degrees()),
        line,
        range: found.and_then(|m| overlap(m, wanted)),
        ends: found.map(|m| ends(m, wanted)),
        true_ends: [wanted.lower, wanted.upper],
        opening: found.and_then(|m| Opening::of(wanted, m, ends(m, wanted))),
    }
}

/// Distance of two endless lines; of parallel ones, that of the second's pivot from the first.
fn distance(a: &Motion, b: &Motion) -> f64 {
    let (across, apart): (DVec3, DVec3) = (a.axis.cross(b.axis), a.pivot - b.pivot);
    if across.length() < 1e-6 {
        return apart.reject_from(b.axis).length();
    }
    apart.dot(across.normalize()).abs()
}

/// The ends of a prediction, turned to the true axis's side.
pub(super) fn ends(found: &Motion, wanted: &Motion) -> [f64; 2] {
    let is_reversed = found.axis.dot(wanted.axis) < 0.0;
    if is_reversed { [-found.upper, -found.lower] } else { [found.lower, found.upper] }
}

fn overlap(found: &Motion, wanted: &Motion) -> Option<f64> {
    if [found, wanted].iter().any(|m| m.kind == JointKind::Continuous) {
        return None;
    }
    let [lower, upper] = ends(found, wanted);
    let union = upper.max(wanted.upper) - lower.min(wanted.lower);
    let both = (upper.min(wanted.upper) - lower.max(wanted.lower)).max(0.0);
    (union > 0.0).then(|| both / union)
}

/// The joints of one object, or of many, summed up.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct JointScores {
    /// True joints.
    pub joints: usize,
    /// Those with a counterpart of their type.
    pub compared: usize,
    /// Mean angle of those compared, degrees: the paper's AE.
    pub angle: Option<f64>,
    /// Mean distance of lines of those compared that turn, unit cube: the paper's LE.
    pub line: Option<f64>,
    /// Share of all true joints within 15°.
    pub near: Option<f64>,
    /// Share of all true joints within 15° and, for turns, 0.05.
    pub found: Option<f64>,
    /// Mean overlap of ranges of those found that have one.
    pub range: Option<f64>,
    /// Which way those found open that truly go one way.
    pub opening: OpeningShares,
}

impl JointScores {
    /// Sums up some joints, each counted once.
    pub fn of<'a>(joints: impl IntoIterator<Item = &'a JointComparison>) -> Self {
        let all: Vec<_> = joints.into_iter().collect();
        let share = |rule: fn(&JointComparison) -> bool| {
            mean(all.iter().map(|j| f64::from(u8::from(rule(j)))))
        };
        Self {
            joints: all.len(),
            compared: all.iter().filter(|j| j.angle.is_some()).count(),
            angle: mean(all.iter().filter_map(|j| j.angle)),
            line: mean(all.iter().filter_map(|j| j.line)),
            near: share(JointComparison::is_near),
            found: share(JointComparison::is_found),
            range: mean(all.iter().filter(|j| j.is_found()).filter_map(|j| j.range)),
            opening: OpeningShares::of(
                all.iter().filter_map(|j| Some((1.0, j.opening_if_found()?))),
            ),
        }
    }
}
