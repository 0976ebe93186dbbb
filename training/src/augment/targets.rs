//! What the joint head should answer at each query point (paper, section 4.3).

use std::f64::consts::PI;

use model::net::{JointQuestion, MotionType};
use object::DVec3;
use object::pose::turn_about;

use super::view::View;
use crate::dataset::{Sample, SampleJoint};

/// Axis direction, the point of the axis nearest the query, and where the query stands at the lower
/// and at the upper limit.
pub type Target = [f32; 12];

/// A joint whose direction is settled.
struct Settled {
    turns: bool,
    axis: DVec3,
    pivot: DVec3,
    lower: f64,
    upper: f64,
}

/// The joint questions of a view, and the answers row by row.
pub(super) fn targets(
    sample: &Sample,
    view: &View,
    queries: &[usize],
    labels: &[u16],
) -> (Vec<JointQuestion>, Vec<Target>) {
    let (mut questions, mut targets) = (Vec::new(), Vec::new());
    for (child, part) in view.parts.iter().enumerate() {
        let mine = (0..queries.len()).filter(|&q| usize::from(labels[q]) == child);
        let mine: Vec<u32> = mine.map(|q| q as u32).collect();
        let at = |&q: &u32| DVec3::from_array(view.position(sample, queries[q as usize]));
        let middle = mine.iter().map(at).sum::<DVec3>() / mine.len().max(1) as f64;
        for joint in &part.joints {
            let settled = settle(joint, middle);
            let motion = if joint.turns { MotionType::Revolute } else { MotionType::Prismatic };
            let parent = part.parent.unwrap_or(child);
            let question = JointQuestion { parent, child, motion, queries: mine.clone() };
            if !question.queries.is_empty() {
                targets.extend(mine.iter().map(at).map(|q| settled.target(q)));
                questions.push(question);
            }
        }
    }
    (questions, targets)
}

/// Chooses one of the two ways to write a joint, so that the network need not guess: the larger
/// travel is positive; where both are alike, the axis points up, else towards +x, else towards +y.
/// A slide goes through the middle of what it moves, because nothing shows where else.
fn settle(joint: &SampleJoint, middle: DVec3) -> Settled {
    let axis = DVec3::from_array(joint.axis);
    let difference = joint.upper + joint.lower;
    let alike = difference.abs() < 1e-3 * (joint.upper - joint.lower).max(1e-9);
    let backward = if alike { points_down(axis) } else { difference < 0.0 };
    let (lower, upper) =
        if backward { (-joint.upper, -joint.lower) } else { (joint.lower, joint.upper) };
    let (lower, upper) = if joint.turns { (lower.max(-PI), upper.min(PI)) } else { (lower, upper) };
    Settled {
        turns: joint.turns,
        axis: if backward { -axis } else { axis },
        pivot: if joint.turns { DVec3::from_array(joint.pivot) } else { middle },
        lower,
        upper,
    }
}

fn points_down(axis: DVec3) -> bool {
    let clear = |v: f64| (v.abs() > 0.05).then_some(v < 0.0);
    [axis.z, axis.x, axis.y].into_iter().find_map(clear).unwrap_or(false)
}

impl Settled {
    fn target(&self, q: DVec3) -> Target {
        let closest = self.pivot + self.axis * self.axis.dot(q - self.pivot);
        let [lower, upper] = [self.lower, self.upper].map(|value| {
            if self.turns {
                turn_about(self.axis, self.pivot, value) * q
            } else {
                q + self.axis * value
            }
        });
        let all = [self.axis, closest, lower, upper].map(|v| v.to_array());
        std::array::from_fn(|i| all[i / 3][i % 3] as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hinge(lower: f64, upper: f64, axis: [f64; 3]) -> SampleJoint {
        SampleJoint { turns: true, axis, pivot: [0.5, 0.0, 0.0], lower, upper }
    }

    #[test]
    fn a_joint_and_its_mirror_writing_give_the_same_target() {
        let (up, down) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        let q = DVec3::new(0.1, 0.2, 0.3);
        for (a, b) in [
            (hinge(-0.2, 1.0, up), hinge(-1.0, 0.2, down)),
            (hinge(-PI, PI, up), hinge(-PI, PI, down)),
        ] {
            let [a, b] = [a, b].map(|j| settle(&j, q).target(q));
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
            assert_eq!(a[..3], [0.0, 0.0, 1.0]);
        }
    }

    #[test]
    fn targets_are_the_closed_form() {
        let q = DVec3::new(0.1, 0.0, 0.3);
        let turn = settle(&hinge(0.0, PI / 2.0, [0.0, 0.0, 1.0]), q).target(q);
        let wanted = [0.0, 0.0, 1.0, 0.5, 0.0, 0.3, 0.1, 0.0, 0.3, 0.5, -0.4, 0.3];
        assert!(turn.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{turn:?}");
        let joint = SampleJoint {
            turns: false,
            axis: [0.0, 1.0, 0.0],
            pivot: [9.0; 3],
            lower: -0.3,
            upper: 0.1,
        };
        let slide = settle(&joint, DVec3::ZERO).target(q);
        let wanted = [0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.1, 0.3, 0.1, -0.3, 0.3];
        assert!(slide.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{slide:?}");
    }
}
