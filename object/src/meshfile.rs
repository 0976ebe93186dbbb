//! A mesh file of any format that is read here → one file that says all and goes on as it is: GLB or OBJ.
//!
//! What a file is, its first bytes say, not its name. [`take_in`] reads what lies beside it, too; [`read`] and
//! [`read_noted`] read what came of that.

mod format;

pub use format::{Format, format};

use crate::beside::Beside;
use crate::glb::{self, GlbError};
use crate::mesh::{Mesh, UpAxis};
use crate::obj::{self, ObjError};
use crate::ply::{self, PlyError};
use crate::reading::Reading;
use crate::stl::{self, StlError};
use crate::usd::{self, UsdError};
use crate::{gltf, upright};

/// Formats that are read, for messages.
pub const FORMATS: &str = "GLB, glTF, OBJ, STL, PLY or USD";

/// Why a file gives no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshFileError {
    /// A GLB, or a glTF of several files.
    #[error(transparent)]
    Glb(#[from] GlbError),
    /// An OBJ.
    #[error(transparent)]
    Obj(#[from] ObjError),
    /// An STL.
    #[error("STL: {0}")]
    Stl(#[from] StlError),
    /// A PLY.
    #[error(transparent)]
    Ply(#[from] PlyError),
    /// A USD.
    #[error(transparent)]
    Usd(#[from] UsdError),
    /// None of these, and what it is instead, with what to do about it.
    #[error("expected a mesh as {FORMATS}, found {0}")]
    Foreign(String),
}

/// A mesh in one file.
#[derive(Clone, Debug, PartialEq)]
pub struct Taken {
    /// The surface, with the colours that its textures have at the vertices.
    pub mesh: Mesh,
    /// The file: GLB, or OBJ with what it names taken in; y up.
    pub file: Vec<u8>,
    /// Its media type.
    pub media_type: &'static str,
}

/// Takes in a mesh file with what lies beside it. `is_obj` says whether its name ends so, for an OBJ need not
/// begin in any way; `up` is its up axis. The same files give the same bytes.
///
/// # Errors
/// [`MeshFileError`], the first broken rule.
pub fn take_in(
    bytes: Vec<u8>,
    (is_obj, up): (bool, UpAxis),
    beside: Beside<'_>,
) -> Result<Taken, MeshFileError> {
    let file = in_one_file(bytes, (is_obj, up), beside)?;
    let mesh = read(&file)?;
    let media_type = if is_glb(&file) { "model/gltf-binary" } else { "model/obj" };
    Ok(Taken { mesh, file, media_type })
}

/// The file alone that [`take_in`] gives, of which the mesh may still be refused.
///
/// # Errors
/// [`MeshFileError`], the first broken rule.
pub fn in_one_file(
    bytes: Vec<u8>,
    (is_obj, up): (bool, UpAxis),
    beside: Beside<'_>,
) -> Result<Vec<u8>, MeshFileError> {
    let turned = |glb: Vec<u8>| match up {
        UpAxis::Y => Ok(glb),
        UpAxis::Z => Ok(upright::glb(&glb)?),
    };
    match format(&bytes, is_obj) {
        Format::Glb => turned(bytes),
        Format::Gltf => turned(gltf::to_glb(&bytes, beside)?),
        Format::Obj => {
            let text = String::from_utf8_lossy(&bytes);
            let text = if up == UpAxis::Z { upright::obj(&text).into() } else { text };
            Ok(obj::contained(&text, beside).into_bytes())
        }
        Format::Stl => Ok(glb::write(&stl::read_shared(&bytes, up)?)),
        Format::Ply => {
            let (mesh, left_out) = ply::read(&bytes, up)?;
            Ok(gltf::noted(glb::write(&mesh), &left_out)?)
        }
        Format::Usd => {
            let Reading { mesh, appearance, notes } = usd::read(bytes, up, beside)?;
            match appearance {
                Some(appearance) => Ok(glb::write_dressed(&mesh, &appearance, &notes)),
                None => Ok(gltf::noted(glb::write(&mesh), &notes)?),
            }
        }
        Format::Foreign(what) => Err(MeshFileError::Foreign(what)),
    }
}

/// The mesh of a file that [`take_in`] gave, with the colours that textures have at the vertices.
///
/// # Errors
/// [`MeshFileError`], the first broken rule.
pub fn read(file: &[u8]) -> Result<Mesh, MeshFileError> {
    if is_glb(file) {
        return Ok(glb::read(file)?);
    }
    Ok(read_noted(file)?.mesh)
}

/// Like [`read`], and says how the surface looks and what was left out.
///
/// # Errors
/// [`MeshFileError`], the first broken rule.
pub fn read_noted(file: &[u8]) -> Result<Reading, MeshFileError> {
    if is_glb(file) {
        return Ok(glb::read_noted(file)?);
    }
    let reading = obj::read_noted(&String::from_utf8_lossy(file), UpAxis::Y)?;
    let Some(appearance) = &reading.appearance else { return Ok(reading) };
    let colours = appearance.colours_of(&reading.mesh);
    let mesh = reading.mesh.with_colours(Some(colours)).map_err(ObjError::from)?;
    Ok(Reading { mesh, ..reading })
}

fn is_glb(file: &[u8]) -> bool {
    file.starts_with(b"glTF")
}

#[cfg(test)]
mod tests;
