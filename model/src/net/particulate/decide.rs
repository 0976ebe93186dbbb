//! From Particulate's scores to parts, a tree and motions.

use object::DVec3;

use super::arborescence::best_arborescence;
use super::{Particulate, RawParticulate};
use crate::weights::WeightsError;

/// What Particulate says about one part's motion relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartMotion {
    /// Whether it turns.
    pub revolute: bool,
    /// Whether it slides.
    pub prismatic: bool,
    /// Unit direction of the turning axis.
    pub revolute_axis: DVec3,
    /// A point on that axis, unit cube: the median of the votes of the part's points.
    pub pivot: Option<DVec3>,
    /// Low and high angle, radians, as the network wrote them.
    pub revolute_range: [f64; 2],
    /// Unit direction of the slide.
    pub prismatic_axis: DVec3,
    /// Low and high travel, unit cube, as the network wrote them.
    pub prismatic_range: [f64; 2],
}

/// Parts, tree and motions.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The part slot of each point.
    pub part_of_point: Vec<u16>,
    /// Whether each slot is in use.
    pub used: Vec<bool>,
    /// Parent and child slots, by child.
    pub tree: Vec<(u16, u16)>,
    /// Motions of all slots.
    pub motions: Vec<PartMotion>,
    /// For each point, the nearest point of its part's turning axis; unit cube.
    pub axis_points: Vec<[f32; 3]>,
}

impl Decision {
    /// Plücker coordinates (l, m = l × p) of a slot's turning axis; zero where it has none.
    pub fn pluecker(&self, slot: usize) -> [f64; 6] {
        let motion = &self.motions[slot];
        let Some(pivot) = motion.pivot.filter(|_| motion.revolute) else { return [0.0; 6] };
        let (l, m) = (motion.revolute_axis, motion.revolute_axis.cross(pivot));
        [l.x, l.y, l.z, m.x, m.y, m.z]
    }
}

impl Particulate {
    /// Decides. Slots whose points are less sure of them than `least_confidence` (geometric mean of
    /// the probabilities, 0 to 1) are given up, but never the last one.
    ///
    /// # Errors
    /// [`WeightsError::NotFinite`] naming the head that gave NaN or infinity.
    pub fn decide(
        &self,
        raw: &RawParticulate,
        least_confidence: f64,
    ) -> Result<Decision, WeightsError> {
        let (part_of_point, used) = prune(&raw.mask, raw.parts, least_confidence);
        let axis_points = self.axis_points(raw, &part_of_point)?;
        let motions = (0..raw.parts).map(|slot| {
            let mine = part_of_point.iter().zip(&axis_points);
            let mine = mine.filter(|(p, _)| usize::from(**p) == slot).map(|(_, c)| *c).collect();
            motion(raw, slot, mine)
        });
        let motions = motions.collect();
        let tree = tree(raw, &used);
        Ok(Decision { part_of_point, used, tree, motions, axis_points })
    }
}

/// The slot of each point after giving up unsure ones, and which slots are left.
fn prune(mask: &[f32], parts: usize, least: f64) -> (Vec<u16>, Vec<bool>) {
    let mut open = vec![true; parts];
    let mut labels = choose(mask, parts, &open);
    open = in_use(&labels, parts);
    loop {
        let sure = confidence(mask, parts, &open, &labels);
        let unsure = |p: &usize| open[*p] && sure[*p] < least;
        let mut doomed: Vec<usize> = (0..parts).filter(unsure).collect();
        if doomed.len() == open.iter().filter(|o| **o).count() {
            doomed.pop();
        }
        let Some(_) = doomed.first() else { return (labels, open) };
        doomed.iter().for_each(|&p| open[p] = false);
        labels = choose(mask, parts, &open);
        let chosen = in_use(&labels, parts);
        open.iter_mut().zip(chosen).for_each(|(o, c)| *o &= c);
    }
}

/// The open slot with the highest score, the first of equals.
fn choose(mask: &[f32], parts: usize, open: &[bool]) -> Vec<u16> {
    let first = open.iter().position(|&o| o).unwrap_or(0);
    let best = |row: &[f32]| {
        let better = |b: usize, p: usize| if open[p] && row[p] > row[b] { p } else { b };
        (first..parts).fold(first, better) as u16
    };
    mask.chunks_exact(parts).map(best).collect()
}

fn in_use(labels: &[u16], parts: usize) -> Vec<bool> {
    let mut used = vec![false; parts];
    labels.iter().for_each(|&p| used[usize::from(p)] = true);
    used
}

/// Geometric mean, over a slot's points, of the probability they give it among the open slots.
fn confidence(mask: &[f32], parts: usize, open: &[bool], labels: &[u16]) -> Vec<f64> {
    let (mut log, mut count) = (vec![0.0; parts], vec![0.0; parts]);
    for (row, &label) in mask.chunks_exact(parts).zip(labels) {
        let own = f64::from(row[usize::from(label)]);
        let others = row.iter().zip(open).filter(|(_, o)| **o);
        let total: f64 = others.map(|(s, _)| (f64::from(*s) - own).exp()).sum();
        log[usize::from(label)] -= total.ln();
        count[usize::from(label)] += 1.0;
    }
    log.iter().zip(count).map(|(l, c): (&f64, f64)| (l / c.max(1.0)).exp()).collect()
}

/// The best tree over the slots in use, by the logarithm of the parent probabilities.
fn tree(raw: &RawParticulate, used: &[bool]) -> Vec<(u16, u16)> {
    let slots: Vec<usize> = (0..raw.parts).filter(|&p| used[p]).collect();
    let log_sigmoid = |x: f64| x.min(0.0) - (-x.abs()).exp().ln_1p();
    let weight = |u: &usize, v: &usize| log_sigmoid(f64::from(raw.adjacency[u * raw.parts + v]));
    let weights: Vec<Vec<f64>> =
        slots.iter().map(|u| slots.iter().map(|v| weight(u, v)).collect()).collect();
    let parents = best_arborescence(&weights);
    let edge = |(child, parent): (usize, &Option<usize>)| {
        parent.map(|parent| (slots[parent] as u16, slots[child] as u16))
    };
    parents.iter().enumerate().filter_map(edge).collect()
}

fn motion(raw: &RawParticulate, slot: usize, votes: Vec<[f32; 3]>) -> PartMotion {
    let scores = &raw.motion[4 * slot..][..4];
    let class = (1..4).fold(0, |best, c| if scores[c] > scores[best] { c } else { best });
    let five = |from: &[f32]| {
        let v: [f64; 5] = std::array::from_fn(|i| from[5 * slot + i].into());
        let axis = DVec3::new(v[0], v[1], v[2]);
        (axis / axis.length().max(1e-8), [v[3], v[4]])
    };
    let (revolute_axis, revolute_range) = five(&raw.revolute);
    let (prismatic_axis, prismatic_range) = five(&raw.prismatic);
    PartMotion {
        revolute: class == 1 || class == 3,
        prismatic: class == 2 || class == 3,
        revolute_axis,
        pivot: median(votes),
        revolute_range,
        prismatic_axis,
        prismatic_range,
    }
}

/// The median of each coordinate, of an even count the mean of the two in the middle; `None` without
/// points.
fn median(points: Vec<[f32; 3]>) -> Option<DVec3> {
    let middle = |axis: usize| {
        let mut values: Vec<f32> = points.iter().map(|p| p[axis]).collect();
        values.sort_unstable_by(f32::total_cmp);
        let (low, high) = (values.len().saturating_sub(1) / 2, values.len() / 2);
        Some((f64::from(*values.get(low)?) + f64::from(*values.get(high)?)) / 2.0)
    };
    Some(DVec3::new(middle(0)?, middle(1)?, middle(2)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unsure_slots_are_given_up_but_never_the_last() {
        // Two points sure of slot 0, one that barely prefers slot 2.
        let mask = [5.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, -9.0, 0.1];
        assert_eq!(prune(&mask, 3, 0.0).0, [0, 0, 2]);
        assert_eq!(prune(&mask, 3, 0.6), (vec![0, 0, 0], vec![true, false, false]));
        let flat = [0.1, 0.0, 0.0, 0.1];
        let (labels, open) = prune(&flat, 2, 0.99);
        assert_eq!(labels, [1, 1]);
        assert_eq!(open, [false, true]);
    }

    #[test]
    fn the_median_of_an_even_count_lies_between_the_two_in_the_middle() {
        let points = vec![[1.0, 4.0, 0.0], [2.0, 3.0, 0.0], [3.0, 2.0, 0.0], [9.0, 1.0, 0.0]];
        assert_eq!(median(points), Some(DVec3::new(2.5, 2.5, 0.0)));
        assert_eq!(median(vec![]), None);
    }
}
