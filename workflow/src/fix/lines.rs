//! Mesh files as we write them, and meshes as others are made of them.

use object::Mesh;
use object::obj::{ObjNormals, write};
use parry3d_f64::transformation::try_convex_hull;

/// A mesh as an OBJ file, without normals: pieces have corners, and engines take none.
pub(super) fn obj(mesh: &Mesh) -> Vec<u8> {
    write(mesh, ObjNormals::None).into_bytes()
}

/// The convex hull of a mesh.
///
/// # Errors
/// Why it has none.
pub(crate) fn hull(mesh: &Mesh) -> Result<Mesh, String> {
    let points = mesh.vertices().to_vec();
    // The hull builder is known to panic on some inputs.
    let built = std::panic::catch_unwind(move || try_convex_hull(&points));
    let built = built.map_err(|_| "the hull builder gave up on it".to_owned())?;
    let (points, faces) = built.map_err(|e| format!("it has no hull: {e:?}"))?;
    Mesh::new(points, faces).map_err(|e| e.to_string())
}
