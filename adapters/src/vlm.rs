//! The promise of whoever says what an object's parts are and how they move.

use object::{Condition, Mesh};

use crate::{AdapterError, Photo};

/// Answers questions about pictures of one object.
///
/// Promise: a condition it returns is a proved tree whose prompt points lie on the mesh; it never
/// fills a gap by inventing (a part it cannot see has no point); what it cannot answer is an error.
pub trait Vlm: Send + Sync {
    /// Who answers: provider, model and version, or the digest of a file. Part of the stage key.
    ///
    /// # Errors
    /// [`AdapterError`] when even that cannot be told, such as for a file that is not there.
    fn identity(&self) -> Result<String, AdapterError>;

    /// Which parts the object has, how they hang together and move, and where they are.
    ///
    /// # Errors
    /// [`AdapterError`], naming the file or service, the rule and what was found.
    fn propose(&self, question: &KinematicQuestion<'_>) -> Result<Condition, AdapterError>;
}

/// Everything there is to see of an object.
#[derive(Clone, Copy, Debug)]
pub struct KinematicQuestion<'a> {
    /// The photo it all began with.
    pub photo: &'a Photo,
    /// The generated surface.
    pub mesh: &'a Mesh,
    /// Pictures of it.
    pub views: &'a [RenderedView],
}

/// One picture of the mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RenderedView {
    /// Which side, such as `front_right`.
    pub name: String,
    /// The picture, PNG.
    pub png: Vec<u8>,
}
