//! A robot made ready for contact questions: its collision pieces as hulls, its rigid bodies, and
//! the joints that can be driven on their own.

use std::f64::consts::TAU;

use glamx::{DPose3, DVec3};
use object::mesh::Bounds;

use super::bodies::{Body, Drive, Piece, Rest, values};
use super::hull::Hull;
use super::tree::PieceTree;
use crate::profile::bounds::OVERLAP;
use crate::robot::{Motion, Robot};

/// A robot's collision pieces, bodies and drives.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Every collision piece, in the order of links and elements.
    pub pieces: Vec<Piece>,
    /// For each link, the first link of its rigid body.
    pub body_of_link: Vec<usize>,
    /// For each link, the index of its body in [`Scene::bodies`].
    body_index: Vec<usize>,
    /// The bodies, ascending by first link.
    pub bodies: Vec<Body>,
    /// Joints that move on their own, each with those that follow it.
    pub drives: Vec<Drive>,
    /// Diagonal of the box around all pieces at rest, metres.
    pub diagonal: f64,
    /// Where everything stands while nothing is moved.
    pub at_rest: Rest,
    /// Its pieces in boxes within boxes, at rest.
    pub tree: PieceTree,
}

/// Why no contact question can be answered: unknown, never a pass.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneFault {
    /// No collision element anywhere.
    #[error("the robot has no collision geometry, so no contact can be found")]
    NoColliders,
    /// A part that is seen but cannot be touched.
    #[error("{0} of {1} links with visual geometry have no collider: {2}")]
    BareLinks(usize, usize, String),
    /// Fewer colliders than elements.
    #[error("link `{link}`: {built} of {elements} colliders built; `{piece}`: {reason}")]
    Lost {
        /// The link.
        link: String,
        /// Colliders built.
        built: usize,
        /// `<collision>` elements.
        elements: usize,
        /// Source of the first that failed.
        piece: String,
        /// Why it failed.
        reason: String,
    },
    /// A joint whose motion is not one number.
    #[error("joint `{0}` is {1}, which has no single range to sweep")]
    Kind(String, &'static str),
    /// A joint that cannot be moved.
    #[error("joint `{0}`: {1}")]
    Joint(String, String),
}

impl<'a> Scene<'a> {
    /// Builds every collider and counts them against the file: a piece that silently vanished
    /// would make every contact check a vacuous pass.
    ///
    /// # Errors
    /// [`SceneFault`] if a collider is missing or a joint cannot be moved.
    pub fn new(robot: &'a Robot) -> Result<Self, SceneFault> {
        let body_of_link = robot.body_of_link();
        let drives = drives(robot)?;
        let mut first: Vec<usize> = body_of_link.clone();
        first.sort_unstable();
        first.dedup();
        let body_index: Vec<usize> =
            body_of_link.iter().map(|of| first.binary_search(of).unwrap_or_default()).collect();
        let mut pieces = Vec::new();
        for (link, &body) in body_index.iter().enumerate() {
            pieces.extend(pieces_of(robot, link, body)?);
        }
        demand_colliders(robot, &pieces)?;
        let bodies = bodies(robot, &first, &body_index, &pieces, &drives);
        let at_rest = Rest::new(robot, &drives, &pieces);
        let tree = PieceTree::new(robot, &pieces, &at_rest);
        let diagonal = 0.0;
        let mut scene = Self {
            robot,
            pieces,
            body_of_link,
            body_index,
            bodies,
            drives,
            diagonal,
            at_rest,
            tree,
        };
        scene.diagonal = scene.bounds(&scene.rest()).diagonal();
        Ok(scene)
    }

    /// Joint values at rest: 0, and followers where their leader's 0 puts them.
    pub fn rest(&self) -> Vec<f64> {
        self.with(&[])
    }

    /// Joint values with some drives moved, the others at rest; followers follow.
    pub fn with(&self, moved: &[(usize, f64)]) -> Vec<f64> {
        values(self.robot, &self.drives, moved)
    }

    /// Frames of all pieces in the root frame.
    pub fn piece_poses(&self, q: &[f64]) -> Vec<DPose3> {
        let links = self.robot.link_poses(q);
        self.pieces.iter().map(|p| links[p.link] * p.origin).collect()
    }

    /// Index in [`Scene::bodies`] of the body a link belongs to.
    pub fn body_index(&self, link: usize) -> usize {
        self.body_index[link]
    }

    /// Box around all pieces.
    pub fn bounds(&self, q: &[f64]) -> Bounds {
        let poses = self.piece_poses(q);
        let boxes = self.pieces.iter().zip(&poses).map(|(p, pose)| {
            let reach = |axis| p.hull.extent_along(pose, axis);
            let ends = [DVec3::X, DVec3::Y, DVec3::Z].map(reach);
            [DVec3::from_array(ends.map(|e| e.0)), DVec3::from_array(ends.map(|e| e.1))]
        });
        Bounds::of(boxes.flatten())
    }

    /// Deepest overlap allowed between parts: 1 mm, or 0.2 % of the diagonal where that is more.
    pub fn bound(&self) -> f64 {
        OVERLAP.of(self.diagonal)
    }

    /// Name of a piece's link and, where the link has several, which piece.
    pub fn label(&self, piece: usize) -> String {
        let link = self.pieces[piece].link;
        let first = self.pieces.iter().position(|p| p.link == link).unwrap_or_default();
        let name = &self.robot.links[link].name;
        let count = self.robot.links[link].collisions.len();
        if count > 1 { format!("`{name}` piece {}", piece - first) } else { format!("`{name}`") }
    }

    /// Name of a drive's joint.
    pub fn name(&self, drive: usize) -> &str {
        &self.robot.joints[self.drives[drive].joint].name
    }

    /// Whether a drive turns.
    pub fn turns(&self, drive: usize) -> bool {
        self.robot.joints[self.drives[drive].joint].kind.turns()
    }

    /// A value of a drive for people: degrees or millimetres.
    pub fn shown(&self, drive: usize, q: f64) -> String {
        if self.turns(drive) {
            format!("{:.1} deg", q.to_degrees())
        } else {
            format!("{:.1} mm", q * 1000.0)
        }
    }

    /// Nearest body towards the root that has pieces, above the joint of a drive.
    pub fn guide_body(&self, drive: usize) -> Option<usize> {
        let mut link = Some(self.robot.joints[self.drives[drive].joint].parent);
        while let Some(l) = link {
            let body = self.body_index(l);
            if !self.bodies[body].pieces.is_empty() {
                return Some(body);
            }
            link = self.robot.parent(self.bodies[body].link);
        }
        None
    }

    /// The bodies with pieces that a drive carries first: its child's, or where that is bare the
    /// nearest below it.
    pub fn carried_bodies(&self, drive: usize) -> Vec<usize> {
        let mut front = vec![self.robot.joints[self.drives[drive].joint].child];
        let mut found = Vec::new();
        while let Some(link) = front.pop() {
            let first = self.body_of_link[link];
            let body = self.body_index(link);
            if self.bodies[body].pieces.is_empty() {
                let below = self
                    .robot
                    .joints
                    .iter()
                    .filter(|j| j.kind.moves() && self.body_of_link[j.parent] == first);
                front.extend(below.map(|j| j.child));
            } else {
                found.push(body);
            }
        }
        found.sort_unstable();
        found
    }
}

/// Links by body, with their pieces and who moves them.
fn bodies(
    robot: &Robot,
    first: &[usize],
    body_index: &[usize],
    pieces: &[Piece],
    drives: &[Drive],
) -> Vec<Body> {
    let body = |&link: &usize| Body {
        link,
        links: Vec::new(),
        pieces: Vec::new(),
        moved_by: drives.iter().map(|d| d.moves(robot, link)).collect(),
    };
    let mut bodies: Vec<Body> = first.iter().map(body).collect();
    body_index.iter().enumerate().for_each(|(link, &b)| bodies[b].links.push(link));
    pieces.iter().enumerate().for_each(|(p, piece)| bodies[piece.body].pieces.push(p));
    bodies
}

fn pieces_of(robot: &Robot, link: usize, body: usize) -> Result<Vec<Piece>, SceneFault> {
    let of = &robot.links[link];
    let (mut pieces, mut failed) = (Vec::new(), None);
    for shape in &of.collisions {
        match Hull::of(&shape.geometry) {
            Ok(hull) => pieces.push(Piece { link, body, origin: shape.origin, hull }),
            Err(e) => failed = failed.or(Some((shape.source.clone(), e.to_string()))),
        }
    }
    let Some((piece, reason)) = failed else { return Ok(pieces) };
    let (link, built, elements) = (of.name.clone(), pieces.len(), of.collisions.len());
    Err(SceneFault::Lost { link, built, elements, piece, reason })
}

fn demand_colliders(robot: &Robot, pieces: &[Piece]) -> Result<(), SceneFault> {
    if pieces.is_empty() {
        return Err(SceneFault::NoColliders);
    }
    let seen: Vec<_> = robot.links.iter().filter(|l| !l.visuals.is_empty()).collect();
    let bare: Vec<_> = seen.iter().filter(|l| l.collisions.is_empty()).collect();
    if bare.is_empty() {
        return Ok(());
    }
    let names = bare.iter().map(|l| format!("`{}`", l.name)).collect::<Vec<_>>().join(", ");
    Err(SceneFault::BareLinks(bare.len(), seen.len(), names))
}

/// The joints that move on their own.
///
/// # Errors
/// [`SceneFault`] if a joint cannot be moved.
pub(super) fn drives(robot: &Robot) -> Result<Vec<Drive>, SceneFault> {
    let mut drives = Vec::new();
    for (j, joint) in robot.joints.iter().enumerate() {
        match joint.kind {
            Motion::Fixed => continue,
            Motion::Floating => return Err(SceneFault::Kind(joint.name.clone(), "floating")),
            Motion::Planar => return Err(SceneFault::Kind(joint.name.clone(), "planar")),
            Motion::Revolute | Motion::Continuous | Motion::Prismatic => {}
        }
        let fault = |what: String| SceneFault::Joint(joint.name.clone(), what);
        if !joint.axis.is_normalized() {
            return Err(fault("its axis has no direction".into()));
        }
        if joint.mimic.is_some() {
            let (leader, ..) = leader_of(robot, j).ok_or_else(|| fault("mimics itself".into()))?;
            if robot.joints[leader].kind.has_axis() {
                continue;
            }
            return Err(fault("mimics a joint that does not move".into()));
        }
        drives.push(drive(robot, j).map_err(fault)?);
    }
    Ok(drives)
}

fn drive(robot: &Robot, joint: usize) -> Result<Drive, String> {
    let kind = robot.joints[joint].kind;
    let continuous = kind == Motion::Continuous;
    let (lower, upper) = match (continuous, robot.joints[joint].limit) {
        (true, _) => (0.0, TAU),
        (false, Some(l)) => (l.lower, l.upper),
        (false, None) => return Err("has no limits to sweep between".into()),
    };
    if !(lower.is_finite() && upper.is_finite() && lower < upper && lower <= 0.0 && upper >= 0.0) {
        return Err(format!("its limits {lower}..{upper} do not hold the rest pose 0 in order"));
    }
    let cap = if kind.turns() { TAU } else { f64::MAX };
    let follows = |&f: &usize| leader_of(robot, f).is_some_and(|(l, ..)| l == joint) && f != joint;
    let followers = (0..robot.joints.len()).filter(follows);
    let followers =
        followers.filter_map(|f| leader_of(robot, f).map(|(_, by, plus)| (f, by, plus)));
    let (lower, upper) = (lower.max(-cap), upper.min(cap));
    Ok(Drive { joint, lower, upper, continuous, followers: followers.collect() })
}

/// The joint that a joint follows in the end (itself if it follows none), with multiplier and
/// offset; `None` if they follow each other in a ring.
fn leader_of(robot: &Robot, joint: usize) -> Option<(usize, f64, f64)> {
    let (mut at, mut by, mut plus) = (joint, 1.0, 0.0);
    for _ in 0..=robot.joints.len() {
        let Some(m) = robot.joints[at].mimic else { return Some((at, by, plus)) };
        plus += by * m.offset;
        by *= m.multiplier;
        at = m.joint;
    }
    None
}
