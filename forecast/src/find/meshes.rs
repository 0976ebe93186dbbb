//! Meshes: where they stand, in which format, how they are made.

use crate::find::place::at_shape;
use crate::read::mesh::{Here, Mesh, Uri};
use crate::read::urdf::{Geometry, Shape, Urdf};
use crate::rule::Place;

fn of(shape: &Shape) -> Option<&Mesh> {
    match &shape.geometry {
        Geometry::Mesh(mesh) => Some(mesh),
        _ => None,
    }
}

fn felt(urdf: &Urdf, is: impl Fn(&Mesh) -> bool) -> Vec<Place> {
    let mut places = Vec::new();
    for link in &urdf.links {
        for shape in &link.collisions {
            places.extend(
                of(shape)
                    .filter(|m| is(m))
                    .map(|m| at_shape("collision", link, shape, &m.filename)),
            );
        }
    }
    places
}

fn seen(urdf: &Urdf, is: impl Fn(&Mesh) -> bool) -> Vec<Place> {
    let mut places = Vec::new();
    for link in &urdf.links {
        for shape in &link.visuals {
            places.extend(
                of(shape).filter(|m| is(m)).map(|m| at_shape("visual", link, shape, &m.filename)),
            );
        }
    }
    places
}

fn any(urdf: &Urdf, is: impl Fn(&Mesh) -> bool) -> Vec<Place> {
    let mut places = felt(urdf, &is);
    places.extend(seen(urdf, &is));
    places
}

fn is_one_of(mesh: &Mesh, extensions: &[&str]) -> bool {
    extensions.contains(&mesh.extension.as_str())
}

fn is_package(mesh: &Mesh) -> bool {
    matches!(mesh.uri, Uri::Package(_))
}

fn is_missing(mesh: &Mesh) -> bool {
    mesh.here == Here::No
}

/// Collisions that MuJoCo has no decoder for.
pub(crate) fn felt_unknown_to_mujoco(urdf: &Urdf) -> Vec<Place> {
    felt(urdf, |m| is_one_of(m, &["glb", "gltf", "dae"]))
}

/// Meshes that PyBullet refuses by their extension.
pub(crate) fn unknown_to_pybullet(urdf: &Urdf) -> Vec<Place> {
    any(urdf, |m| is_one_of(m, &["glb", "gltf", "ply"]))
}

/// Collisions that Drake makes no hull of.
pub(crate) fn felt_unknown_to_drake(urdf: &Urdf) -> Vec<Place> {
    felt(urdf, |m| is_one_of(m, &["glb", "stl", "dae"]))
}

/// glTF meshes.
pub(crate) fn gltf(urdf: &Urdf) -> Vec<Place> {
    any(urdf, |m| is_one_of(m, &["glb", "gltf"]))
}

/// Collisions named by a URI.
pub(crate) fn felt_by_uri(urdf: &Urdf) -> Vec<Place> {
    felt(urdf, |m| m.uri != Uri::Plain)
}

/// Meshes named by a URI.
pub(crate) fn by_uri(urdf: &Urdf) -> Vec<Place> {
    any(urdf, |m| m.uri != Uri::Plain)
}

/// Meshes named by a package.
pub(crate) fn by_package(urdf: &Urdf) -> Vec<Place> {
    any(urdf, is_package)
}

/// Meshes named by `file://`.
pub(crate) fn by_file_uri(urdf: &Urdf) -> Vec<Place> {
    any(urdf, |m| m.uri == Uri::File)
}

/// Meshes named by a package, but for Drake's own.
pub(crate) fn by_foreign_package(urdf: &Urdf) -> Vec<Place> {
    let own = ["drake", "drake_models"];
    any(urdf, |m| matches!(&m.uri, Uri::Package(name) if !own.contains(&name.as_str())))
}

/// Meshes named by a package that does not stand beside the file.
pub(crate) fn by_package_elsewhere(urdf: &Urdf) -> Vec<Place> {
    any(urdf, |m| is_package(m) && m.here != Here::Yes)
}

/// Collisions that are not there.
pub(crate) fn felt_missing(urdf: &Urdf) -> Vec<Place> {
    felt(urdf, |m| is_missing(m) && m.uri == Uri::Plain)
}

/// Meshes that are not there.
pub(crate) fn missing(urdf: &Urdf) -> Vec<Place> {
    any(urdf, |m| is_missing(m) && m.uri == Uri::Plain)
}

/// Collisions that SAPIEN does not find: of packages elsewhere, and by `file://`.
pub(crate) fn lost_to_sapien(urdf: &Urdf) -> Vec<Place> {
    felt(urdf, |m| m.uri == Uri::File || (is_package(m) && m.here != Here::Yes))
}

/// Collisions in STL written as text.
pub(crate) fn felt_in_text(urdf: &Urdf) -> Vec<Place> {
    felt(urdf, |m| m.is_text)
}

/// Collisions in STL with more triangles than MuJoCo's decoder takes, which says so.
pub(crate) fn felt_in_huge_stl(urdf: &Urdf) -> Vec<Place> {
    felt(urdf, |m| m.extension == "stl" && m.faces > 200_000)
}

/// Collisions all in one plane.
pub(crate) fn felt_flat(urdf: &Urdf) -> Vec<Place> {
    felt(urdf, |m| m.flat)
}

/// Collisions with dents.
pub(crate) fn felt_concave(urdf: &Urdf) -> Vec<Place> {
    felt(urdf, |m| m.concave)
}

/// Collisions of more triangles than Genesis leaves: `decimate_face_num` is 500.
pub(crate) fn felt_of_many_faces(urdf: &Urdf) -> Vec<Place> {
    felt(urdf, |m| m.faces > 500)
}

/// Visuals with faces of several materials.
pub(crate) fn seen_in_colours(urdf: &Urdf) -> Vec<Place> {
    seen(urdf, |m| m.materials > 1)
}
