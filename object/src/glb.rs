//! GLB file ↔ mesh: generators' files as they really are, judged before any geometry is touched.
//!
//! [`read`] bakes every node's transform, joins all primitives in the order of the file, unpacks
//! Draco, meshopt and quantised data, and turns glTF's y-up frame into the object frame. Faces come
//! out in index order, degenerate ones included, so labels per triangle keep their meaning. All
//! counts, ranges and nestings are checked first; no bytes, however hostile, make it panic.

mod accessor;
mod affine;
mod buffers;
mod container;
mod decoding;
mod document;
mod dress;
mod error;
mod look;
mod materials;
mod paint;
mod primitive;
mod scene;
#[cfg(test)]
mod tests;
mod tint;
mod write;

pub use crate::appearance::{MAX_IMAGE_SIDE, MAX_PIXELS};
pub use crate::reading::Reading;
pub(crate) use container::check_json;
pub use container::{MAX_JSON, MAX_JSON_DEPTH};
pub use decoding::MAX_DECODED_BYTES;
pub(crate) use document::LEFT_OUT;
pub use document::{MAX_MESHES, MAX_NODE_DEPTH, MAX_NODES};
pub use dress::{Textures, write_dressed};
pub use error::GlbError;
pub use paint::{linear_of_srgb, srgb_of_linear};
pub(crate) use write::of_chunks;
pub use write::{BinaryChunk, Faces, write};

use self::look::Looks;
use crate::mesh::Mesh;

/// The JSON of a GLB file and its binary chunk, as they stand there.
///
/// # Errors
/// [`GlbError`], the first broken rule.
pub(crate) fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), GlbError> {
    let container = container::Container::parse(bytes)?;
    Ok((container.json, container.bin))
}

/// Reads a GLB file into the object frame.
///
/// # Errors
/// [`GlbError`], the first broken rule.
pub fn read(bytes: &[u8]) -> Result<Mesh, GlbError> {
    Ok(read_with(bytes, Looks::Colours)?.mesh)
}

/// Like [`read`], and says how the surface looks and what of the file was left out.
///
/// # Errors
/// [`GlbError`], the first broken rule.
pub fn read_noted(bytes: &[u8]) -> Result<Reading, GlbError> {
    read_with(bytes, Looks::Materials)
}

fn read_with(bytes: &[u8], looks: Looks) -> Result<Reading, GlbError> {
    let container = container::Container::parse(bytes)?;
    let document = document::Document::parse(container.json)?;
    let buffers = buffers::Buffers::load(&document, container.bin, bytes.len())?;
    scene::read(accessor::Accessors { document: &document, buffers: &buffers }, looks)
}
