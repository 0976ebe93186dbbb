//! Takes bodies that cannot move against each other during a run as one.
//!
//! A joint that is held and that no contact pulls at is as good as welded. Welding it saves the
//! engine work.

use glamx::DPose3;

use crate::checks::sweep::Scene;
use crate::mass::lump::Lump;

/// Mass of a point between two joints, as a share of what it carries; a guess.
const SHARE: f64 = 0.01;

/// The scene's bodies in groups, each one body to the engine.
#[derive(Clone, Debug)]
pub struct Welds {
    /// For each body of the scene, the index of its group.
    group: Vec<usize>,
    /// For each group, its body nearest the root.
    tops: Vec<usize>,
}

impl Welds {
    /// Groups the bodies that the joints in `welded` (indices into the robot's) tie together.
    pub fn new(scene: &Scene, welded: &[usize]) -> Self {
        let robot = scene.robot;
        let mut above: Vec<Option<usize>> = vec![None; scene.bodies.len()];
        for &j in welded {
            let joint = &robot.joints[j];
            above[scene.body_index(joint.child)] = Some(scene.body_index(joint.parent));
        }
        let mut top_of: Vec<usize> = (0..scene.bodies.len()).collect();
        for &link in robot.root_first() {
            let body = scene.body_index(link);
            if let Some(parent) = above[body].filter(|_| scene.bodies[body].link == link) {
                top_of[body] = top_of[parent];
            }
        }
        let tops: Vec<usize> = (0..top_of.len()).filter(|&b| top_of[b] == b).collect();
        let group = top_of.iter().map(|t| tops.binary_search(t).unwrap_or_default()).collect();
        Self { group, tops }
    }

    /// The group a body belongs to.
    pub fn of(&self, body: usize) -> usize {
        self.group[body]
    }

    /// For each group, the body whose frame is the group's.
    pub fn tops(&self) -> &[usize] {
        &self.tops
    }

    /// Where a body stands in the frame of its group; `poses` are the links' at the start.
    pub fn place(&self, scene: &Scene, body: usize, poses: &[DPose3]) -> DPose3 {
        let top = self.tops[self.group[body]];
        poses[scene.bodies[top].link].inv_mul(&poses[scene.bodies[body].link])
    }

    /// Mass and inertia of a group in its own frame.
    pub fn lump(&self, scene: &Scene, group: usize, poses: &[DPose3]) -> Lump {
        let frame = poses[scene.bodies[self.tops[group]].link];
        let is_inside = |l: &usize| self.group[scene.body_index(*l)] == group;
        let own = lump(scene, (0..scene.robot.links.len()).filter(is_inside), &frame, poses);
        let top = self.tops[group];
        if own.mass <= 0.0 { body_lump(scene, top, poses) } else { own }
    }
}

/// Mass and inertia of a body of the scene in its own frame.
pub fn body_lump(scene: &Scene, body: usize, poses: &[DPose3]) -> Lump {
    let of = &scene.bodies[body];
    let own = lump(scene, of.links.iter().copied(), &poses[of.link], poses);
    if own.mass <= 0.0 && of.links.iter().all(|&l| scene.robot.links[l].between) {
        return of_next(scene, body, poses);
    }
    own
}

/// What stands for the mass of a body that is none, only a point between two joints: a hundredth
/// of the first body below it that has some. The engine cannot move what weighs nothing.
fn of_next(scene: &Scene, body: usize, poses: &[DPose3]) -> Lump {
    let robot = scene.robot;
    let frame = poses[scene.bodies[body].link];
    let under = robot.root_first().iter().filter(|&&l| robot.is_under(l, scene.bodies[body].link));
    let of = |&l: &usize| Lump::of_link(robot, l, &frame.inv_mul(&poses[l]));
    let next = under.map(of).find(|lump| lump.mass > 0.0).unwrap_or(Lump::EMPTY);
    Lump { mass: SHARE * next.mass, com: next.com, inertia: next.inertia * SHARE }
}

fn lump(
    scene: &Scene,
    links: impl Iterator<Item = usize>,
    frame: &DPose3,
    poses: &[DPose3],
) -> Lump {
    let of = |l: usize| Lump::of_link(scene.robot, l, &frame.inv_mul(&poses[l]));
    links.fold(Lump::EMPTY, |sum, l| sum.with(of(l)))
}

/// Joints that cannot move while `drive` runs: those that do not follow it and have no touching
/// piece on one of their sides, so that nothing can push them.
pub fn untouched(scene: &Scene, drive: usize, touching: &[usize]) -> Vec<usize> {
    let robot = scene.robot;
    let of = &scene.drives[drive];
    let driven = |j: usize| j == of.joint || of.followers.iter().any(|f| f.0 == j);
    let between = |j: usize| {
        if touching.is_empty() {
            return false;
        }
        let under = |p: &&usize| robot.is_under(scene.pieces[**p].link, robot.joints[j].child);
        let count = touching.iter().filter(under).count();
        count > 0 && count < touching.len()
    };
    let joints = (0..robot.joints.len()).filter(|&j| robot.joints[j].kind.has_axis());
    joints.filter(|&j| !driven(j) && !between(j)).collect()
}
