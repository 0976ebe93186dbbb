//! What a scene is made of: convex pieces, rigid bodies, drives, and where they stand at rest.

use std::f64::consts::PI;

use glamx::DPose3;
use object::mesh::Bounds;

use super::hull::Hull;
use crate::robot::Robot;

/// A scene at rest.
#[derive(Clone, Debug)]
pub struct Rest {
    /// One value per joint, radians or metres.
    pub values: Vec<f64>,
    /// The motion each joint makes at its value.
    pub motions: Vec<DPose3>,
    /// Frames of all links in the root frame.
    pub links: Vec<DPose3>,
    /// Frames of all pieces in the root frame.
    pub poses: Vec<DPose3>,
    /// Boxes of all pieces in the root frame.
    pub boxes: Vec<Bounds>,
}

impl Rest {
    pub(super) fn new(robot: &Robot, drives: &[Drive], pieces: &[Piece]) -> Self {
        let values = values(robot, drives, &[]);
        let motions = robot.joints.iter().zip(&values).map(|(j, q)| j.motion(*q)).collect();
        let links = robot.link_poses(&values);
        let poses: Vec<_> = pieces.iter().map(|p| links[p.link] * p.origin).collect();
        let boxes = pieces.iter().zip(&poses).map(|(p, pose)| p.hull.bounds_at(pose)).collect();
        Self { values, motions, links, poses, boxes }
    }
}

/// A convex collision piece.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The link it belongs to.
    pub link: usize,
    /// Index of its body in [`super::scene::Scene::bodies`].
    pub body: usize,
    /// Its frame in the link frame.
    pub origin: DPose3,
    /// Its hull.
    pub hull: Hull,
    /// What it may touch, as MJCF has it.
    pub mask: [u32; 2],
}

/// Links tied together by fixed joints.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its first link, towards the root.
    pub link: usize,
    /// All its links, ascending.
    pub links: Vec<usize>,
    /// Indices of its pieces.
    pub pieces: Vec<usize>,
    /// For each drive, whether it moves this body relative to the root.
    pub moved_by: Vec<bool>,
}

/// A joint that moves on its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Index of the joint.
    pub joint: usize,
    /// Lower end of what is swept, radians or metres: at most a full turn from rest.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
    /// Whether it turns without limits.
    pub continuous: bool,
    /// Joints that follow it, with multiplier and offset.
    pub followers: Vec<(usize, f64, f64)>,
}

impl Drive {
    /// Whether moving this drive moves a link relative to the root.
    pub(super) fn moves(&self, robot: &Robot, link: usize) -> bool {
        let under = |joint: usize| robot.is_under(link, robot.joints[joint].child);
        under(self.joint) || self.followers.iter().any(|f| under(f.0))
    }

    /// The joint and its followers with the values they take when the drive stands at `q`.
    pub fn values(&self, q: f64) -> impl Iterator<Item = (usize, f64)> {
        let follow = self.followers.iter().map(move |&(j, by, plus)| (j, by * q + plus));
        std::iter::once((self.joint, q)).chain(follow)
    }

    /// Where the drive stands after a share (0 to 1) of its way from rest through its range and
    /// back to rest; a continuous joint goes round once.
    pub fn along(&self, share: f64) -> f64 {
        if self.continuous {
            return self.upper * share;
        }
        let way = share * 2.0 * (self.upper - self.lower);
        if way <= -self.lower {
            -way
        } else if way <= self.upper - 2.0 * self.lower {
            way + 2.0 * self.lower
        } else {
            2.0 * (self.upper - self.lower) - way
        }
    }

    /// The ends that differ from rest; for a continuous joint the quarter turns.
    pub fn corners(&self) -> Vec<f64> {
        if self.continuous {
            return vec![PI / 2.0, PI, 1.5 * PI];
        }
        [self.lower, self.upper].into_iter().filter(|q| *q != 0.0).collect()
    }
}

/// One value per joint with some drives moved, the others at rest; followers follow.
pub(super) fn values(robot: &Robot, drives: &[Drive], moved: &[(usize, f64)]) -> Vec<f64> {
    let mut q = vec![0.0; robot.joints.len()];
    for (d, drive) in drives.iter().enumerate() {
        let value = moved.iter().find(|m| m.0 == d).map_or(0.0, |m| m.1);
        drive.values(value).for_each(|(j, v)| q[j] = v);
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(lower: f64, upper: f64, continuous: bool) -> Drive {
        Drive { joint: 3, lower, upper, continuous, followers: vec![(5, -2.0, 0.5)] }
    }

    #[test]
    fn a_drive_goes_to_both_ends_and_back_to_rest() {
        let door = drive(-1.0, 3.0, false);
        let way: Vec<f64> = (0..=8).map(|k| door.along(f64::from(k) / 8.0)).collect();
        assert_eq!(way, [0.0, -1.0, 0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0]);
        assert_eq!(door.corners(), [-1.0, 3.0]);
        assert_eq!(drive(0.0, 3.0, false).corners(), [3.0]);
        assert_eq!(drive(0.0, 2.0 * PI, true).corners(), [PI / 2.0, PI, 1.5 * PI]);
    }

    #[test]
    fn followers_follow_with_factor_and_offset() {
        let moved: Vec<_> = drive(0.0, 1.0, false).values(0.25).collect();
        assert_eq!(moved, [(3, 0.25), (5, 0.0)]);
    }
}
