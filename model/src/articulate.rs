//! The promise every articulator keeps: mesh and condition in, labelled parts and joints out.

use object::articulated::ObjectError;
use object::condition::ConditionError;
use object::kinematics::TreeError;
use object::mesh::MeshError;
use object::{ArticulatedObject, Condition, Confidence, Mesh};
use serde::{Deserialize, Serialize};

use crate::classic::learned::pack::PackError;

/// Labels every face with a part and finds an axis and a range for every joint.
///
/// Promises:
///
/// - The tree is the condition's, less the parts that got no face. Each of those is reported in a
///   [`Note`], and its children hang on the nearest ancestor that is left.
/// - Joint kinds are the condition's.
/// - Every range includes the rest pose.
/// - The same mesh, condition and seed give the same result on any number of threads.
pub trait Articulate {
    /// Name and version, part of the stage key: changes whenever results may.
    fn identity(&self) -> String;

    /// Articulates one object.
    ///
    /// # Errors
    /// [`ArticulateError`] when the condition does not fit the mesh or nothing can be labelled.
    fn articulate(
        &self,
        mesh: &Mesh,
        condition: &Condition,
        seed: u64,
    ) -> Result<Articulation, ArticulateError>;
}

/// An articulated object and what was noticed on the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Articulation {
    /// The object, in the mesh's own unit.
    pub object: ArticulatedObject,
    /// For each part of the condition, its index in the object; `None` if it got no face.
    pub part_of_condition: Vec<Option<usize>>,
    /// Losses and doubts, in order of part.
    pub notes: Vec<Note>,
    /// How likely all of it is right; nothing where whoever made it does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<Confidence>,
}

/// Something a person should know about one part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// The part's name.
    pub part: String,
    /// What happened, in one sentence.
    pub message: String,
    /// Whether something asked for is missing from the result.
    pub loss: bool,
}

/// Why an object could not be articulated.
#[derive(Debug, thiserror::Error)]
pub enum ArticulateError {
    /// The condition does not fit the mesh.
    #[error(transparent)]
    Condition(#[from] ConditionError),
    /// No part but the root got a face.
    #[error("no part besides the base got a face of the mesh: {0}")]
    NothingLabelled(String),
    /// The base is left without a face.
    #[error("no face of the mesh is left for the base `{0}`: other parts have them all")]
    BaseLost(String),
    /// A joint was asked about that is not there.
    #[error(
        "part {part} of the condition, counted from 0, has no joint {joint} with an axis and a face to move: \
         ask about a part that got a face, a joint of its list, and an axis that is not zero"
    )]
    NoJoint {
        /// The part's place in the condition's tree.
        part: usize,
        /// Which of its joints.
        joint: usize,
    },
    /// What was learned cannot be read.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// The network gave no answer.
    #[error("the articulation network: {0}")]
    Network(String),
    /// One side of the surface is no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The surviving parts are not a tree.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// The result breaks a rule of articulated objects.
    #[error(transparent)]
    Object(#[from] ObjectError),
}
