//! What a model is of, by what stands in it: an object or a robot, on a fixed or a free base.
//!
//! ```
//! use sim_check::read::load::from_text;
//! use sim_check::checks::kind;
//! use sim_check::{CheckOptions, Subject};
//! let text = r#"<robot name="arm"><link name="world"/><link name="upper_arm"/>
//!   <joint name="shoulder" type="continuous"><parent link="world"/><child link="upper_arm"/></joint>
//!   </robot>"#;
//! let robot = from_text(text, ".".as_ref(), &CheckOptions::default()).robot.unwrap();
//! let found = kind::found(&robot);
//! assert_eq!((found.subject, found.because.as_str()), (Subject::Robot, "joint `shoulder`"));
//! ```

use std::collections::BTreeSet;

use crate::profile::subject::{Base, Judged, Subject};
use crate::robot::{Motion, Robot};

/// Parts of names that only robots have. Of no use are `wheel`, `arm` and `base`, which carts,
/// lamps and cabinets have, too.
const NAMES: [&str; 19] = [
    "shoulder",
    "elbow",
    "wrist",
    "gripper",
    "finger",
    "thumb",
    "knee",
    "ankle",
    "thigh",
    "calf",
    "shank",
    "forearm",
    "upperarm",
    "upper_arm",
    "upper_leg",
    "lower_leg",
    "torso",
    "pelvis",
    "end_effector",
];
/// So many joints in a row are a robot: furniture has two or three, lamps four.
const CHAIN: usize = 5;
/// So many limbs of so many joints in a row are fingers or legs: a guess.
const LIMBS: (usize, usize) = (3, 3);

/// What a model is, by what stands in it.
pub fn found(robot: &Robot) -> Judged {
    let (subject, because) = match sign(robot) {
        Some(sign) => (Subject::Robot, sign),
        None => (Subject::Object, "nothing in it that only robots have".to_owned()),
    };
    Judged { subject, base: base(robot, subject), because }
}

/// What speaks for a robot, the plainest first.
fn sign(robot: &Robot) -> Option<String> {
    let named = |name: &str| {
        let lower = name.to_ascii_lowercase();
        NAMES.iter().any(|word| lower.contains(word))
    };
    let moving = || robot.joints.iter().filter(|j| j.kind.has_axis());
    let joint = moving().find(|j| named(&j.name)).map(|j| format!("joint `{}`", j.name));
    let link = || {
        let link = moving().map(|j| &robot.links[j.child]).find(|l| named(&l.name));
        link.map(|l| format!("link `{}`", l.name))
    };
    let chain = || {
        let longest = (0..robot.links.len()).map(|l| joints_above(robot, l)).max().unwrap_or(0);
        (longest >= CHAIN).then(|| format!("{longest} joints in a row"))
    };
    let limbs = || {
        let long = (0..robot.links.len()).filter(|&l| joints_above(robot, l) >= LIMBS.1);
        let first: BTreeSet<usize> = long.filter_map(|l| first_joint(robot, l)).collect();
        let count = first.len();
        (count >= LIMBS.0).then(|| format!("{count} limbs of {} joints in a row", LIMBS.1))
    };
    robot.beside.signs.first().cloned().or(joint).or_else(link).or_else(chain).or_else(limbs)
}

/// The first joint on the way from the root that moves a link.
fn first_joint(robot: &Robot, link: usize) -> Option<usize> {
    let (mut first, mut at) = (None, link);
    while let Some(j) = robot.joint_above(at) {
        if robot.joints[j].kind.has_axis() {
            first = Some(j);
        }
        at = robot.joints[j].parent;
    }
    first
}

/// How many joints move a link.
fn joints_above(robot: &Robot, link: usize) -> usize {
    let (mut count, mut at) = (0, link);
    while let Some(j) = robot.joint_above(at) {
        count += usize::from(robot.joints[j].kind.has_axis());
        at = robot.joints[j].parent;
    }
    count
}

/// Whether the base is tied to the world: as MJCF says, or by a root called `world`; robots that
/// neither float nor roll nor walk are bolted down.
fn base(robot: &Robot, subject: Subject) -> Base {
    let root = &robot.links[robot.root()];
    let floats = robot.joints.iter().any(|j| j.kind == Motion::Floating && j.held.is_none());
    match robot.beside.floats {
        Some(true) => Base::Free,
        Some(false) => Base::Fixed,
        None if floats => Base::Free,
        None if root.name == "world" && root.visuals.is_empty() => Base::Fixed,
        None => match subject {
            Subject::Object => Base::Free,
            Subject::Robot if goes(robot) => Base::Free,
            Subject::Robot => Base::Fixed,
        },
    }
}

/// Whether a robot rolls or walks: it has wheels, or two chains or more that reach below its root.
fn goes(robot: &Robot) -> bool {
    let words =
        ["wheel", "leg", "knee", "foot", "calf", "thigh", "track", "caster", "rotor", "prop"];
    let named = |name: &str| words.iter().any(|w| name.to_ascii_lowercase().contains(w));
    robot
        .joints
        .iter()
        .filter(|j| j.kind.has_axis())
        .any(|j| named(&j.name) || named(&robot.links[j.child].name))
}
