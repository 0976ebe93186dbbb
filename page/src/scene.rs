//! What there is to show. Lengths in metres, angles in radians, kilograms; z up.

use glamx::{DMat3, DPose3, DVec3};
use object::Mesh;
use serde::Serialize;

/// Everything a page shows. Indices that lead nowhere are left out of the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// What the object is called.
    pub title: String,
    /// How far it gets in the checks; `None` where nobody checked it.
    pub tier: Option<Tier>,
    /// Where it comes from and what else there is to know, line by line.
    pub about: Vec<Line>,
    /// What cannot be shown, or not as it is, and why.
    pub notes: Vec<String>,
    /// Rigid bodies.
    pub links: Vec<Link>,
    /// What joins them: a forest, each link the child of one joint at most.
    pub joints: Vec<Joint>,
    /// What was checked, in the order of the profile.
    pub checks: Vec<Check>,
}

/// How far an object gets in the checks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tier {
    /// Its name, like `dynamic`.
    pub name: String,
    /// How many tiers it reached, and how many were asked for.
    pub reached: [usize; 2],
    /// The profile the tiers are of.
    pub profile: String,
}

/// A label and what stands behind it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Line {
    /// What it is.
    pub label: String,
    /// What it says.
    pub text: String,
}

/// A rigid body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// What else is known of it, and where that comes from.
    pub facts: Vec<Line>,
    /// What is seen, in the link's frame; `None` if nothing is.
    pub visual: Option<Mesh>,
    /// What is touched, piece by piece, in the link's frame.
    pub collisions: Vec<Mesh>,
    /// Mass and inertia, where they are known.
    pub inertial: Option<Inertial>,
}

/// Mass and inertia of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// kg.
    pub mass: f64,
    /// Centre of mass and the axes of `inertia`, in the link's frame.
    pub frame: DPose3,
    /// kg·m² about the centre of mass, in the axes of `frame`.
    pub inertia: DMat3,
}

/// A joint between two links.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// How it moves.
    pub kind: Kind,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link, whose frame at 0 is `origin`.
    pub child: usize,
    /// Joint frame in the parent link's frame.
    pub origin: DPose3,
    /// Unit direction in the joint frame.
    pub axis: DVec3,
    /// Lower and upper end, radians or metres; `None` where there is none.
    pub range: Option<[f64; 2]>,
    /// The joint it follows.
    pub mimic: Option<Mimic>,
    /// What else is known of it, and where that comes from.
    pub facts: Vec<Line>,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Not at all.
    Fixed,
    /// Turns between limits.
    Revolute,
    /// Turns without limits.
    Continuous,
    /// Slides between limits.
    Prismatic,
    /// In more than one way; shown as it stands.
    Free,
}

/// q = factor · q(joint) + offset.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mimic {
    /// Index of the joint that leads.
    pub joint: usize,
    /// Factor.
    pub factor: f64,
    /// Radians or metres.
    pub offset: f64,
}

/// What was checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Its id in the profile, like `C1`.
    pub id: String,
    /// The rule in plain words.
    pub rule: String,
    /// What became of it.
    pub status: Status,
    /// The worst figure found, with its unit; empty if there is none.
    pub figure: String,
    /// The bound, with its unit.
    pub bound: String,
    /// What was found, worst first.
    pub evidence: Vec<Evidence>,
}

/// What became of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Holds.
    Pass,
    /// Holds, or does not count, but a person should look.
    Warn,
    /// Does not hold, and somebody answers for it.
    Waived,
    /// Does not hold.
    Fail,
    /// Could not be decided.
    Unknown,
}

/// One thing that was found, and where.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// In words.
    pub text: String,
    /// The pose in which it shows: joints and their values, radians or metres; all others at 0.
    pub pose: Vec<(usize, f64)>,
    /// Where.
    pub place: Option<Place>,
    /// The links it is about.
    pub links: Vec<usize>,
}

/// A point of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Index of the link.
    pub link: usize,
    /// In the link's frame, metres.
    pub at: DVec3,
}
