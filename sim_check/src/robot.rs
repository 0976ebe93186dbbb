//! A URDF as read from disk: links, joints and geometry, with the line each stands in.
//!
//! ```
//! use sim_check::CheckOptions;
//! use sim_check::read::load::from_text;
//! let text = r#"<robot name="rail"><link name="base"/><link name="sled"/>
//!   <joint name="slide" type="prismatic"><parent link="base"/><child link="sled"/>
//!     <axis xyz="1 0 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>"#;
//! let robot = from_text(text, ".".as_ref(), &CheckOptions::default()).robot.unwrap();
//! assert_eq!((robot.root(), robot.joint_above(1)), (0, Some(0)));
//! assert_eq!(robot.link_poses(&[0.25])[1].translation.x, 0.25);
//! ```

use std::collections::BTreeSet;
use std::sync::Arc;

use glamx::{DMat3, DPose3, DVec3};
use object::Mesh;

/// A URDF whose links and joints form one tree. Lengths in metres, angles in radians, kilograms.
///
/// Built only through [`Robot::new`], so every instance holds: exactly one root, every index in
/// range, every link reached from the root. Everything else is as the file says: whether axes,
/// limits, masses and meshes are any good is for the checks to tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Name of the robot.
    pub name: String,
    /// Its links, in file order.
    pub links: Vec<Link>,
    /// Its joints, in file order.
    pub joints: Vec<Joint>,
    /// What the file is written in.
    pub format: Format,
    /// What the file says beside links and joints.
    pub beside: Beside,
    root: usize,
    order: Vec<usize>,
    joint_above: Vec<Option<usize>>,
    spans: Vec<[usize; 2]>,
}

/// What a file says beside links and joints, and what of it was not read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Beside {
    /// Pairs of links, the smaller index first, that the file lets pass through each other.
    pub apart: BTreeSet<[usize; 2]>,
    /// What was not read, each with its line, and the checks that depend on it.
    pub unread: Vec<Unread>,
    /// What a person should look at: the check it belongs to, and the words.
    pub flags: Vec<(&'static str, String)>,
    /// What speaks for a robot rather than an object, in words.
    pub signs: Vec<String>,
    /// Whether the root floats freely, where the file says so.
    pub floats: Option<bool>,
    /// The name of the pose it declares, where that is the one it is judged at.
    pub declared: Option<String>,
}

/// Something in a file that is not read here.
#[derive(Clone, Debug, PartialEq)]
pub struct Unread {
    /// What, and where.
    pub what: String,
    /// The checks that depend on it.
    pub checks: &'static [&'static str],
}

/// What a file is written in: what it has no words for cannot be asked of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// URDF.
    #[default]
    Urdf,
    /// MJCF: joints have no largest velocity.
    Mjcf,
    /// SDFormat: joints have no largest effort or velocity unless it is said.
    Sdf,
    /// USD with UsdPhysics: the same.
    Usd,
}

impl Format {
    /// Whether shapes say what they may touch.
    pub fn has_masks(self) -> bool {
        matches!(self, Self::Mjcf | Self::Sdf)
    }

    /// Whether a joint needs no drive of its own.
    pub fn may_be_passive(self) -> bool {
        self != Self::Urdf
    }
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name, unique in its robot.
    pub name: String,
    /// Mass and inertia, where the file gives them.
    pub inertial: Option<Inertial>,
    /// What is seen.
    pub visuals: Vec<Shape>,
    /// What is touched.
    pub collisions: Vec<Shape>,
    /// Whether it only stands between two joints of one body, and so has neither mass nor shape.
    pub between: bool,
    /// Line of the file, from 1.
    pub line: u32,
}

/// Mass and inertia as written; neither needs to be physical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Frame of the inertia in the link frame; its origin is the centre of mass, metres.
    pub origin: DPose3,
    /// kg.
    pub mass: f64,
    /// kg·m² about the centre of mass, in the axes of `origin`; symmetric by construction.
    pub inertia: DMat3,
    /// Line of the file, from 1.
    pub line: u32,
}

/// A `<visual>` or `<collision>`.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Its frame in the link frame.
    pub origin: DPose3,
    /// Its geometry, in its own frame, metres; a mesh has its scale applied.
    pub geometry: Geometry,
    /// Scale the file gives a mesh; (1, 1, 1) otherwise.
    pub scale: DVec3,
    /// The mesh's file name as written, or the name of the primitive.
    pub source: String,
    /// The colour the file gives all of it, sRGB and opacity; `None` where it gives none.
    pub colour: Option<[u8; 4]>,
    /// What it may touch, as MJCF has it: its type and the types it meets, a bit each.
    pub mask: [u32; 2],
    /// Line of the file, from 1.
    pub line: u32,
}

/// What a shape is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// A box centred on its frame.
    Box {
        /// Full side lengths, metres.
        size: DVec3,
    },
    /// A cylinder along z, centred on its frame.
    Cylinder {
        /// Metres.
        radius: f64,
        /// Full length along z, metres.
        length: f64,
    },
    /// A sphere centred on its frame.
    Sphere {
        /// Metres.
        radius: f64,
    },
    /// A cylinder along z with half balls at its ends, centred on its frame.
    Capsule {
        /// Metres.
        radius: f64,
        /// Length of the cylinder along z, metres; 0 for a ball.
        length: f64,
    },
    /// A ball stretched along the axes, centred on its frame (MJCF only).
    Ellipsoid {
        /// Half axes, metres.
        half: DVec3,
    },
    /// A surface from a file.
    Mesh(Arc<Mesh>),
    /// A shape that could not be had: no check may pass for want of it.
    Unread {
        /// Why.
        reason: String,
    },
}

/// A joint between two links.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name, unique in its robot.
    pub name: String,
    /// How it moves.
    pub kind: Motion,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link, whose frame at rest is `origin`.
    pub child: usize,
    /// Joint frame in the parent link's frame.
    pub origin: DPose3,
    /// Unit direction in the joint frame; zero if the file's axis has no direction.
    pub axis: DVec3,
    /// The axis as written; (1, 0, 0) if left out, as URDF has it.
    pub axis_as_written: DVec3,
    /// Range, effort and velocity, where the file gives them.
    pub limit: Option<Limit>,
    /// Damping and friction, where the file gives them.
    pub dynamics: Option<Dynamics>,
    /// The joint it follows, where the file says so.
    pub mimic: Option<Mimic>,
    /// What the file calls the pose it is judged at, radians or metres: 0, unless that lies outside
    /// its limits. All else in this model is told from there.
    pub rest: f64,
    /// The spring in it, where the file gives one.
    pub spring: Option<Spring>,
    /// Why it cannot be moved on its own, where that is so.
    pub held: Option<String>,
    /// Line of the file, from 1.
    pub line: u32,
}

/// The six joint types of URDF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Does not move.
    Fixed,
    /// Turns between limits.
    Revolute,
    /// Turns without limits.
    Continuous,
    /// Slides between limits.
    Prismatic,
    /// Free in six directions.
    Floating,
    /// Free in a plane.
    Planar,
}

/// `<limit>`: radians, N·m and rad/s for a turn; metres, N and m/s for a slide. As written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Smallest value; 0 if left out, as URDF has it.
    pub lower: f64,
    /// Largest value; 0 if left out, as URDF has it.
    pub upper: f64,
    /// Largest force or torque, where given.
    pub effort: Option<f64>,
    /// Largest speed, where given.
    pub velocity: Option<f64>,
}

impl Limit {
    /// No range and nothing said.
    pub const NONE: Self = Self { lower: 0.0, upper: 0.0, effort: None, velocity: None };
}

/// `<dynamics>`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// N·m·s/rad or N·s/m, where given.
    pub damping: Option<f64>,
    /// Static friction, N·m or N, where given.
    pub friction: Option<f64>,
}

/// A spring of a joint (MJCF only).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// N·m/rad or N/m.
    pub stiffness: f64,
    /// Where it pulls to, radians or metres from rest.
    pub at: f64,
}

/// `<mimic>`: q = multiplier · q(joint) + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mimic {
    /// Index of the joint that leads.
    pub joint: usize,
    /// Factor.
    pub multiplier: f64,
    /// Radians or metres.
    pub offset: f64,
}

/// Links and joints that do not form one tree.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TreeFault {
    /// A joint names a link or joint by an index that is not there.
    #[error("joint `{0}` refers to a link or joint that does not exist")]
    Reference(String),
    /// A link that two joints claim.
    #[error("link `{0}` has more than one parent joint")]
    TwoParents(String),
    /// No root, or several.
    #[error("a robot has exactly one root link, found {}: {}", .0.len(), .0.join(", "))]
    Roots(Vec<String>),
    /// Links that never reach the root.
    #[error("links {} form a cycle", .0.join(", "))]
    Cycle(Vec<String>),
}

impl Motion {
    /// Whether it moves at all.
    pub fn moves(self) -> bool {
        self != Self::Fixed
    }

    /// Whether it turns about its axis.
    pub fn turns(self) -> bool {
        matches!(self, Self::Revolute | Self::Continuous)
    }

    /// Whether it has one degree of freedom along or about its axis.
    pub fn has_axis(self) -> bool {
        matches!(self, Self::Revolute | Self::Continuous | Self::Prismatic)
    }
}

impl Joint {
    /// The motion of the joint alone, `q` radians or metres from rest, in the joint frame.
    /// Identity for fixed, floating and planar joints.
    pub fn motion(&self, q: f64) -> DPose3 {
        match self.kind {
            Motion::Revolute | Motion::Continuous => DPose3::rotation(self.axis * q),
            Motion::Prismatic => DPose3::from_translation(self.axis * q),
            Motion::Fixed | Motion::Floating | Motion::Planar => DPose3::identity(),
        }
    }

    /// The limits as the file has them, told from its own zero.
    pub fn limits_as_written(&self) -> Option<(f64, f64)> {
        self.limit.map(|l| (l.lower + self.rest, l.upper + self.rest))
    }

    /// Lower and upper end; ±π for a continuous joint, `None` where the file gives none.
    pub fn ends(&self) -> Option<(f64, f64)> {
        use std::f64::consts::PI;
        match self.kind {
            Motion::Continuous => Some((-PI, PI)),
            Motion::Revolute | Motion::Prismatic => self.limit.map(|l| (l.lower, l.upper)),
            Motion::Fixed | Motion::Floating | Motion::Planar => None,
        }
    }
}

impl Robot {
    /// Proves the tree.
    ///
    /// # Errors
    /// [`TreeFault`], the first broken rule in the order of its variants.
    pub fn new(name: String, links: Vec<Link>, joints: Vec<Joint>) -> Result<Self, TreeFault> {
        let joint_above = joint_above(&links, &joints)?;
        let (root, order) = root_first(&links, &joints, &joint_above)?;
        let spans = spans(&joints, &joint_above, &order);
        let (format, beside) = (Format::Urdf, Beside::default());
        Ok(Self { name, links, joints, format, beside, root, order, joint_above, spans })
    }

    /// Index of the root link.
    pub fn root(&self) -> usize {
        self.root
    }

    /// All links, each parent before its children.
    pub fn root_first(&self) -> &[usize] {
        &self.order
    }

    /// The joint whose child the link is, `None` for the root.
    pub fn joint_above(&self, link: usize) -> Option<usize> {
        self.joint_above[link]
    }

    /// Parent link, `None` for the root.
    pub fn parent(&self, link: usize) -> Option<usize> {
        self.joint_above[link].map(|j| self.joints[j].parent)
    }

    /// Frame of every link in the root link's frame; `q` holds one value per joint (metres or
    /// radians from rest, missing ones count as 0).
    pub fn link_poses(&self, q: &[f64]) -> Vec<DPose3> {
        let mut poses = vec![DPose3::identity(); self.links.len()];
        for &link in &self.order {
            let Some(j) = self.joint_above[link] else { continue };
            let joint = &self.joints[j];
            let value = q.get(j).copied().unwrap_or(0.0);
            poses[link] = poses[joint.parent] * joint.origin * joint.motion(value);
        }
        poses
    }

    /// For each link, the first link of the rigid body it belongs to: links tied by fixed joints
    /// are one body.
    pub fn body_of_link(&self) -> Vec<usize> {
        let mut body: Vec<usize> = (0..self.links.len()).collect();
        for &link in &self.order {
            let Some(j) = self.joint_above[link] else { continue };
            if !self.joints[j].kind.moves() {
                body[link] = body[self.joints[j].parent];
            }
        }
        body
    }

    /// Whether `link` is `ancestor` or hangs below it.
    pub fn is_under(&self, link: usize, ancestor: usize) -> bool {
        let [first, end] = self.spans[ancestor];
        (first..end).contains(&self.spans[link][0])
    }

    /// The number of a link, counted depth first from the root, and the end of the numbers of all
    /// that hangs below it.
    pub(crate) fn span(&self, link: usize) -> [usize; 2] {
        self.spans[link]
    }
}

/// Depth-first numbers: of each link its own, and the end of those below it.
fn spans(joints: &[Joint], above: &[Option<usize>], order: &[usize]) -> Vec<[usize; 2]> {
    let parent = |link: usize| above[link].map(|j| joints[j].parent);
    let mut sizes = vec![1; order.len()];
    for &link in order.iter().rev() {
        if let Some(parent) = parent(link) {
            sizes[parent] += sizes[link];
        }
    }
    let (mut spans, mut next) = (vec![[0, 0]; order.len()], vec![0; order.len()]);
    for &link in order {
        let first = parent(link).map_or(0, |parent| next[parent]);
        if let Some(parent) = parent(link) {
            next[parent] += sizes[link];
        }
        next[link] = first + 1;
        spans[link] = [first, first + sizes[link]];
    }
    spans
}

fn joint_above(links: &[Link], joints: &[Joint]) -> Result<Vec<Option<usize>>, TreeFault> {
    let mut above = vec![None; links.len()];
    for (j, joint) in joints.iter().enumerate() {
        let leads = joint.mimic.is_none_or(|m| m.joint < joints.len());
        if joint.parent.max(joint.child) >= links.len() || !leads {
            return Err(TreeFault::Reference(joint.name.clone()));
        }
        if above[joint.child].replace(j).is_some() {
            return Err(TreeFault::TwoParents(links[joint.child].name.clone()));
        }
    }
    Ok(above)
}

fn root_first(
    links: &[Link],
    joints: &[Joint],
    above: &[Option<usize>],
) -> Result<(usize, Vec<usize>), TreeFault> {
    let names = |of: &[usize]| of.iter().map(|&l| links[l].name.clone()).collect::<Vec<_>>();
    let roots: Vec<usize> = (0..links.len()).filter(|&l| above[l].is_none()).collect();
    let &[root] = &roots[..] else { return Err(TreeFault::Roots(names(&roots))) };
    let mut children = vec![Vec::new(); links.len()];
    joints.iter().for_each(|j| children[j.parent].push(j.child));
    let mut order = vec![root];
    let mut done = 0;
    while done < order.len() {
        order.extend_from_slice(&children[order[done]]);
        done += 1;
    }
    if order.len() < links.len() {
        let lost: Vec<_> = (0..links.len()).filter(|l| !order.contains(l)).collect();
        return Err(TreeFault::Cycle(names(&lost)));
    }
    Ok((root, order))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn link(name: &str) -> Link {
        let name = name.into();
        let (visuals, collisions) = (vec![], vec![]);
        Link { name, inertial: None, visuals, collisions, between: false, line: 1 }
    }

    fn hinge(parent: usize, child: usize) -> Joint {
        Joint {
            name: format!("j{child}"),
            kind: Motion::Revolute,
            parent,
            child,
            origin: DPose3::translation(1.0, 0.0, 0.0),
            axis: DVec3::Z,
            axis_as_written: DVec3::Z,
            limit: None,
            dynamics: None,
            mimic: None,
            rest: 0.0,
            spring: None,
            held: None,
            line: 1,
        }
    }

    #[test]
    fn a_turned_hinge_carries_its_child_along() {
        let links = ["a", "b", "c"].map(link).to_vec();
        let arm = Robot::new("arm".into(), links, vec![hinge(1, 2), hinge(0, 1)]).unwrap();
        assert_eq!(arm.root_first(), [0, 1, 2]);
        let poses = arm.link_poses(&[0.0, std::f64::consts::FRAC_PI_2]);
        assert!((poses[2].translation - DVec3::new(1.0, 1.0, 0.0)).length() < 1e-15);
    }

    #[test]
    fn what_is_not_a_tree_is_refused() {
        let links = |n: usize| ["a", "b", "c"][..n].iter().map(|n| link(n)).collect::<Vec<_>>();
        let refuse = |n, joints| Robot::new("r".into(), links(n), joints).unwrap_err().to_string();
        assert_eq!(refuse(2, vec![]), "a robot has exactly one root link, found 2: a, b");
        assert_eq!(refuse(3, vec![hinge(1, 2), hinge(2, 1)]), "links b, c form a cycle");
        assert_eq!(
            refuse(3, vec![hinge(0, 1), hinge(0, 1), hinge(0, 2)]),
            "link `b` has more than one parent joint"
        );
        assert_eq!(
            refuse(2, vec![hinge(0, 7)]),
            "joint `j7` refers to a link or joint that does not exist"
        );
    }
}
