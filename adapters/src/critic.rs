//! The promise of whoever looks at an articulated object and says which joints look wrong.

use object::ArticulatedObject;
use serde::{Deserialize, Serialize};
use trace::Digest;

use crate::{AdapterError, Photo, RenderedView};

/// Longest reason of a remark, characters, with the `…` at the end of one that was cut.
pub const MAX_REASON: usize = 301;

/// Looks at pictures of an object in motion.
///
/// Promise: it flags and changes nothing. There is one remark for each part that moves, in the order
/// of parts, and none for any other; what it cannot judge is an error and never a remark that all is
/// well.
pub trait Critic: Send + Sync {
    /// Who looks: provider, model and version. Part of the stage key.
    ///
    /// # Errors
    /// [`AdapterError`] when even that cannot be told.
    fn identity(&self) -> Result<String, AdapterError>;

    /// What looks wrong about each part that moves.
    ///
    /// # Errors
    /// [`AdapterError`], naming the service, the rule and what was found.
    fn criticise(&self, question: &CritiqueQuestion<'_>) -> Result<Vec<Remark>, AdapterError>;
}

/// Everything there is to see of an object in motion.
#[derive(Clone, Copy, Debug)]
pub struct CritiqueQuestion<'a> {
    /// The photo it all began with.
    pub photo: &'a Photo,
    /// The object, in the mesh's own unit.
    pub object: &'a ArticulatedObject,
    /// Digest of the file the object is kept in; the calls are kept under it.
    pub digest: &'a Digest,
    /// Pictures of it: at rest and with its joints at their ends.
    pub views: &'a [RenderedView],
}

/// What was seen of one part that moves.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Remark {
    /// The part's name.
    pub part: String,
    /// The first thing that looks wrong.
    pub fault: JointFault,
    /// Why, on one line of at most [`MAX_REASON`] characters; may be empty where nothing is wrong.
    pub reason: String,
}

impl Remark {
    /// Whether anything looks wrong.
    pub fn is_flag(&self) -> bool {
        self.fault != JointFault::None
    }
}

/// What can look wrong about a joint, the worst first: what comes later is judged only where nothing
/// before it is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointFault {
    /// It slides where it should turn, or the other way round.
    JointType,
    /// It moves in another direction.
    Axis,
    /// It turns about a line in another place.
    Origin,
    /// It moves too far or not far enough.
    Limit,
    /// Nothing.
    None,
}

impl JointFault {
    /// Every word there is.
    pub const WORDS: [&str; 5] = ["joint_type", "axis", "origin", "limit", "none"];

    /// What it is about, in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::JointType => "the type of the joint",
            Self::Axis => "the direction of the axis",
            Self::Origin => "the place of the axis",
            Self::Limit => "the range",
            Self::None => "nothing",
        }
    }
}

/// What became of a critique that was asked for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Critique {
    /// What was seen.
    #[serde(rename = "remarks")]
    Given(Vec<Remark>),
    /// Why there is none.
    #[serde(rename = "no_critique")]
    Lost(String),
}
