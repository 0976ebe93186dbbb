//! The promise of whoever makes a mesh from a photo.

use object::{Mesh, meshfile};
use serde::{Deserialize, Serialize};

use crate::net::redactor::Redactor;
use crate::{AdapterError, Photo};

/// Makes a mesh from a photo.
///
/// Promise: the mesh is in the object frame (z up, front to −y), its faces in the order of the
/// file it came in; the file is kept as it came; the same photo, seed and identity may give
/// another mesh only if the service behind is not repeatable, which its identity then says.
pub trait ImageTo3d: Send + Sync {
    /// Who answers: provider, model and version, or the digest of a file. Part of the stage key.
    ///
    /// # Errors
    /// [`AdapterError`] when even that cannot be told, such as for a file that is not there.
    fn identity(&self) -> Result<String, AdapterError>;

    /// Makes the mesh.
    ///
    /// # Errors
    /// [`AdapterError`], naming the file or service, the rule and what was found.
    fn generate(&self, photo: &Photo, seed: u64) -> Result<GeneratedMesh, AdapterError>;
}

/// A mesh and the file it came in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GeneratedMesh {
    /// The surface, object frame.
    pub mesh: Mesh,
    /// The file's bytes: GLB or OBJ, y up, with all that it needs in it.
    pub file: Vec<u8>,
    /// `model/gltf-binary` or `model/obj`.
    pub media_type: String,
}

impl GeneratedMesh {
    /// The same from a file that repeats no key of ours.
    ///
    /// # Errors
    /// [`AdapterError`] when the file cannot be read once the key is taken out.
    pub(crate) fn without(self, redactor: &Redactor) -> Result<Self, AdapterError> {
        let file = redactor.body(self.file.clone());
        if file == self.file {
            return Ok(self);
        }
        let path = "the mesh without a key that it repeated".into();
        let mesh = meshfile::read(&file).map_err(|e| AdapterError::of_mesh(path, e))?;
        Ok(Self { mesh, file, ..self })
    }
}
