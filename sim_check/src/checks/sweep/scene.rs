//! A robot made ready for contact questions: its collision pieces as hulls, its rigid bodies, and
//! the joints that can be driven on their own.

use std::f64::consts::TAU;

use glamx::{DPose3, DVec3};
use object::mesh::Bounds;

use super::bodies::{Body, Drive, Piece, Rest, values};
use super::hull::Hull;
use super::terms::Terms;
use super::tree::PieceTree;
use crate::profile::bounds::OVERLAP;
use crate::profile::subject::{Base, Subject};
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
    /// Which pairs count.
    pub terms: Terms,
    /// Of a robot, what overlaps at rest: these pairs are told once and count no longer.
    pub met: Option<Vec<([usize; 2], f64)>>,
    /// Colliders that are not there, each with why: contact with them is unknown.
    pub missing: Vec<String>,
    /// Whether the root stands fast, where that was said.
    pub base: Option<Base>,
    /// Joints that are not moved, each with why: what their motion does is unknown.
    pub held: Vec<String>,
}

/// Why contact questions cannot be answered, or not all: unknown, never a pass.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneFault {
    /// No collider could be built.
    #[error("{0}")]
    NoneBuilt(String),
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
}

impl<'a> Scene<'a> {
    /// The same for an asset: see [`Scene::of`].
    ///
    /// # Errors
    /// [`SceneFault`] if there is no collider at all.
    pub fn new(robot: &'a Robot) -> Result<Self, SceneFault> {
        Self::of(robot, Subject::Object)
    }

    /// Builds every collider and counts them against the file: a piece that silently vanished
    /// would make every contact check a vacuous pass. What is missing, and which joints cannot be
    /// moved, stands in the scene.
    ///
    /// # Errors
    /// [`SceneFault`] if there is no collider at all.
    pub fn of(robot: &'a Robot, subject: Subject) -> Result<Self, SceneFault> {
        let body_of_link = robot.body_of_link();
        let (drives, held) = drives(robot);
        let mut first: Vec<usize> = body_of_link.clone();
        first.sort_unstable();
        first.dedup();
        let body_index: Vec<usize> =
            body_of_link.iter().map(|of| first.binary_search(of).unwrap_or_default()).collect();
        let (mut pieces, mut missing) = (Vec::new(), Vec::new());
        for (link, &body) in body_index.iter().enumerate() {
            let (found, fault) = pieces_of(robot, link, body);
            pieces.extend(found);
            missing.extend(fault.map(|fault| fault.to_string()));
        }
        if pieces.is_empty() {
            return match missing.is_empty() {
                true => Err(SceneFault::NoColliders),
                false => Err(SceneFault::NoneBuilt(missing.join("; "))),
            };
        }
        // What a robot shows without touching anything is decoration.
        if subject == Subject::Object {
            missing.extend(bare_links(robot).map(|fault| fault.to_string()));
        }
        let terms = Terms::new(robot, subject, &body_index, &pieces);
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
            terms,
            met: None,
            missing,
            base: None,
            held,
        };
        scene.diagonal = scene.bounds(&scene.rest()).diagonal();
        Ok(scene)
    }

    /// Takes note of what overlaps at rest, pairs of pieces and depths, and leaves it alone from here
    /// on.
    pub(crate) fn leave(&mut self, found: Vec<([usize; 2], f64)>) {
        let bound = self.bound();
        for (pieces, _) in found.iter().filter(|(_, depth)| *depth > bound) {
            let [a, b] = pieces.map(|p| self.pieces[p].body);
            self.terms.leave(a, b);
        }
        self.met = Some(found);
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

    /// Whether an overlap of two pieces counts.
    pub fn counts(&self, p: usize, q: usize) -> bool {
        let [a, b] = [p, q].map(|p| self.pieces[p].body);
        self.terms.look_at(a, b) && self.terms.meet(p, q)
    }

    /// Name of a drive's joint.
    pub fn name(&self, drive: usize) -> &str {
        &self.robot.joints[self.drives[drive].joint].name
    }

    /// Whether a drive turns.
    pub fn turns(&self, drive: usize) -> bool {
        self.robot.joints[self.drives[drive].joint].kind.turns()
    }

    /// A value of a drive for people, as the file counts it: degrees or millimetres.
    pub fn shown(&self, drive: usize, q: f64) -> String {
        let q = q + self.robot.joints[self.drives[drive].joint].rest;
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

/// The pieces of a link, and what failed.
fn pieces_of(robot: &Robot, link: usize, body: usize) -> (Vec<Piece>, Option<SceneFault>) {
    let of = &robot.links[link];
    let (mut pieces, mut failed) = (Vec::new(), None);
    for shape in &of.collisions {
        match Hull::of(&shape.geometry) {
            Ok(hull) => {
                pieces.push(Piece { link, body, origin: shape.origin, hull, mask: shape.mask });
            }
            Err(e) => failed = failed.or(Some((shape.source.clone(), e.to_string()))),
        }
    }
    let Some((piece, reason)) = failed else { return (pieces, None) };
    let (link, built, elements) = (of.name.clone(), pieces.len(), of.collisions.len());
    (pieces, Some(SceneFault::Lost { link, built, elements, piece, reason }))
}

fn bare_links(robot: &Robot) -> Option<SceneFault> {
    let seen: Vec<_> = robot.links.iter().filter(|l| !l.visuals.is_empty()).collect();
    let bare: Vec<_> = seen.iter().filter(|l| l.collisions.is_empty()).collect();
    let names = bare.iter().map(|l| format!("`{}`", l.name)).collect::<Vec<_>>().join(", ");
    (!bare.is_empty()).then_some(SceneFault::BareLinks(bare.len(), seen.len(), names))
}

/// The joints that move on their own, and why others that move do not.
///
/// What floats freely stands nowhere in particular and is left where it is.
pub(super) fn drives(robot: &Robot) -> (Vec<Drive>, Vec<String>) {
    let (mut drives, mut held) = (Vec::new(), Vec::new());
    for (j, joint) in robot.joints.iter().enumerate() {
        let mut hold = |why: &str| held.push(format!("joint `{}` {why}", joint.name));
        match (joint.kind, &joint.held) {
            (Motion::Fixed, _) => continue,
            (_, Some(why)) => {
                hold(why);
                continue;
            }
            (Motion::Floating, None) => continue,
            (Motion::Planar, None) => {
                hold("is planar, which has no single range to sweep");
                continue;
            }
            (Motion::Revolute | Motion::Continuous | Motion::Prismatic, None) => {}
        }
        if joint.mimic.is_some() {
            match leader_of(robot, j) {
                None => hold("mimics itself"),
                Some((leader, ..)) if !is_driven(robot, leader) => {
                    hold("mimics a joint that does not move");
                }
                Some(_) => {}
            }
            continue;
        }
        match drive(robot, j) {
            Ok(drive) => drives.push(drive),
            Err(why) => hold(&why),
        }
    }
    (drives, held)
}

fn is_driven(robot: &Robot, joint: usize) -> bool {
    let joint = &robot.joints[joint];
    joint.kind.has_axis() && joint.held.is_none()
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
        return Err(format!("has limits {lower}..{upper} that do not hold the rest pose in order"));
    }
    let cap = if kind.turns() { TAU } else { f64::MAX };
    let follows = |&f: &usize| {
        let leads = leader_of(robot, f).is_some_and(|(l, ..)| l == joint) && f != joint;
        leads && is_driven(robot, f)
    };
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
