//! What stands in a file before references are looked up, what is wrong with it, and how much of
//! anything a file may hold.

use std::collections::BTreeMap;

use crate::robot::{Beside, Format, Joint, Link};

/// Most links, and most joints, a URDF may have.
pub const MAX_LINKS: usize = 512;
/// Most visual and collision elements a URDF may have.
pub const MAX_SHAPES: usize = 4096;
/// Largest length a URDF may state, metres.
pub const MAX_LENGTH: f64 = 1e6;

/// What stands in the file, before references are looked up.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    pub name: String,
    pub links: Vec<Link>,
    pub joints: Vec<JointDraft>,
    pub format: Format,
    /// What the file means by something that is not read here: its tree is unknown.
    pub foreign: Vec<String>,
    /// What else the file says; pairs of links that may meet are still names.
    pub beside: Beside,
    /// Links that the file lets pass through each other.
    pub apart: Vec<[String; 2]>,
    /// Links that are tied together beside the tree.
    pub ties: Vec<Tie>,
    /// The pose the file declares, by joint, radians or metres from the one it is written in.
    pub rests: BTreeMap<String, f64>,
    /// The name of that pose.
    pub declared: String,
    pub faults: Faults,
    /// Why nothing is known of the file, though it may be sound.
    pub unanswered: Option<String>,
}

/// Two links tied together beside the tree, and what that makes of each joint between them.
#[derive(Debug)]
pub(crate) struct Tie {
    pub bodies: [String; 2],
    pub why: String,
}

/// A joint that still names its links.
#[derive(Debug)]
pub(crate) struct JointDraft {
    /// Indices of links are not filled in yet.
    pub joint: Joint,
    pub parent: String,
    pub child: String,
    pub mimic: Option<MimicDraft>,
}

/// A mimic that still names its joint.
#[derive(Debug)]
pub(crate) struct MimicDraft {
    pub joint: String,
    pub multiplier: f64,
    pub offset: f64,
}

/// Broken rules found while reading, by check.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    /// F1: XML and numbers.
    pub text: Vec<String>,
    /// F2: mesh files.
    pub files: Vec<String>,
    /// F1: numbers of one element, which is not there for the checks.
    pub numbers: Vec<String>,
    /// F1: what programs read in different ways.
    pub flags: Vec<String>,
    /// F3: names.
    pub names: Vec<NameFault>,
    /// T1: references.
    pub references: Vec<String>,
    /// T1: references that the tree does without, such as an actuator's.
    pub loose: Vec<String>,
    /// T1: the same, where programs go on without.
    pub loose_flags: Vec<String>,
    /// T2: joint types and mimics.
    pub types: Vec<String>,
}

/// What is wrong with a name.
#[derive(Debug)]
pub(crate) struct NameFault {
    pub words: String,
    /// Whether it is a good name that some programs change.
    pub is_odd: bool,
}
