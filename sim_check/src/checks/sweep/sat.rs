//! The exact depth of two overlapping convex polyhedra: the separating-axis test over all faces of
//! their Minkowski difference.
//!
//! The iterative search (GJK with EPA) stops early where faces are coplanar or symmetric, which is
//! what furniture is made of; this one has no tolerance to converge to. The faces of the difference
//! are those of the first, those of the second, and one for each pair of edges whose arcs cross on
//! the Gauss sphere (D. Gregorius, "The separating axis test between convex polyhedra", 2013).

use glamx::{DPose3, DVec3};

use super::facets::Edge;
use super::hull::{Gap, Hull};

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
