//! PLY file → mesh, text or binary of either byte order: positions, faces and colours of vertices.
//!
//! ```
//! let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
//!             property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
//!             end_header\n0 0 0\n2 0 0\n0 3 0\n3 0 1 2\n";
//! let (mesh, left_out) = object::ply::read(text.as_bytes(), object::mesh::UpAxis::Z)?;
//! assert_eq!((mesh.area(0), left_out.len()), (3.0, 0));
//! # Ok::<(), object::ply::PlyError>(())
//! ```

mod body;
mod error;
mod header;

use glamx::DVec3;

pub use error::PlyError;

use self::body::{Body, PlyMesh};
use self::header::Header;
use crate::mesh::{FileFrame, Mesh, UpAxis};

/// Reads a PLY whose `up` axis is known; coordinates are taken as metres. Faces come out in file order; a
/// polygon becomes a fan from its first corner. Colours are sRGB. Says, too, what was left out.
///
/// # Errors
/// [`PlyError`], the first broken rule.
pub fn read(bytes: &[u8], up: UpAxis) -> Result<(Mesh, Vec<String>), PlyError> {
    let (header, body) = Header::parse(bytes)?;
    header.check()?;
    let PlyMesh { vertices, colours, faces } = Body::new(&header, body).read()?;
    let frame = FileFrame { up };
    let vertices: Vec<DVec3> = vertices.into_iter().map(|p| frame.point_to_object(p)).collect();
    let mesh = Mesh::new(vertices, faces)?.with_frame(frame);
    Ok((mesh.with_colours(colours)?, header.left_out()))
}

#[cfg(test)]
mod tests;
