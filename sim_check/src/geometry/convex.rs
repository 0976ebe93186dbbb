//! Surfaces that are convex already: most collision pieces are the hull of their own points.

use glamx::DVec3;
use object::Mesh;

/// How far a point may lie beyond a face, as a share of the surface's diagonal.
const FLUSH: f64 = 1e-9;
/// A surface of less volume than this times its diagonal cubed is left to the hull builder.
const THIN: f64 = 1e-9;
/// Faces whose normals agree this well (within 0.03 degrees) are one to the physics engine.
const LEVEL: f64 = 1.0 - 1e-7;
/// Most products of a face and a point spent to find out.
const LIMIT: usize = 1_000_000;

/// The points that a mesh's faces use and its faces, where the mesh is the hull of those points.
/// Such a mesh is closed and in one piece, and its faces look outward. No point lies beyond a face,
/// or amid faces of one plane. `None` where it is not, or where that is not cheaply seen.
pub(crate) fn own_hull(mesh: &Mesh) -> Option<(Vec<DVec3>, Vec<[u32; 3]>)> {
    let (points, faces) = used(mesh);
    if points.len() * faces.len() > LIMIT || !is_sphere(points.len(), &faces) {
        return None;
    }
    let diagonal = mesh.bounds().diagonal();
    let normals: Vec<DVec3> = faces.iter().map(|f| normal(f, &points)).collect::<Option<_>>()?;
    let has_all_behind = |(face, normal): (&[u32; 3], &DVec3)| {
        let reach = normal.dot(points[face[0] as usize]) + FLUSH * diagonal;
        points.iter().all(|p| normal.dot(*p) <= reach)
    };
    let is_hull = mesh.signed_volume() > THIN * diagonal.powi(3)
        && faces.iter().zip(&normals).all(has_all_behind)
        && is_creased(points.len(), &faces, &normals);
    is_hull.then_some((points, faces))
}

/// The points that faces use, in order, and the faces made of them.
fn used(mesh: &Mesh) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    const UNUSED: u32 = u32::MAX;
    let mut index = vec![UNUSED; mesh.vertices().len()];
    mesh.faces().iter().flatten().for_each(|&v| index[v as usize] = 0);
    let mut points = Vec::with_capacity(index.len());
    for (v, index) in index.iter_mut().enumerate().filter(|(_, i)| **i != UNUSED) {
        *index = points.len() as u32;
        points.push(mesh.vertices()[v]);
    }
    let faces = mesh.faces().iter().map(|f| f.map(|v| index[v as usize])).collect();
    (points, faces)
}

/// Whether faces hang together as those of a ball do: each edge once each way, and Euler's number.
fn is_sphere(points: usize, faces: &[[u32; 3]]) -> bool {
    let of_face = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let mut edges: Vec<[u32; 2]> = faces.iter().flat_map(of_face).collect();
    edges.sort_unstable();
    let is_once = edges.windows(2).all(|pair| pair[0] != pair[1]);
    let is_paired = |&[a, b]: &[u32; 2]| edges.binary_search(&[b, a]).is_ok();
    is_once && edges.iter().all(is_paired) && points + faces.len() == edges.len() / 2 + 2
}

/// Outward, where the face is large enough to have a direction.
fn normal(face: &[u32; 3], points: &[DVec3]) -> Option<DVec3> {
    let [a, b, c] = face.map(|v| points[v as usize]);
    (b - a).cross(c - a).try_normalize()
}

/// Whether every point has faces of different directions around it.
fn is_creased(points: usize, faces: &[[u32; 3]], normals: &[DVec3]) -> bool {
    let (mut first, mut creased) = (vec![DVec3::ZERO; points], vec![false; points]);
    for (face, normal) in faces.iter().zip(normals) {
        for v in face.map(|v| v as usize) {
            let is_known = first[v] != DVec3::ZERO;
            creased[v] |= is_known && first[v].dot(*normal) < LEVEL;
            first[v] = if is_known { first[v] } else { *normal };
        }
    }
    creased.into_iter().all(|c| c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tessellate::tessellated;
    use crate::robot::Geometry;

    fn cube() -> Mesh {
        tessellated(&Geometry::Box { size: DVec3::new(1.0, 2.0, 3.0) }).unwrap()
    }

    #[test]
    fn a_box_and_an_octahedron_are_their_own_hulls() {
        let tips = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        let sides = (0..4u32).flat_map(|i| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]]).collect();
        for mesh in [cube(), Mesh::new(tips.to_vec(), sides).unwrap()] {
            let (points, faces) = own_hull(&mesh).unwrap();
            assert_eq!((points.len(), faces.len()), (mesh.vertices().len(), mesh.faces().len()));
        }
    }

    #[test]
    fn a_point_that_no_face_uses_is_left_out() {
        let (mut points, faces) = (cube().vertices().to_vec(), cube().faces().to_vec());
        points.insert(0, DVec3::ZERO);
        let faces = faces.into_iter().map(|f| f.map(|v| v + 1)).collect();
        let (used, faces) = own_hull(&Mesh::new(points, faces).unwrap()).unwrap();
        assert_eq!((used.len(), faces), (8, cube().faces().to_vec()));
    }

    #[test]
    fn what_is_open_dented_inside_out_doubled_or_flat_is_not() {
        let (points, faces) = (cube().vertices().to_vec(), cube().faces().to_vec());
        let hull_of = |points: &[DVec3], faces: &[[u32; 3]]| {
            own_hull(&Mesh::new(points.to_vec(), faces.to_vec()).unwrap())
        };
        assert!(hull_of(&points, &faces).is_some());
        assert!(hull_of(&points, &faces[1..]).is_none(), "open");
        let turned: Vec<_> = faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert!(hull_of(&points, &turned).is_none(), "inside out");
        let mut dented = points.clone();
        dented[0] *= 0.2;
        assert!(hull_of(&dented, &faces).is_none(), "dented");
        let twice = [points.clone(), points.clone()].concat();
        let both = faces.iter().copied().chain(faces.iter().map(|f| f.map(|v| v + 8)));
        assert!(hull_of(&twice, &both.collect::<Vec<_>>()).is_none(), "doubled");
        let (mut split, mut fan) = (points.clone(), faces.clone());
        let [a, b, c] = fan.pop().unwrap();
        split.push([a, b, c].iter().map(|&v| points[v as usize]).sum::<DVec3>() / 3.0);
        fan.extend([[a, b, 8], [b, c, 8], [c, a, 8]]);
        assert!(hull_of(&split, &fan).is_none(), "a point amid a face");
        let flat: Vec<_> = points.iter().map(|p| p.with_z(1e-12 * p.z)).collect();
        assert!(hull_of(&flat, &faces).is_none(), "flat");
    }
}
