//! The exact depth of two overlapping convex polyhedra: the separating-axis test over all faces of
//! their Minkowski difference.
//!
//! The iterative search (GJK with EPA) stops early where faces are coplanar or symmetric, which is
//! what furniture is made of; this one has no tolerance to converge to. The faces of the difference
//! are those of the first, those of the second, and one for each pair of edges whose arcs cross on
//! the Gauss sphere (D. Gregorius, "The separating axis test between convex polyhedra", 2013).

use glamx::{DPose3, DVec3};

use super::hull::{Gap, Hull};
use parry3d_f64::shape::SupportMap;

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
    point: DVec3,
    along: DVec3,
    normals: [DVec3; 2],
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

/// The widest gap (or shallowest overlap) over all faces of the Minkowski difference: for
/// overlapping hulls the exact depth, for separate ones a lower bound of their distance. The
/// second's frame stands at `pose` in the first's.
pub fn widest_gap(a: &Hull, b: &Hull, pose: &DPose3) -> Gap {
    let theirs = b.facets().normals.iter().map(|n| -(pose.rotation * *n));
    let faces = a.facets().normals.iter().copied().chain(theirs);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let mut best = Gap { distance: f64::NEG_INFINITY, normal: DVec3::X };
    for normal in faces.chain(axes) {
        best = wider(best, a.gap_along(b, pose, normal));
    }
    across_edges(a, b, pose, best)
}

/// The same over pairs of edges, starting from the best so far.
fn across_edges(a: &Hull, b: &Hull, pose: &DPose3, mut best: Gap) -> Gap {
    let turned = |e: &Edge| Edge {
        point: pose.transform_point(e.point),
        along: pose.rotation * e.along,
        normals: e.normals.map(|n| pose.rotation * n),
    };
    let theirs: Vec<Edge> = b.facets().edges.iter().map(turned).collect();
    for mine in &a.facets().edges {
        for other in &theirs {
            if !arcs_cross(mine, other) {
                continue;
            }
            let across = mine.along.cross(other.along);
            let Some(across) = across.try_normalize() else { continue };
            let outward = across.dot(mine.normals[0] + mine.normals[1]) >= 0.0;
            let normal = if outward { across } else { -across };
            let gap = Gap { distance: normal.dot(other.point - mine.point), normal };
            if gap.distance > best.distance {
                // Crossing arcs are a face of the difference up to rounding: measure it.
                best = wider(best, a.gap_along(b, pose, normal));
            }
        }
    }
    best
}

fn wider(a: Gap, b: Gap) -> Gap {
    if b.distance > a.distance { b } else { a }
}

/// Whether the arc between the first edge's normals crosses that between the second's, mirrored.
fn arcs_cross(a: &Edge, b: &Edge) -> bool {
    let [n, m] = a.normals;
    let [o, p] = b.normals.map(|n| -n);
    let (mn, po) = (m.cross(n), p.cross(o));
    let (o_side, p_side) = (o.dot(mn), p.dot(mn));
    let (n_side, m_side) = (n.dot(po), m.dot(po));
    o_side * p_side < 0.0 && n_side * m_side < 0.0 && o_side * m_side > 0.0
}

/// Whether the hull is known to hold all the points.
pub fn holds(hull: &Hull, points: &[DVec3]) -> bool {
    let tolerance = 1e-9 * hull.size();
    let within = |n: &DVec3| {
        let reach = n.dot(hull.local_support_point(*n)) + tolerance;
        points.iter().all(|p| n.dot(*p) <= reach)
    };
    hull.facets().normals.len() >= 4 && hull.facets().normals.iter().all(within)
}
