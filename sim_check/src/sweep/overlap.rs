//! Which pieces overlap in one configuration, and how deep.

use glamx::{DPose3, DVec3};
use object::mesh::Bounds;

use super::scene::Scene;

/// Two pieces inside each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Indices of the pieces, smaller first.
    pub pieces: [usize; 2],
    /// Shortest way out, metres, positive.
    pub depth: f64,
}

/// The configuration's deepest overlaps, one per pair of links, deepest first; only pairs of
/// bodies that `asked` wants (indices into [`Scene::bodies`], smaller first).
pub fn overlaps(scene: &Scene, q: &[f64], asked: impl Fn(usize, usize) -> bool) -> Vec<Overlap> {
    let placed = Placed::new(scene, q);
    let mut found = Vec::new();
    for b in 0..scene.bodies.len() {
        for a in 0..b {
            if asked(a, b) && placed.bodies[a].intersects(&placed.bodies[b]) {
                between_bodies(scene, &placed, [a, b], &mut found);
            }
        }
    }
    keep_deepest(scene, found)
}

/// Pieces and bodies with their boxes in the root frame.
struct Placed {
    poses: Vec<DPose3>,
    pieces: Vec<Bounds>,
    bodies: Vec<Bounds>,
}

impl Placed {
    fn new(scene: &Scene, q: &[f64]) -> Self {
        let poses = scene.piece_poses(q);
        let posed = scene.pieces.iter().zip(&poses);
        let pieces: Vec<_> = posed.map(|(p, pose)| p.hull.bounds_at(pose)).collect();
        let body = |b: &super::scene::Body| {
            Bounds::of(b.pieces.iter().flat_map(|&p| [pieces[p].min, pieces[p].max]))
        };
        let bodies = scene.bodies.iter().map(body).collect();
        Self { poses, pieces, bodies }
    }
}

fn between_bodies(scene: &Scene, placed: &Placed, [a, b]: [usize; 2], found: &mut Vec<Overlap>) {
    for &i in &scene.bodies[a].pieces {
        if !placed.pieces[i].intersects(&placed.bodies[b]) {
            continue;
        }
        for &j in &scene.bodies[b].pieces {
            if !placed.pieces[i].intersects(&placed.pieces[j]) {
                continue;
            }
            let pose = placed.poses[i].inv_mul(&placed.poses[j]);
            let gap = scene.pieces[i].hull.gap(&scene.pieces[j].hull, &pose, None);
            if gap.distance < 0.0 {
                found.push(Overlap { pieces: [i.min(j), i.max(j)], depth: -gap.distance });
            }
        }
    }
}

fn keep_deepest(scene: &Scene, mut found: Vec<Overlap>) -> Vec<Overlap> {
    found.sort_by(|a, b| b.depth.total_cmp(&a.depth).then(a.pieces.cmp(&b.pieces)));
    let mut seen = std::collections::BTreeSet::new();
    let links = |o: &Overlap| o.pieces.map(|p| scene.pieces[p].link);
    found.retain(|o| seen.insert(links(o)));
    found
}

/// Smallest distance between two posed bodies, metres; 0 if they touch or overlap, infinite if
/// one has no pieces.
pub fn body_distance(scene: &Scene, poses: &[DPose3], [a, b]: [usize; 2]) -> f64 {
    let boxed = |&p: &usize| (p, scene.pieces[p].hull.bounds_at(&poses[p]));
    let theirs: Vec<_> = scene.bodies[b].pieces.iter().map(boxed).collect();
    let mine = scene.bodies[a].pieces.iter().map(boxed);
    let mut pairs: Vec<(f64, usize, usize)> = mine
        .flat_map(|(i, box_i)| {
            theirs.iter().map(move |(j, box_j)| (box_distance(&box_i, box_j), i, *j))
        })
        .collect();
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut nearest = f64::INFINITY;
    for (apart, i, j) in pairs {
        if apart >= nearest || nearest <= 0.0 {
            break;
        }
        let pose = poses[i].inv_mul(&poses[j]);
        let gap = scene.pieces[i].hull.gap(&scene.pieces[j].hull, &pose, None);
        nearest = nearest.min(gap.distance.max(0.0));
    }
    nearest
}

/// Distance between two boxes; 0 if they touch.
pub fn box_distance(a: &Bounds, b: &Bounds) -> f64 {
    (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO).length()
}
