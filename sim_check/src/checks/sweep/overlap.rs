//! Which pieces overlap in one configuration, and how deep.

use glamx::DPose3;
use object::mesh::Bounds;

use super::boxes::box_distance;
use super::scene::Scene;
use super::stance::Stance;

/// Deepest first, then the first pieces first.
pub fn by_depth(a: &Overlap, b: &Overlap) -> std::cmp::Ordering {
    b.depth.total_cmp(&a.depth).then(a.pieces.cmp(&b.pieces))
}

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
    for [a, b] in meeting(&placed.bodies) {
        if asked(a, b) && scene.terms.look_at(a, b) {
            between_bodies(scene, &placed, [a, b], &mut found);
        }
    }
    keep_deepest(scene, found)
}

/// Pairs of boxes that share a point, the smaller index first: along the direction they are most
/// spread in, only those whose stretches overlap are compared.
fn meeting(boxes: &[Bounds]) -> Vec<[usize; 2]> {
    let full = |b: &Bounds| b.min.cmple(b.max).all();
    let mut order: Vec<usize> = (0..boxes.len()).filter(|&b| full(&boxes[b])).collect();
    let spread = Bounds::of(order.iter().map(|&b| boxes[b].centre())).size();
    let along = (1..3).fold(0, |most, k| if spread[k] > spread[most] { k } else { most });
    order.sort_by(|&a, &b| boxes[a].min[along].total_cmp(&boxes[b].min[along]));
    let (mut found, mut open) = (Vec::new(), Vec::<usize>::new());
    for b in order {
        open.retain(|&a| boxes[a].max[along] >= boxes[b].min[along]);
        let met = open.iter().filter(|&&a| boxes[a].intersects(&boxes[b]));
        found.extend(met.map(|&a| [a.min(b), a.max(b)]));
        open.push(b);
    }
    found
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
        let body = |b: &super::bodies::Body| {
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
            let near = placed.pieces[i].intersects(&placed.pieces[j]);
            if !near || !scene.terms.meet(i, j) {
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
    found.sort_by(by_depth);
    let mut seen = std::collections::BTreeSet::new();
    let links = |o: &Overlap| o.pieces.map(|p| scene.pieces[p].link);
    found.retain(|o| seen.insert(links(o)));
    found
}

/// Smallest distance between two posed bodies, metres; 0 if they touch or overlap, infinite if
/// one has no pieces.
pub fn body_distance(scene: &Scene, stance: &mut Stance, [a, b]: [usize; 2]) -> f64 {
    let mut placed = |body: usize| {
        let place = |&p: &usize| {
            let pose = stance.piece(p);
            (p, pose, scene.pieces[p].hull.bounds_at(&pose))
        };
        scene.bodies[body].pieces.iter().map(place).collect::<Vec<_>>()
    };
    let (mine, theirs) = (placed(a), placed(b));
    let between = |k: usize| (0..theirs.len()).map(move |l| [k, l]);
    let apart = |[k, l]: [usize; 2]| (box_distance(&mine[k].2, &theirs[l].2), k, l);
    let mut pairs: Vec<(f64, usize, usize)> =
        (0..mine.len()).flat_map(between).map(apart).collect();
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut nearest = f64::INFINITY;
    for (apart, k, l) in pairs {
        if apart >= nearest || nearest <= 0.0 {
            break;
        }
        let ((i, from, _), (j, to, _)) = (mine[k], theirs[l]);
        let pose = from.inv_mul(&to);
        let gap = scene.pieces[i].hull.gap(&scene.pieces[j].hull, &pose, None);
        nearest = nearest.min(gap.distance.max(0.0));
    }
    nearest
}
