//! What is judged: an object or a robot, on a fixed or a free base; as asked, or as found.
//!
//! ```
//! use sim_check::read::load::from_text;
//! use sim_check::{CheckOptions, Subject, subject};
//! let text = r#"<robot name="arm"><link name="world"/><link name="upper_arm"/>
//!   <joint name="shoulder" type="continuous"><parent link="world"/><child link="upper_arm"/></joint>
//!   </robot>"#;
//! let robot = from_text(text, ".".as_ref(), &CheckOptions::default()).robot.unwrap();
//! let found = subject::found(&robot);
//! assert_eq!((found.subject, found.because.as_str()), (Subject::Robot, "joint `shoulder`"));
//! ```

use serde::{Deserialize, Serialize};

use crate::robot::{Motion, Robot};

/// What a model is of, and so what is asked of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Subject {
    /// An asset: it must rest on the floor, have labels, bring no scale along, and no two of its
    /// parts may overlap anywhere.
    #[default]
    Object,
    /// A robot: its drives hold it, and its neighbours may touch.
    Robot,
}

/// Whether the root is tied to the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Base {
    /// It is.
    Fixed,
    /// It may fall.
    Free,
}

/// What a model was judged as, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// An object or a robot.
    #[serde(rename = "as")]
    pub subject: Subject,
    /// Fixed or free.
    pub base: Base,
    /// What spoke for it.
    pub because: String,
}

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

impl Subject {
    /// Its name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "object",
            Self::Robot => "robot",
        }
    }
}

impl Base {
    /// Its name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Free => "free",
        }
    }
}

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
    robot.beside.signs.first().cloned().or(joint).or_else(link).or_else(chain)
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
