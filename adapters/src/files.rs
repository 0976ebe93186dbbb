//! Answers that lie on disk: a mesh file instead of a generator, a condition file instead of a VLM.

use std::path::{Path, PathBuf};

use guard::folder::{Caps, Folder};
use object::beside::Found;
use object::mesh::UpAxis;
use object::meshfile::{self, Format, MeshFileError, Taken};
use object::{Condition, Mesh};

use crate::bounded::read_limited;
use crate::{AdapterError, GeneratedMesh, ImageTo3d, KinematicQuestion, Photo, Vlm};

/// Largest mesh file, bytes.
pub const MAX_MESH_BYTES: u64 = 256 << 20;
/// Largest condition file, bytes.
pub const MAX_CONDITION_BYTES: u64 = 1 << 20;

/// A mesh somebody already has, in any format that [`meshfile`] reads, and the files beside it that it names.
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

    /// Reads it with what lies beside it, as one file; one with z up is set upright first, so that what is
    /// kept of it has y up.
    ///
    /// # Errors
    /// [`AdapterError`], naming the file, the rule and what was found.
    pub fn read(&self) -> Result<GeneratedMesh, AdapterError> {
        self.read_as(&self.path.display().to_string())
    }

    /// The same of a file that errors call otherwise.
    pub(crate) fn read_as(&self, named: &str) -> Result<GeneratedMesh, AdapterError> {
        let bytes = read_limited(&self.path, MAX_MESH_BYTES)?;
        let beside = &mut |name: &str| self.file_beside(name);
        let taken = meshfile::take_in(bytes, (self.is_obj(), self.up), beside);
        let Taken { mesh, file, media_type } =
            taken.map_err(|e| AdapterError::of_mesh(named.into(), e))?;
        Ok(GeneratedMesh { mesh, file, media_type: media_type.into() })
    }

    fn is_obj(&self) -> bool {
        self.path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("obj"))
    }

    fn refused(&self, error: MeshFileError) -> AdapterError {
        AdapterError::of_mesh(self.path.display().to_string(), error)
    }

    /// A file that the mesh names, from its folder alone. Where a path is of another machine, or leads
    /// elsewhere, a file of that name beside the mesh is meant.
    fn file_beside(&self, name: &str) -> Result<Found, String> {
        let above = self.path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let caps = Caps { file: MAX_MESH_BYTES, all: MAX_MESH_BYTES, ..Caps::default() };
        let folder = Folder::open(above.unwrap_or(Path::new(".")), caps);
        let folder = folder.map_err(|refused| refused.to_string())?;
        let name = name.replace('\\', "/");
        let last = name.rsplit('/').next().unwrap_or_default();
        let mut refused = None;
        for name in [name.as_str(), last] {
            match folder.read(Path::new(name)) {
                Ok(bytes) => return Ok(Found { name: name.into(), bytes }),
                Err(why) => refused = refused.or(Some(why)),
            }
        }
        Err(match refused {
            Some(why) if !why.is_absence() => why.to_string(),
            _ => "is not there".into(),
        })
    }
}

impl ImageTo3d for MeshFile {
    fn identity(&self) -> Result<String, AdapterError> {
        let up = if self.up == UpAxis::Z { " z up" } else { "" };
        let bytes = read_limited(&self.path, MAX_MESH_BYTES)?;
        let digest = trace::Digest::of(&bytes);
        // Of several files, what came of them says whether one of them is another.
        let format = meshfile::format(&bytes, self.is_obj());
        let of_several = matches!(format, Format::Gltf | Format::Obj | Format::Usd);
        let named = if of_several {
            let beside = &mut |name: &str| self.file_beside(name);
            let whole = meshfile::in_one_file(bytes, (self.is_obj(), UpAxis::Y), beside);
            trace::Digest::of(&whole.map_err(|e| self.refused(e))?)
        } else {
            digest
        };
        Ok(format!("mesh-file/1 {named}{up}"))
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
