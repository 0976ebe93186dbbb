//! Where a body can get to while its joint runs through an interval, exactly: no poses are
//! sampled.

use std::f64::consts::PI;

use glamx::{DPose3, DVec3};
use object::JointMotion;
use object::pose::joint_pose;

use crate::collision::solid::support;

/// A body's motion while one joint runs through an interval; q = 0 is rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// It stays where it is.
    Still,
    /// It stays where this pose puts it.
    Placed(DPose3),
    /// It moves with a joint from the first value to the second, radians or metres.
    Along(JointMotion, f64, f64),
}

impl Motion {
    /// The interval's ends; 0 and 0 for a body that stays.
    pub(crate) fn ends(&self) -> (f64, f64) {
        match *self {
            Self::Still | Self::Placed(_) => (0.0, 0.0),
            Self::Along(_, low, high) => (low, high),
        }
    }

    /// The motion of everything else as this body sees it.
    pub(crate) fn reversed(&self) -> Self {
        match *self {
            Self::Still => Self::Still,
            Self::Placed(pose) => Self::Placed(pose.inverse()),
            Self::Along(joint, low, high) => Self::Along(joint, -high, -low),
        }
    }

    /// The same joint over another interval.
    pub(crate) fn over(&self, low: f64, high: f64) -> Self {
        match *self {
            Self::Still | Self::Placed(_) => *self,
            Self::Along(joint, ..) => Self::Along(joint, low, high),
        }
    }

    /// The lower and the upper half.
    pub(crate) fn halves(&self) -> [Self; 2] {
        let (low, high) = self.ends();
        let middle = (low + high) / 2.0;
        [self.over(low, middle), self.over(middle, high)]
    }

    /// Pose at the interval's middle.
    pub(crate) fn middle(&self) -> DPose3 {
        let (low, high) = self.ends();
        self.at((low + high) / 2.0)
    }

    /// Pose at a joint value.
    pub(crate) fn at(&self, q: f64) -> DPose3 {
        match self {
            Self::Still => DPose3::identity(),
            Self::Placed(pose) => *pose,
            Self::Along(joint, ..) => joint_pose(joint, q),
        }
    }

    /// Largest n · x over all points and the whole interval, exact.
    pub(crate) fn support(&self, points: &[DVec3], n: DVec3) -> f64 {
        let (joint, low, high) = match *self {
            Self::Still => return support(points, n),
            Self::Placed(pose) => {
                let own = pose.inverse_transform_vector(n);
                return support(points, own) + n.dot(pose.translation);
            }
            Self::Along(joint, low, high) => (joint, low, high),
        };
        if !joint.kind.turns() {
            let slide = n.dot(joint.axis);
            return support(points, n) + (slide * low).max(slide * high);
        }
        let (middle, half) = ((low + high) / 2.0, ((high - low) / 2.0).min(PI));
        let ((sm, cm), (sh, ch)) = (middle.sin_cos(), half.sin_cos());
        let across = joint.axis.cross(n);
        let flat = n - joint.axis * joint.axis.dot(n);
        let height = |p: &DVec3| {
            let r = *p - joint.pivot;
            // n · R(q) r = along + a cos q + b sin q, turned to the interval's middle.
            let (a, b) = (flat.dot(r), -across.dot(r));
            let (a, b) = (a * cm + b * sm, b * cm - a * sm);
            let peak = (a * a + b * b).sqrt();
            let along = joint.axis.dot(n) * joint.axis.dot(r);
            along + if a >= peak * ch { peak } else { a * ch + b.abs() * sh }
        };
        points.iter().map(height).fold(f64::NEG_INFINITY, f64::max) + n.dot(joint.pivot)
    }

    /// How far the farthest point travels over the interval, metres.
    pub(crate) fn travel(&self, points: &[DVec3]) -> f64 {
        let Self::Along(joint, low, high) = *self else { return 0.0 };
        if !joint.kind.turns() {
            return high - low;
        }
        let arm =
            |p: &DVec3| (*p - joint.pivot).reject_from_normalized(joint.axis).length_squared();
        points.iter().map(arm).fold(0.0, f64::max).sqrt() * (high - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use object::{JointKind, Range};

    fn joint(kind: JointKind) -> JointMotion {
        let axis = DVec3::new(0.48, -0.6, 0.64);
        let pivot = DVec3::new(0.3, -0.2, 0.9);
        JointMotion { kind, axis, pivot, range: Range::Limits { lower: -1.0, upper: 1.0 } }
    }

    /// The support found by trying 4,001 poses.
    fn tried(motion: &Motion, points: &[DVec3], n: DVec3) -> f64 {
        let (low, high) = motion.ends();
        let pose = |i: i32| motion.at(low + (high - low) * f64::from(i) / 4000.0);
        let height = |i: i32| points.iter().map(|&p| n.dot(pose(i) * p)).fold(-9e9, f64::max);
        (0..=4000).map(height).fold(-9e9, f64::max)
    }

    #[test]
    fn the_support_of_a_sweep_is_that_of_all_its_poses() {
        let points = [DVec3::new(1.0, 0.2, 0.1), DVec3::new(-0.4, 0.8, 0.5), DVec3::splat(0.3)];
        let n = DVec3::new(0.36, 0.48, -0.8);
        for (low, high) in
            [(0.0, 0.0), (-0.3, 0.2), (0.1, 2.9), (-2.5, 2.0), (-PI, PI), (-7.0, 7.0)]
        {
            for kind in [JointKind::Revolute, JointKind::Prismatic] {
                let motion = Motion::Along(joint(kind), low, high);
                let (exact, found) = (motion.support(&points, n), tried(&motion, &points, n));
                assert!((exact - found).abs() < 1e-5, "{low}..{high}: {exact} {found}");
            }
        }
    }

    #[test]
    fn seen_from_the_body_the_world_moves_the_other_way() {
        let motion = Motion::Along(joint(JointKind::Revolute), 0.2, 0.9);
        assert_eq!(motion.reversed().ends(), (-0.9, -0.2));
        let p = DVec3::new(0.5, 0.1, 0.2);
        let there_and_back = motion.reversed().at(-0.4) * (motion.at(0.4) * p);
        assert!((there_and_back - p).length() < 1e-14);
    }

    #[test]
    fn travel_is_arm_times_angle_or_the_slide() {
        let turn = Motion::Along(joint(JointKind::Revolute), -0.5, 1.0);
        let arm = DVec3::new(0.8, 0.64, 0.0).normalize() * 0.7;
        assert!((turn.travel(&[joint(JointKind::Revolute).pivot + arm]) - 1.05).abs() < 1e-12);
        assert_eq!(Motion::Along(joint(JointKind::Prismatic), -0.5, 1.0).travel(&[arm]), 1.5);
    }
}
