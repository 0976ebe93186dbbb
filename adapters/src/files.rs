//! Answers that lie on disk: a mesh file instead of a generator, a condition file instead of a VLM.

use std::path::{Path, PathBuf};

use object::mesh::UpAxis;
use object::{Condition, glb, obj};

use crate::bounded::read_limited;
use crate::{AdapterError, GeneratedMesh, ImageTo3d, KinematicQuestion, Photo, Vlm};

/// Largest mesh file, bytes.
pub const MAX_MESH_BYTES: u64 = 256 << 20;
/// Largest condition file, bytes.
pub const MAX_CONDITION_BYTES: u64 = 1 << 20;

/// A mesh somebody already has: GLB (y up), or OBJ (y up as generators write it).
#[derive(Clone, Debug)]
pub struct MeshFile {
    /// Where it lies.
    pub path: PathBuf,
}

impl ImageTo3d for MeshFile {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(format!("mesh-file/1 {}", digest(&self.path, MAX_MESH_BYTES)?))
    }

    fn generate(&self, _photo: &Photo, _seed: u64) -> Result<GeneratedMesh, AdapterError> {
        let path = self.path.display().to_string();
        let file = read_limited(&self.path, MAX_MESH_BYTES)?;
        let extension = self.path.extension().map(|e| e.to_ascii_lowercase());
        if extension.is_some_and(|e| e == "obj") {
            let text = String::from_utf8_lossy(&file);
            let mesh = obj::read(&text, UpAxis::Y);
            let mesh = mesh.map_err(|source| AdapterError::Obj { path, source })?;
            return Ok(GeneratedMesh { mesh, file, media_type: "model/obj".into() });
        }
        let mesh = glb::read(&file).map_err(|source| AdapterError::Glb { path, source })?;
        Ok(GeneratedMesh { mesh, file, media_type: "model/gltf-binary".into() })
    }
}

/// A condition somebody wrote.
#[derive(Clone, Debug)]
pub struct ConditionFile {
    /// Where it lies.
    pub path: PathBuf,
}

impl Vlm for ConditionFile {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(format!("condition-file/1 {}", digest(&self.path, MAX_CONDITION_BYTES)?))
    }

    fn propose(&self, question: &KinematicQuestion<'_>) -> Result<Condition, AdapterError> {
        let path = self.path.display().to_string();
        let bytes = read_limited(&self.path, MAX_CONDITION_BYTES)?;
        let text = String::from_utf8(bytes).map_err(|e| AdapterError::Format {
            path: path.clone(),
            expected: "JSON in UTF-8",
            found: e.to_string(),
        })?;
        let wrap = |source| AdapterError::Condition { path: path.clone(), source };
        let condition = Condition::from_json(&text).map_err(wrap)?;
        condition.check_points(question.mesh).map_err(wrap)?;
        Ok(condition)
    }
}

fn digest(path: &Path, limit: u64) -> Result<String, AdapterError> {
    Ok(trace::Digest::of(&read_limited(path, limit)?).to_string())
}
