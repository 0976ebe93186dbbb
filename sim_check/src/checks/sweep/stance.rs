//! One configuration in which a few joints are moved: poses are made when they are asked for, and
//! what nothing moves stays where it is at rest.

use glamx::DPose3;

use super::scene::Scene;

/// The same poses as [`crate::Robot::link_poses`] gives, to the last bit.
pub struct Stance<'s, 'a> {
    scene: &'s Scene<'a>,
    /// Joints and their values.
    moved: Vec<(usize, f64)>,
    /// Of the links below them, those known so far.
    known: Vec<Option<DPose3>>,
    asked: Vec<usize>,
    way: Vec<usize>,
}

impl<'s, 'a> Stance<'s, 'a> {
    /// Everything at rest.
    pub fn new(scene: &'s Scene<'a>) -> Self {
        let known = vec![None; scene.robot.links.len()];
        Self { scene, moved: Vec::new(), known, asked: Vec::new(), way: Vec::new() }
    }

    /// Some drives moved, the others at rest; followers follow.
    pub fn of(scene: &'s Scene<'a>, moved: &[(usize, f64)]) -> Self {
        let mut stance = Self::new(scene);
        stance.take(moved);
        stance
    }

    /// Goes over to another configuration.
    pub fn take(&mut self, moved: &[(usize, f64)]) {
        for link in self.asked.drain(..) {
            self.known[link] = None;
        }
        self.moved.clear();
        for &(drive, q) in moved {
            self.moved.extend(self.scene.drives[drive].values(q));
        }
    }

    /// Frame of a link in the root frame.
    pub fn link(&mut self, link: usize) -> DPose3 {
        let (robot, rest) = (self.scene.robot, &self.scene.at_rest);
        let mut at = link;
        let mut pose = loop {
            if !self.is_moved(at) {
                break rest.links[at];
            }
            if let Some(known) = self.known[at] {
                break known;
            }
            self.way.push(at);
            // What is moved hangs on a joint.
            at = robot.parent(at).unwrap_or(at);
        };
        while let Some(link) = self.way.pop() {
            let Some(j) = robot.joint_above(link) else { continue };
            let joint = &robot.joints[j];
            let value = self.moved.iter().find(|m| m.0 == j);
            let motion = value.map_or(rest.motions[j], |m| joint.motion(m.1));
            pose = pose * joint.origin * motion;
            self.known[link] = Some(pose);
            self.asked.push(link);
        }
        pose
    }

    /// Frame of a piece in the root frame.
    pub fn piece(&mut self, piece: usize) -> DPose3 {
        let of = &self.scene.pieces[piece];
        self.link(of.link) * of.origin
    }

    fn is_moved(&self, link: usize) -> bool {
        let robot = self.scene.robot;
        self.moved.iter().any(|(j, _)| robot.is_under(link, robot.joints[*j].child))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::sweep::tests::{joint, link, robot};

    #[test]
    fn poses_are_those_of_the_whole_robot_to_the_last_bit() {
        let mut text = link("l0", [0.0; 3], [0.1; 3]);
        for l in 1..12 {
            let (parent, child) = (format!("l{}", (l * 5) % l.min(7)), format!("l{l}"));
            let kind = ["revolute", "prismatic", "fixed"][l % 3];
            let at = [0.3, 0.1 * l as f64, -0.2];
            text += &link(&child, [0.01 * l as f64, 0.0, 0.0], [0.1; 3]);
            let hinge = joint((kind, &parent, &child), at, [0.6, 0.0, 0.8], [-0.7, 0.9]);
            let leads = "<mimic joint=\"l1_joint\" multiplier=\"0.3\" offset=\"0.1\"/></joint>";
            text += &if l == 4 { hinge.replace("</joint>", leads) } else { hinge };
        }
        let robot = robot(&text);
        let scene = Scene::new(&robot).unwrap();
        let mut stance = Stance::new(&scene);
        for moved in [vec![], vec![(0, 0.4)], vec![(3, -0.7), (1, 0.9)], vec![(2, 0.1), (0, -0.2)]]
        {
            stance.take(&moved);
            let poses = scene.piece_poses(&scene.with(&moved));
            for p in (0..poses.len()).rev() {
                assert_eq!(stance.piece(p), poses[p], "{moved:?}");
            }
        }
    }
}
