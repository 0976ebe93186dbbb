//! Answers that lie on disk: a mesh file instead of a generator, a condition file instead of a VLM.

use std::path::{Path, PathBuf};

use object::mesh::UpAxis;
use object::{Condition, Mesh, glb, obj, upright};

use crate::bounded::read_limited;
use crate::formats;
use crate::{AdapterError, GeneratedMesh, ImageTo3d, KinematicQuestion, Photo, Vlm};

/// Largest mesh file, bytes.
pub const MAX_MESH_BYTES: u64 = 256 << 20;
/// Largest condition file, bytes.
pub const MAX_CONDITION_BYTES: u64 = 1 << 20;

/// A mesh somebody already has: GLB or OBJ.
#[derive(Clone, Debug, Default)]
pub struct MeshFile {
    /// Where it lies.
    pub path: PathBuf,
    /// Its up axis; y, as glTF demands and generators write it, unless somebody says otherwise.
    pub up: UpAxis,
}

impl MeshFile {
    /// A mesh beside whose condition the up axis is said, for both.
    pub fn beside(path: PathBuf, condition: Option<&ConditionFile>) -> Self {
        let said = condition.and_then(|file| file.read().ok()).map(|c| c.frame.up);
        Self { path, up: said.unwrap_or_default() }
    }

    /// Reads it; one with z up is set upright first, so that what is kept of it has y up.
    ///
    /// # Errors
    /// [`AdapterError`], naming the file, the rule and what was found.
    pub fn read(&self) -> Result<GeneratedMesh, AdapterError> {
        let path = self.path.display().to_string();
        let mut file = read_limited(&self.path, MAX_MESH_BYTES)?;
        let extension = self.path.extension().map(|e| e.to_ascii_lowercase());
        if extension.is_some_and(|e| e == "obj") {
            if self.up == UpAxis::Z {
                file = upright::obj(&String::from_utf8_lossy(&file)).into_bytes();
            }
            let text = String::from_utf8_lossy(&file);
            let mesh = obj::read(&text, UpAxis::Y);
            let mesh = mesh.map_err(|source| AdapterError::Obj { path, source })?;
            return Ok(GeneratedMesh { mesh, file, media_type: "model/obj".into() });
        }
        if let Some(found) = formats::of_mesh(&file) {
            let expected =
                "a mesh as GLB or OBJ (other formats are converted by Blender's export, for one)";
            return Err(AdapterError::Format { path, expected, found: found.into() });
        }
        let glb = |source| AdapterError::Glb { path: path.clone(), source };
        if self.up == UpAxis::Z {
            file = upright::glb(&file).map_err(glb)?;
        }
        let mesh = glb::read(&file).map_err(glb)?;
        Ok(GeneratedMesh { mesh, file, media_type: "model/gltf-binary".into() })
    }
}

impl ImageTo3d for MeshFile {
    fn identity(&self) -> Result<String, AdapterError> {
        let up = if self.up == UpAxis::Z { " z up" } else { "" };
        Ok(format!("mesh-file/1 {}{up}", digest(&self.path, MAX_MESH_BYTES)?))
    }

    fn generate(&self, _photo: &Photo, _seed: u64) -> Result<GeneratedMesh, AdapterError> {
        self.read()
    }
}

/// A condition somebody wrote.
#[derive(Clone, Debug, Default)]
pub struct ConditionFile {
    /// Where it lies.
    pub path: PathBuf,
    /// Whether points that lie off the mesh are moved to the nearest on it, instead of being refused.
    pub snap: bool,
    /// The up axis of a file that does not say.
    pub up: UpAxis,
}

impl ConditionFile {
    /// Reads it, whatever its points lie on.
    ///
    /// # Errors
    /// [`AdapterError`], naming the file and everything that is wrong with it.
    pub fn read(&self) -> Result<Condition, AdapterError> {
        let path = self.path.display().to_string();
        let bytes = read_limited(&self.path, MAX_CONDITION_BYTES)?;
        let text = String::from_utf8(bytes).map_err(|e| AdapterError::Format {
            path: path.clone(),
            expected: "JSON in UTF-8",
            found: e.to_string(),
        })?;
        Condition::from_json_with(&text, self.up)
            .map_err(|source| AdapterError::Condition { path, source })
    }

    /// Reads it as a condition of a mesh, and says how many of its points were moved.
    ///
    /// # Errors
    /// [`AdapterError`], naming the file and everything that is wrong with it.
    pub fn of(&self, mesh: &Mesh) -> Result<(Condition, usize), AdapterError> {
        let condition = self.read()?;
        let (condition, moved) = match self.snap {
            true => condition.snapped(mesh),
            false => (condition, 0),
        };
        let path = self.path.display().to_string();
        let wrong = |source| AdapterError::Condition { path, source };
        condition.check_points(mesh).map_err(wrong)?;
        Ok((condition, moved))
    }
}

impl Vlm for ConditionFile {
    fn identity(&self) -> Result<String, AdapterError> {
        let snap = if self.snap { " snapped" } else { "" };
        let up = if self.up == UpAxis::Z { " z up" } else { "" };
        Ok(format!("condition-file/1 {}{snap}{up}", digest(&self.path, MAX_CONDITION_BYTES)?))
    }

    fn propose(&self, question: &KinematicQuestion<'_>) -> Result<Condition, AdapterError> {
        Ok(self.of(question.mesh)?.0)
    }
}

fn digest(path: &Path, limit: u64) -> Result<String, AdapterError> {
    Ok(trace::Digest::of(&read_limited(path, limit)?).to_string())
}
