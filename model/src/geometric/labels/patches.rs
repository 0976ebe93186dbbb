//! Cuts one fused skin into smooth patches and says how much each border looks like a seam.

use std::collections::BTreeMap;

use object::weld::{Neighbour, Weld};
use object::{DVec3, Mesh};

use super::lexicon::knob;
use super::merge::{Link, groups};

/// The turn of the surface over an edge.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Length of the edge, metres.
    pub length: f64,
    /// Angle between the two faces' normals, radians; negative where the edge is convex.
    pub angle: f64,
}

/// What a border between two patches looks like.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seam {
    /// Its length, metres.
    pub length: f64,
    /// Mean over its length of the concave turn, radians.
    pub concave: f64,
    /// Mean over its length of the convex turn, radians.
    pub convex: f64,
}

/// Normals averaged over the neighbouring faces, `rounds` times.
pub fn smooth_normals(mesh: &Mesh, edges: &[Neighbour], rounds: usize) -> Vec<DVec3> {
    let mut sums: Vec<DVec3> = (0..mesh.faces().len()).map(|f| mesh.area_vector(f)).collect();
    for _ in 0..rounds {
        let mut next = sums.clone();
        for e in edges {
            next[e.first as usize] += sums[e.second as usize] * 0.5;
            next[e.second as usize] += sums[e.first as usize] * 0.5;
        }
        sums = next;
    }
    sums.iter().map(|s| s.normalize_or_zero()).collect()
}

/// The turn over an edge, by the given normals.
pub fn turn(mesh: &Mesh, weld: &Weld, normals: &[DVec3], e: &Neighbour) -> Turn {
    let (f, g) = (e.first as usize, e.second as usize);
    let (nf, ng) = (normals[f], normals[g]);
    let across = mesh.centroid(g) - mesh.centroid(f);
    let angle = nf.angle_between(ng);
    let angle = if angle.is_finite() { angle } else { 0.0 };
    let concave = across.dot(nf) > across.dot(ng);
    let length = weld.places[e.edge[0] as usize].distance(weld.places[e.edge[1] as usize]);
    Turn { length, angle: if concave { angle } else { -angle } }
}

/// The patch of each face, and how many there are.
pub fn patches(turns: &[Turn], edges: &[Neighbour], faces: usize) -> (Vec<u32>, usize) {
    let link = |(e, t): (&Neighbour, &Turn)| {
        let sharp = if t.angle > 0.0 { t.angle } else { -t.angle * knob("cvx", 0.5) };
        Link { a: e.first, b: e.second, evidence: -sharp, weight: t.length }
    };
    let links: Vec<Link> = edges.iter().zip(turns).map(link).collect();
    groups(faces, &links, -knob("tau", 0.2) - 0.7)
}

/// The borders between patches.
pub fn seams(turns: &[Turn], edges: &[Neighbour], patch: &[u32]) -> BTreeMap<(u32, u32), Seam> {
    let mut seams: BTreeMap<(u32, u32), Seam> = BTreeMap::new();
    for (e, t) in edges.iter().zip(turns) {
        let (p, q) = (patch[e.first as usize], patch[e.second as usize]);
        if p == q {
            continue;
        }
        let seam = seams.entry((p.min(q), p.max(q))).or_default();
        seam.length += t.length;
        seam.concave += t.length * t.angle.max(0.0);
        seam.convex += t.length * (-t.angle).max(0.0);
    }
    for seam in seams.values_mut() {
        seam.concave /= seam.length.max(f64::MIN_POSITIVE);
        seam.convex /= seam.length.max(f64::MIN_POSITIVE);
    }
    seams
}

/// Turns seen from `steps` faces further away on either side, where that makes them more concave:
/// a seam rounded over several edges counts as one.
pub fn widened(mesh: &Mesh, edges: &[Neighbour], turns: &[Turn], steps: usize) -> Vec<Turn> {
    let faces = mesh.faces().len();
    let centroids: Vec<DVec3> = (0..faces).map(|f| mesh.centroid(f)).collect();
    let normals: Vec<DVec3> = (0..faces).map(|f| mesh.normal(f)).collect();
    let mut around = vec![[u32::MAX; 3]; faces];
    for e in edges {
        for (f, g) in [(e.first, e.second), (e.second, e.first)] {
            if let Some(slot) = around[f as usize].iter_mut().find(|s| **s == u32::MAX) {
                *slot = g;
            }
        }
    }
    let step = |f: u32, from: u32| {
        let along = centroids[f as usize] - centroids[from as usize];
        let ahead = |h: &u32| (centroids[*h as usize] - centroids[f as usize]).dot(along);
        let next = around[f as usize].iter().copied().filter(|&h| h != u32::MAX && h != from);
        next.max_by(|a, b| ahead(a).total_cmp(&ahead(b))).filter(|h| ahead(h) > 0.0).unwrap_or(f)
    };
    let widen = |(e, t): (&Neighbour, &Turn)| {
        let mut best = *t;
        let (mut f, mut g, mut pf, mut pg) = (e.first, e.second, e.second, e.first);
        for _ in 0..steps {
            (f, pf) = (step(f, pf), f);
            (g, pg) = (step(g, pg), g);
            let (nf, ng) = (normals[f as usize], normals[g as usize]);
            let across = centroids[g as usize] - centroids[f as usize];
            let angle = nf.angle_between(ng);
            let angle = if across.dot(nf) > across.dot(ng) { angle } else { -angle };
            if angle.is_finite() && angle > best.angle {
                best.angle = angle;
            }
        }
        best
    };
    edges.iter().zip(turns).map(widen).collect()
}
