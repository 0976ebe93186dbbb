//! How well a link's pieces cover its surface, sample by sample, and what a cut would cost.

use std::collections::BTreeMap;

use glamx::DVec3;
use object::mesh::Mesh;
use object::sample::sample_surface;
use rayon::prelude::*;

use crate::collision::solid::Solid;

/// A sample farther than this share of the tolerance from every piece counts as uncovered.
const STRICT: f64 = 0.85;
/// What an uncovered sample costs more than one just within the tolerance.
const UNCOVERED: f64 = 20.0;

/// Samples drawn of each link, before all but one of each cell are dropped.
const DRAWN: usize = 20_000;
/// Cells wanted of a link, at most about this many.
const CELLS: f64 = 5_000.0;
/// Smallest cell, as a share of the limit.
const FINEST: f64 = 0.3;

/// Samples measured in one go.
const AT_ONCE: usize = 500;

/// Samples of a link's surface, one for each small cell it passes through so that no corner of it
/// is forgotten, and how far each may be from a piece.
#[derive(Clone, Debug)]
pub(crate) struct Cover {
    /// Where, and the share of the link's area it stands for.
    samples: Vec<(DVec3, f64)>,
    /// Uncovered from here on, metres.
    pub(crate) limit: f64,
}

impl Cover {
    /// Samples of the surface for a tolerance in metres.
    pub(crate) fn new(link: &Mesh, seed: u64, tolerance: f64) -> Self {
        let limit = STRICT * tolerance;
        let area: f64 = (0..link.faces().len()).map(|f| link.area(f)).sum();
        let cell = (FINEST * limit).max((area / CELLS).sqrt());
        let mut cells: BTreeMap<[i64; 3], (DVec3, f64)> = BTreeMap::new();
        for sample in sample_surface(link, DRAWN, seed) {
            let key = (sample.position / cell).floor().to_array().map(|c| c as i64);
            let entry = cells.entry(key).or_insert((sample.position, 0.0));
            entry.1 += 1.0 / DRAWN as f64;
        }
        Self { samples: cells.into_values().collect(), limit }
    }

    /// No samples: nothing to cover.
    pub(crate) fn empty(tolerance: f64) -> Self {
        Self { samples: Vec::new(), limit: STRICT * tolerance }
    }

    /// Distance of every sample from a piece; anything beyond twice the limit reads as infinite.
    pub(crate) fn row(&self, solid: &Solid) -> Vec<f64> {
        let near = solid.bounds.grown(2.0 * self.limit);
        let distance = |&(p, _): &(DVec3, f64)| {
            if near.holds(p) { solid.distance(p, 2.0 * self.limit) } else { f64::INFINITY }
        };
        self.samples.par_iter().with_min_len(AT_ONCE).map(distance).collect()
    }

    /// What it costs that a sample is this far from the nearest piece.
    pub(crate) fn price(&self, distance: f64) -> f64 {
        let share = distance / self.limit;
        if share <= 1.0 { share * share } else { 1.0 + UNCOVERED }
    }

    /// Distance of every sample from the nearest of some rows.
    pub(crate) fn nearest<'a>(&self, rows: impl Iterator<Item = &'a Vec<f64>>) -> Vec<f64> {
        let mut nearest = vec![f64::INFINITY; self.samples.len()];
        for row in rows {
            for (n, d) in nearest.iter_mut().zip(row) {
                *n = n.min(*d);
            }
        }
        nearest
    }

    /// Mean price of samples this far away.
    pub(crate) fn cost(&self, distances: &[f64]) -> f64 {
        let all = self.samples.iter().zip(distances);
        all.map(|((_, weight), &d)| weight * self.price(d)).sum()
    }

    /// Share of the surface farther than the limit.
    pub(crate) fn uncovered(&self, distances: &[f64]) -> f64 {
        let all = self.samples.iter().zip(distances);
        let bare = all.filter(|(_, d)| **d > self.limit).map(|((_, weight), _)| *weight);
        bare.fold(0.0, |sum, weight| sum + weight)
    }

    /// Of the pieces with these rows that may go, the one whose loss costs least, if the others serve
    /// all that is served with it.
    pub(crate) fn spare(
        &self,
        rows: &[&Vec<f64>],
        may_go: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        // The nearest piece of each sample, how far it is and how far the next one is.
        let mut near = vec![(usize::MAX, f64::INFINITY, f64::INFINITY); self.samples.len()];
        for (i, row) in rows.iter().enumerate() {
            for (near, &d) in near.iter_mut().zip(row.iter()) {
                if d < near.1 {
                    *near = (i, d, near.1);
                } else if d < near.2 {
                    near.2 = d;
                }
            }
        }
        let bare = self.uncovered(&near.iter().map(|n| n.1).collect::<Vec<_>>());
        let without = |gone: usize| -> Vec<f64> {
            near.iter().map(|&(i, first, next)| if i == gone { next } else { first }).collect()
        };
        let losses = (0..rows.len()).filter(|&i| may_go(i)).map(|i| (i, without(i)));
        let free = losses.filter(|(_, left)| self.uncovered(left) <= bare);
        let costs = free.map(|(i, left)| (i, self.cost(&left)));
        costs.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// The samples that a piece with row `own` serves better than `others` do.
    pub(crate) fn served(&self, own: &[f64], others: &[f64]) -> Vec<Served> {
        let all = self.samples.iter().zip(others.iter().zip(own));
        let served = all.filter(|(_, (other, own))| own < other && **own <= 1.2 * self.limit);
        let served = served.map(|(&(at, weight), (&kept, &own))| Served { at, weight, kept, own });
        served.collect()
    }
}

/// A sample that a piece serves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Served {
    /// Where, object frame.
    pub(crate) at: DVec3,
    /// Share of the link's area.
    pub(crate) weight: f64,
    /// Distance from the nearest other piece, metres.
    pub(crate) kept: f64,
    /// Distance from the piece, metres.
    pub(crate) own: f64,
}
