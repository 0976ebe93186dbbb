//! How well a link's pieces cover its surface, sample by sample, and what a cut would cost.

use glamx::DVec3;
use object::mesh::Mesh;
use object::sample::sample_surface;

use crate::hulls::solid::Solid;

/// A sample farther than this share of the tolerance from every piece counts as uncovered.
const STRICT: f64 = 0.85;
/// What an uncovered sample costs more than one just within the tolerance.
const UNCOVERED: f64 = 20.0;

/// Samples of a link's surface and how far each may be from a piece.
#[derive(Clone, Debug)]
pub(crate) struct Cover {
    samples: Vec<DVec3>,
    /// Uncovered from here on, metres.
    pub(crate) limit: f64,
}

impl Cover {
    /// `count` samples of the surface.
    pub(crate) fn new(link: &Mesh, count: usize, seed: u64, tolerance: f64) -> Self {
        let samples = sample_surface(link, count, seed).iter().map(|s| s.position).collect();
        Self { samples, limit: STRICT * tolerance }
    }

    /// No samples: nothing to cover.
    pub(crate) fn empty(tolerance: f64) -> Self {
        Self { samples: Vec::new(), limit: STRICT * tolerance }
    }

    /// Distance of every sample from a piece; anything beyond twice the limit reads as infinite.
    pub(crate) fn row(&self, solid: &Solid) -> Vec<f64> {
        let near = solid.bounds.grown(2.0 * self.limit);
        let distance = |&p: &DVec3| {
            let within = near.min.cmple(p).all() && near.max.cmpge(p).all();
            if within { solid.distance(p, 2.0 * self.limit) } else { f64::INFINITY }
        };
        self.samples.iter().map(distance).collect()
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
        distances.iter().map(|&d| self.price(d)).sum::<f64>() / self.count()
    }

    /// Share of samples farther than the limit.
    pub(crate) fn uncovered(&self, distances: &[f64]) -> f64 {
        distances.iter().filter(|&&d| d > self.limit).count() as f64 / self.count()
    }

    pub(crate) fn dbg(&self, p: DVec3) -> String { let d = self.samples.iter().map(|s| s.distance(p)).fold(9.0, f64::min); format!("{} samples, nearest {d}", self.samples.len()) }
    /// Number of samples, at least 1.
    pub(crate) fn count(&self) -> f64 {
        self.samples.len().max(1) as f64
    }

    /// The samples that a piece with row `own` serves better than `others` do: position, distance
    /// from the others, distance from the piece.
    pub(crate) fn served(&self, own: &[f64], others: &[f64]) -> Vec<(DVec3, f64, f64)> {
        let all = self.samples.iter().zip(others.iter().zip(own));
        let served = all.filter(|(_, (other, own))| own < other && **own <= 1.2 * self.limit);
        served.map(|(&p, (&other, &own))| (p, other, own)).collect()
    }
}
