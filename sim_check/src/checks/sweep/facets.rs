//! Faces and edges of a convex polyhedron, each plane once.

use glamx::DVec3;

/// Normals nearer than this (1 − cosine) are one face.
const COPLANAR: f64 = 1e-12;

/// Faces and edges of a convex polyhedron.
#[derive(Clone, Debug, Default)]
pub struct Facets {
    /// Outward unit normals, none twice.
    pub normals: Vec<DVec3>,
    /// Edges between faces of different normals.
    pub edges: Vec<Edge>,
}

/// An edge and the two faces it lies between.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    pub(super) point: DVec3,
    pub(super) along: DVec3,
    pub(super) normals: [DVec3; 2],
}

impl Facets {
    /// Reads them off a closed triangle surface; `None` if it is not closed.
    pub fn of(corners: &[DVec3], faces: &[[u32; 3]]) -> Option<Self> {
        let normals: Vec<DVec3> = faces.iter().map(|f| normal(corners, f)).collect();
        let mut sides: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * faces.len());
        for (face, &[a, b, c]) in faces.iter().enumerate() {
            sides.extend([[a, b], [b, c], [c, a]].map(|[p, q]| ([p.min(q), p.max(q)], face)));
        }
        sides.sort_unstable();
        let mut edges = Vec::new();
        for at in sides.chunk_by(|x, y| x.0 == y.0) {
            let &[([p, q], f), (_, g)] = at else { return None };
            let normals = [normals[f], normals[g]];
            let [point, end] = [p, q].map(|v| corners[v as usize]);
            if normals[0].dot(normals[1]) < 1.0 - COPLANAR {
                edges.push(Edge { point, along: end - point, normals });
            }
        }
        Some(Self { normals: distinct(normals), edges })
    }
}

fn normal(corners: &[DVec3], face: &[u32; 3]) -> DVec3 {
    let [a, b, c] = face.map(|v| corners[v as usize]);
    (b - a).cross(c - a).normalize_or_zero()
}

fn distinct(mut normals: Vec<DVec3>) -> Vec<DVec3> {
    normals.retain(|n| *n != DVec3::ZERO);
    normals.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    normals.dedup_by(|a, b| a.dot(*b) > 1.0 - COPLANAR);
    normals
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tessellate::tessellated;
    use crate::robot::Geometry;

    #[test]
    fn a_box_of_triangles_has_its_six_sides_and_twelve_edges() {
        let cube = tessellated(&Geometry::Box { size: DVec3::ONE }).unwrap();
        let facets = Facets::of(cube.vertices(), cube.faces()).unwrap();
        assert_eq!(facets.edges.len(), 12);
        assert!(facets.normals.iter().all(|n| n.abs().max_element() == 1.0));
        for side in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
            assert!(facets.normals.contains(&side), "{side}");
        }
        assert!(Facets::of(cube.vertices(), &cube.faces()[1..]).is_none(), "open");
    }
}
