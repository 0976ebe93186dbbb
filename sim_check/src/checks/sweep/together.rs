//! Joints that move at the same time: corners of every pair's range, and random poses of all.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::advance::{MOST_BRANCHES, Rail};
use super::bodies::Drive;
use super::boxes::may_be_within;
use super::overlap::{Overlap, by_depth, overlaps};
use super::scene::Scene;
use super::stance::Stance;
use super::tree::Node;

/// Random configurations of all joints at once.
pub const RANDOM_CONFIGURATIONS: usize = 64;
/// Most configurations of pairs; beyond it the check has no answer.
const CORNER_LIMIT: usize = 40_000;

/// An overlap and the drives that were moved to get there.
#[derive(Clone, Debug, PartialEq)]
pub struct Meeting {
    /// The deepest overlap of a pair of links.
    pub overlap: Overlap,
    /// Drives and their values.
    pub moved: Vec<(usize, f64)>,
}

/// Every overlap that two or more joints make together, the deepest per configuration, deepest
/// first; `None` if there are too many pairs of joints to look at.
///
/// Pairs of bodies that only one of the two joints brings together are left to the sweep of that
/// joint. The random configurations look at all bodies that at least two joints move.
pub fn meetings(scene: &Scene, seed: u64) -> Option<Vec<Meeting>> {
    let corners: Vec<Vec<f64>> = scene.drives.iter().map(Drive::corners).collect();
    let all: usize = corners.iter().map(Vec::len).sum();
    let own: usize = corners.iter().map(|c| c.len() * c.len()).sum();
    if (all * all - own) / 2 > CORNER_LIMIT {
        return None;
    }
    let mut found = Vec::new();
    let mut stance = Stance::new(scene);
    for j in 0..corners.len() {
        for i in 0..j {
            let values = corners[i].iter().flat_map(|&a| corners[j].iter().map(move |&b| (a, b)));
            let met = |(a, b)| deepest_of_two(scene, &mut stance, [(i, a), (j, b)]);
            found.extend(values.flat_map(met));
        }
    }
    if corners.len() >= 2 {
        found.extend(random(scene, seed).into_iter().flat_map(|moved| deepest(scene, moved)));
    }
    found.sort_by(|a, b| by_depth(&a.overlap, &b.overlap));
    Some(found)
}

/// The deepest overlap of two bodies that both drives move against each other.
pub(super) fn deepest_of_two(
    scene: &Scene,
    stance: &mut Stance,
    moved: [(usize, f64); 2],
) -> Option<Meeting> {
    let Some(pairs) = near_each_other(scene, moved) else { return deepest(scene, moved.to_vec()) };
    if pairs.is_empty() {
        return None;
    }
    stance.take(&moved);
    let overlap = |&[p, q]: &[usize; 2]| {
        let [p, q] = if scene.pieces[p].body < scene.pieces[q].body { [p, q] } else { [q, p] };
        if !scene.counts(p, q) {
            return None;
        }
        let [a, b] = [p, q].map(|p| (&scene.pieces[p].hull, stance.piece(p)));
        if !a.0.bounds_at(&a.1).intersects(&b.0.bounds_at(&b.1)) {
            return None;
        }
        let gap = a.0.gap(b.0, &a.1.inv_mul(&b.1), None);
        let pieces = [p.min(q), p.max(q)];
        (gap.distance < 0.0).then_some(Overlap { pieces, depth: -gap.distance })
    };
    let overlap = pairs.iter().filter_map(overlap).min_by(by_depth)?;
    Some(Meeting { overlap, moved: moved.to_vec() })
}

/// Pairs of pieces that both drives move against each other and whose boxes may meet; `None` if
/// that cannot be told from the branches: where joints follow others, or too many are near.
///
/// What both move is one rigid thing against what neither moves, and what only the first moves
/// against what only the second does.
fn near_each_other(scene: &Scene, moved: [(usize, f64); 2]) -> Option<Vec<[usize; 2]>> {
    if moved.iter().any(|(d, _)| !scene.drives[*d].followers.is_empty()) {
        return None;
    }
    let child = |d: usize| scene.robot.joints[scene.drives[d].joint].child;
    let [i, j] = moved.map(|(d, _)| scene.robot.span(child(d)));
    let rails = moved.map(|(d, _)| Rail::new(scene, d));
    let [first, second] = [0, 1].map(|k| rails[k].motion(moved[k].1));
    // The joint nearer the root moves the other along.
    let both = if i[0] <= j[0] { first * second } else { second * first };
    let slack = rails.iter().map(|r| scene.tree.slack(scene.diagonal, r.pivot)).fold(0.0, f64::max);
    let mut found = scene.tree.pairs(
        |n| [!n.is_within(i) && !n.is_within(j), n.touches(i) && n.touches(j)],
        |still, moving| may_be_within(&still.bounds, &moving.cube.moved(&both), slack),
        MOST_BRANCHES,
    )?;
    let apart =
        |a: &Node, b: &Node| may_be_within(&a.cube.moved(&first), &b.cube.moved(&second), slack);
    let groups = |n: &Node| [n.touches(i) && !n.is_within(j), n.touches(j) && !n.is_within(i)];
    found.extend(scene.tree.pairs(groups, apart, MOST_BRANCHES)?);
    Some(found)
}

pub(super) fn deepest(scene: &Scene, moved: Vec<(usize, f64)>) -> Option<Meeting> {
    let both = |a: usize, b: usize| {
        let between =
            |&(d, _): &(usize, f64)| scene.bodies[a].moved_by[d] != scene.bodies[b].moved_by[d];
        moved.iter().filter(|m| between(m)).count() >= 2
    };
    let overlap = overlaps(scene, &scene.with(&moved), both).into_iter().next()?;
    Some(Meeting { overlap, moved })
}

fn random(scene: &Scene, seed: u64) -> Vec<Vec<(usize, f64)>> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut draw = || {
        let all = scene.drives.iter().enumerate();
        all.map(|(d, drive)| (d, rng.random_range(drive.lower..=drive.upper))).collect()
    };
    (0..RANDOM_CONFIGURATIONS).map(|_| draw()).collect()
}
