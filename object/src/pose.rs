//! Forward kinematics F(q, a, θ, τ): where every part stands for given joint values.

use glamx::{DPose3, DQuat, DVec3};

use crate::articulated::{ArticulatedObject, JointMotion};
use crate::kinematics::KinematicTree;

/// Joint values of an object: for each part, one value per motion (radians or metres from rest).
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration(pub Vec<Vec<f64>>);

impl Configuration {
    /// Every joint at rest.
    pub fn rest(tree: &KinematicTree) -> Self {
        Self(tree.parts().iter().map(|p| vec![0.0; p.joints.len()]).collect())
    }

    /// One joint moved, the others as they were.
    #[must_use]
    pub fn with(mut self, part: usize, joint: usize, value: f64) -> Self {
        self.0[part][joint] = value;
        self
    }
}

/// The rigid motion of one joint alone: q radians about its axis line, or q metres along it.
pub fn joint_pose(motion: &JointMotion, q: f64) -> DPose3 {
    if motion.kind.turns() {
        turn_about(motion.axis, motion.pivot, q)
    } else {
        DPose3::from_translation(motion.axis * q)
    }
}

/// The rigid motion that turns space by `angle` radians about the line through `pivot` along the
/// unit vector `axis`.
pub fn turn_about(axis: DVec3, pivot: DVec3, angle: f64) -> DPose3 {
    let rotation = DQuat::from_axis_angle(axis, angle);
    DPose3::from_parts(pivot - rotation * pivot, rotation)
}

/// For each part, the motion from its rest place to its place at `q`, object frame.
///
/// A child carries its axis along: its motion is its parent's times its own joints' at rest, the
/// joint nearest the parent first.
pub fn part_poses(object: &ArticulatedObject, q: &Configuration) -> Vec<DPose3> {
    let tree = object.tree();
    let mut poses = vec![DPose3::identity(); tree.len()];
    for &part in tree.root_first() {
        let parent = tree.parent(part).map_or(DPose3::identity(), |p| poses[p]);
        let own = object.joints(part).iter().zip(&q.0[part]);
        poses[part] = own.fold(parent, |pose, (motion, &q)| pose * joint_pose(motion, q));
    }
    poses
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::articulated::Range;
    use crate::kinematics::{JointKind, Part};
    use crate::mesh::Mesh;

    fn motion(kind: JointKind, axis: DVec3, pivot: DVec3) -> JointMotion {
        let range = match kind {
            JointKind::Continuous => Range::Continuous,
            _ => Range::Limits { lower: -2.0, upper: 2.0 },
        };
        JointMotion { kind, axis, pivot, range }
    }

    fn chain(motions: Vec<Vec<JointMotion>>) -> ArticulatedObject {
        let part = |(i, m): (usize, &Vec<JointMotion>)| Part {
            name: format!("p{i}"),
            text: String::new(),
            parent: i.checked_sub(1),
            joints: m.iter().map(|m| m.kind).collect(),
        };
        let parts: Vec<_> = motions.iter().enumerate().map(part).collect();
        let faces = vec![[0, 1, 2]; parts.len()];
        let labels = (0..parts.len() as u16).collect();
        let mesh = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], faces).unwrap();
        ArticulatedObject::new(mesh, KinematicTree::new(parts).unwrap(), labels, motions).unwrap()
    }

    #[test]
    fn a_point_on_the_axis_does_not_move() {
        let m = motion(JointKind::Revolute, DVec3::new(0.6, 0.0, 0.8), DVec3::new(1.0, 2.0, 3.0));
        let on_axis = m.pivot + m.axis * 7.0;
        assert!((joint_pose(&m, 1.3) * on_axis - on_axis).length() < 1e-14);
    }

    #[test]
    fn a_chain_of_two_hinges_carries_the_second_axis_along() {
        let hinge = |x| motion(JointKind::Revolute, DVec3::Z, DVec3::new(x, 0.0, 0.0));
        let arm = chain(vec![vec![], vec![hinge(0.0)], vec![hinge(1.0)]]);
        let q = Configuration(vec![vec![], vec![FRAC_PI_2], vec![FRAC_PI_2]]);
        let tip = part_poses(&arm, &q)[2] * DVec3::new(2.0, 0.0, 0.0);
        assert!((tip - DVec3::new(-1.0, 1.0, 0.0)).length() < 1e-14);
    }

    #[test]
    fn a_slide_listed_first_is_not_turned_by_the_hinge_behind_it() {
        let slide = motion(JointKind::Prismatic, DVec3::X, DVec3::ZERO);
        let spin = motion(JointKind::Continuous, DVec3::Z, DVec3::ZERO);
        let cap = chain(vec![vec![], vec![slide, spin]]);
        let q = Configuration(vec![vec![], vec![0.5, FRAC_PI_2]]);
        let p = part_poses(&cap, &q)[1] * DVec3::X;
        assert!((p - DVec3::new(0.5, 1.0, 0.0)).length() < 1e-14);
    }
}
