//! Normals to shade with: smooth over gentle bends, split along creases.

use std::collections::BTreeMap;

use glamx::DVec3;

use crate::mesh::Mesh;
use crate::weld::{DisjointSets, Weld};

/// Faces that meet at a sharper angle than this (40°, in radians) are shaded apart.
pub const CREASE_ANGLE: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// For every face, the unit normal at each of its corners, object frame.
///
/// Faces that share an edge and bend by less than `crease` radians there are one smooth surface; a
/// corner's normal is the mean over the faces of its smooth surface around that point, weighted by
/// their angle. A face without area takes no part; its corners get +z.
pub fn corner_normals(mesh: &Mesh, crease: f64) -> Vec<[DVec3; 3]> {
    let (mut sets, weights) = smooth_corners(mesh, crease);
    let mut sums = vec![DVec3::ZERO; weights.len()];
    for (corner, &weight) in weights.iter().enumerate() {
        sums[sets.root(corner as u32) as usize] += weight;
    }
    let mut normal =
        |corner: usize| sums[sets.root(corner as u32) as usize].try_normalize().unwrap_or(DVec3::Z);
    (0..mesh.faces().len()).map(|f| [3 * f, 3 * f + 1, 3 * f + 2].map(&mut normal)).collect()
}

/// A mesh whose vertices are doubled along creases, so that each has one normal: what file formats
/// and graphics cards want.
#[derive(Clone, Debug, PartialEq)]
pub struct Shaded {
    /// For each new vertex, the vertex of the mesh it repeats.
    pub source: Vec<u32>,
    /// Unit normal of each new vertex, object frame.
    pub normals: Vec<DVec3>,
    /// New vertex indices of each face; same faces, same order, same winding.
    pub faces: Vec<[u32; 3]>,
}

/// Doubles vertices along creases; new vertices are numbered in order of first use.
pub fn shaded(mesh: &Mesh, crease: f64) -> Shaded {
    let corners = corner_normals(mesh, crease);
    let (mut source, mut normals) = (Vec::new(), Vec::new());
    let mut known: BTreeMap<(u32, [u64; 3]), u32> = BTreeMap::new();
    let mut new_vertex = |vertex: u32, normal: DVec3| {
        let next = source.len() as u32;
        *known.entry((vertex, normal.to_array().map(f64::to_bits))).or_insert_with(|| {
            source.push(vertex);
            normals.push(normal);
            next
        })
    };
    let pairs = mesh.faces().iter().zip(&corners);
    let faces =
        pairs.map(|(&f, n)| std::array::from_fn(|i| new_vertex(f[i], n[i]))).collect::<Vec<_>>();
    Shaded { source, normals, faces }
}

/// Corners (three per face) joined into smooth groups, and each corner's share of its normal: the
/// face's normal times the angle of the corner.
fn smooth_corners(mesh: &Mesh, crease: f64) -> (DisjointSets, Vec<DVec3>) {
    let weld = Weld::new(mesh);
    let unit: Vec<DVec3> = (0..mesh.faces().len()).map(|f| mesh.normal(f)).collect();
    let mut sets = DisjointSets::new(3 * unit.len());
    let smooth = crease.cos();
    for pair in weld.neighbours() {
        let (a, b) = (pair.first as usize, pair.second as usize);
        if unit[a].dot(unit[b]) < smooth {
            continue;
        }
        for place in pair.edge {
            let corner = |f: usize| weld.faces[f].iter().position(|&p| p == place);
            if let (Some(i), Some(j)) = (corner(a), corner(b)) {
                sets.join((3 * a + i) as u32, (3 * b + j) as u32);
            }
        }
    }
    let weights = (0..unit.len()).flat_map(|f| corner_angles(mesh, f).map(|angle| unit[f] * angle));
    (sets, weights.collect())
}

fn corner_angles(mesh: &Mesh, face: usize) -> [f64; 3] {
    let [a, b, c] = mesh.corners(face);
    let angle = |at: DVec3, p: DVec3, q: DVec3| {
        let (u, v) = ((p - at).normalize_or_zero(), (q - at).normalize_or_zero());
        u.cross(v).length().atan2(u.dot(v))
    };
    [angle(a, b, c), angle(b, c, a), angle(c, a, b)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed unit cube with eight shared vertices.
    fn cube() -> Mesh {
        let corner = |i: u32| DVec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into());
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh::new((0..8).map(corner).collect(), faces).unwrap()
    }

    #[test]
    fn a_cube_stays_flat_and_its_corners_split_in_three() {
        let mesh = cube();
        let normals = corner_normals(&mesh, CREASE_ANGLE);
        for (f, corners) in normals.iter().enumerate() {
            assert!(corners.iter().all(|n| (*n - mesh.normal(f)).length() < 1e-12));
        }
        let split = shaded(&mesh, CREASE_ANGLE);
        assert_eq!(split.source.len(), 24);
        let back: Vec<_> =
            split.faces.iter().map(|f| f.map(|v| split.source[v as usize])).collect();
        assert_eq!(back, mesh.faces());
    }

    #[test]
    fn a_cube_smoothed_all_over_points_from_its_centre() {
        let mesh = cube();
        let normals = corner_normals(&mesh, 3.0);
        for (f, corners) in normals.iter().enumerate() {
            for (p, n) in mesh.corners(f).into_iter().zip(corners) {
                let outward = (p - DVec3::splat(0.5)).normalize();
                assert!((outward - *n).length() < 1e-12, "{outward} {n}");
            }
        }
    }

    #[test]
    fn a_face_without_area_spoils_no_normal() {
        let v = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X];
        let mesh = Mesh::new(v, vec![[0, 1, 2], [0, 1, 3]]).unwrap();
        assert_eq!(corner_normals(&mesh, CREASE_ANGLE)[0], [DVec3::Z; 3]);
    }
}
