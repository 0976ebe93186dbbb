//! Joints that move at the same time: corners of every pair's range, and random poses of all.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::overlap::{Overlap, overlaps};
use super::scene::Scene;

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
    let corners: Vec<Vec<f64>> = scene.drives.iter().map(|d| d.corners()).collect();
    let mut asked = 0usize;
    let mut found = Vec::new();
    for j in 0..corners.len() {
        for i in 0..j {
            asked += corners[i].len() * corners[j].len();
            if asked > CORNER_LIMIT {
                return None;
            }
            let values = corners[i].iter().flat_map(|&a| corners[j].iter().map(move |&b| (a, b)));
            found.extend(values.flat_map(|(a, b)| deepest(scene, vec![(i, a), (j, b)])));
        }
    }
    if corners.len() >= 2 {
        found.extend(random(scene, seed).into_iter().flat_map(|moved| deepest(scene, moved)));
    }
    found.sort_by(|a, b| {
        b.overlap.depth.total_cmp(&a.overlap.depth).then(a.overlap.pieces.cmp(&b.overlap.pieces))
    });
    Some(found)
}

fn deepest(scene: &Scene, moved: Vec<(usize, f64)>) -> Option<Meeting> {
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
