//! Connectivity clean-up: segments that were given to a part but lie apart from it, or that were
//! hardly won from another part.

use std::collections::BTreeSet;

use crate::classic::segment::classify::{Layout, Probabilities};

/// Segments side by side leave the part that merging gives them together if another is likelier by this
/// power of e: class probabilities err together, and merging, where they are of two minds, less often.
const PERSUADED: f64 = 0.5;
/// What lies apart stays of its part if that is likelier than any beside it by this power of e.
const PATIENCE: f64 = 1.0;
/// No part is less likely than this.
const LEAST: f32 = 1e-4;

/// The part of each segment: the likeliest one, with two exceptions.
///
/// - A group that lies apart from the rest of its part, with no prompt on it, goes to the likeliest
///   part beside it, unless its own is much likelier.
/// - Except on a fused mesh, merging's part stands where another part is hardly likelier.
pub(crate) fn gathered(layout: &Layout, probabilities: &Probabilities, is_fused: bool) -> Vec<u16> {
    let segments = 0..layout.len();
    let ground = Ground {
        beside: segments.clone().map(|p| layout.beside(p).collect()).collect(),
        share: segments.clone().map(|p| layout.share(p)).collect(),
        seed: segments.clone().map(|p| layout.seed(p)).collect(),
    };
    let mut labels = ground.gathered(probabilities);
    if !is_fused {
        let merged: Vec<Option<u16>> = segments.map(|p| layout.merged(p)).collect();
        ground.keep(&mut labels, &merged, probabilities);
    }
    labels
}

/// Segments as far as it matters here.
pub(crate) struct Ground {
    /// The segments that each meets.
    pub beside: Vec<Vec<usize>>,
    /// Shares of the surface.
    pub share: Vec<f64>,
    /// The parts whose prompts lie on them.
    pub seed: Vec<Option<usize>>,
}

impl Ground {
    /// The likeliest part of each segment, save that what lies apart goes to the likeliest beside it, unless
    /// its own is much likelier.
    pub(crate) fn gathered(&self, probabilities: &Probabilities) -> Vec<u16> {
        let mut labels: Vec<u16> = probabilities.iter().map(|row| likeliest(row)).collect();
        loop {
            let mut moved = false;
            for stray in self.strays(&labels) {
                if let Some(part) = self.better(&stray, &labels, probabilities) {
                    stray.iter().for_each(|&segment| labels[segment] = part);
                    moved = true;
                }
            }
            // Every move joins groups, so there is an end to it.
            if !moved {
                return labels;
            }
        }
    }

    /// What segments side by side were given against what merging says is taken back where it is hardly
    /// likelier of all of them.
    fn keep(&self, labels: &mut [u16], merged: &[Option<u16>], probabilities: &Probabilities) {
        let pairs: Vec<(u16, u16)> =
            labels.iter().zip(merged).map(|(&label, m)| (label, m.unwrap_or(label))).collect();
        for group in self.groups(&pairs) {
            let (label, merged) = pairs[group[0]];
            if label != merged && self.odds(&group, (label, merged), probabilities) < PERSUADED {
                group.iter().for_each(|&segment| labels[segment] = merged);
            }
        }
    }

    /// Connected segments of which the same is said.
    fn groups<T: PartialEq>(&self, said: &[T]) -> Vec<Vec<usize>> {
        let mut seen = vec![false; said.len()];
        let mut groups = Vec::new();
        for first in 0..said.len() {
            if seen[first] {
                continue;
            }
            seen[first] = true;
            let (mut group, mut next) = (vec![first], 0);
            while let Some(&segment) = group.get(next) {
                next += 1;
                for &other in &self.beside[segment] {
                    if !seen[other] && said[other] == said[first] {
                        seen[other] = true;
                        group.push(other);
                    }
                }
            }
            groups.push(group);
        }
        groups
    }

    /// Connected segments of one part without a prompt of that part, smallest first; each in order.
    fn strays(&self, labels: &[u16]) -> Vec<Vec<usize>> {
        let mut strays = self.groups(labels);
        strays.retain(|group| {
            let part = usize::from(labels[group[0]]);
            group.iter().all(|&segment| self.seed[segment] != Some(part))
        });
        strays.iter_mut().for_each(|group| group.sort_unstable());
        let share = |group: &[usize]| self.sum(group, |_| 1.0);
        strays.sort_by(|a, b| share(a).total_cmp(&share(b)).then(a.cmp(b)));
        strays
    }

    /// The part beside a stray that it had better be of, if any; none where it is no stray any more.
    fn better(
        &self,
        stray: &[usize],
        labels: &[u16],
        probabilities: &Probabilities,
    ) -> Option<u16> {
        let own = labels[stray[0]];
        let around = stray.iter().flat_map(|&segment| &self.beside[segment]);
        let around = around.filter(|segment| stray.binary_search(segment).is_err());
        let parts: BTreeSet<u16> = around.map(|&segment| labels[segment]).collect();
        if parts.contains(&own) {
            return None;
        }
        let judged =
            parts.into_iter().map(|part| (part, self.odds(stray, (part, own), probabilities)));
        let best = judged.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (best.1 > -PATIENCE).then_some(best.0)
    }

    /// By which power of e one part is likelier than another, on average over the surface of segments.
    fn odds(
        &self,
        segments: &[usize],
        (one, other): (u16, u16),
        probabilities: &Probabilities,
    ) -> f64 {
        let ln = |segment: usize, part: u16| {
            f64::from(probabilities[segment][usize::from(part)].max(LEAST)).ln()
        };
        let whole = self.sum(segments, |_| 1.0).max(f64::MIN_POSITIVE);
        self.sum(segments, |segment| ln(segment, one) - ln(segment, other)) / whole
    }

    /// A sum over segments by their share of the surface.
    fn sum(&self, segments: &[usize], of: impl Fn(usize) -> f64) -> f64 {
        segments.iter().map(|&segment| self.share[segment] * of(segment)).sum()
    }
}

fn likeliest(row: &[f32]) -> u16 {
    let better = |best: usize, part: usize| if row[part] > row[best] { part } else { best };
    (0..row.len()).reduce(better).unwrap_or(0) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Segments in a row, the first with the prompt of part 0, the last with that of part 1.
    fn row(count: usize) -> Ground {
        let beside = |i: usize| [i.checked_sub(1), (i + 1 < count).then_some(i + 1)];
        let seed = |i: usize| match i {
            0 => Some(0),
            i if i + 1 == count => Some(1),
            _ => None,
        };
        Ground {
            beside: (0..count).map(|i| beside(i).into_iter().flatten().collect()).collect(),
            share: vec![1.0 / count as f64; count],
            seed: (0..count).map(seed).collect(),
        }
    }

    /// How likely part 1 is of each segment, as class probabilities.
    fn told(second: &[f32]) -> Probabilities {
        second.iter().map(|&p| vec![1.0 - p, p]).collect()
    }

    #[test]
    fn what_lies_apart_joins_what_lies_beside_it() {
        let probabilities = told(&[0.0, 0.1, 0.6, 0.1, 0.9, 1.0]);
        assert_eq!(row(6).gathered(&probabilities), [0, 0, 0, 0, 1, 1]);
    }

    #[test]
    fn what_is_much_likelier_stays_apart() {
        let probabilities = told(&[0.0, 0.1, 0.8, 0.1, 0.9, 1.0]);
        assert_eq!(row(6).gathered(&probabilities), [0, 0, 1, 0, 1, 1]);
    }

    #[test]
    fn what_reaches_its_prompt_is_no_stray() {
        let probabilities = told(&[0.0, 0.45, 0.55, 0.55, 0.55, 1.0]);
        assert_eq!(row(6).gathered(&probabilities), [0, 0, 1, 1, 1, 1]);
    }

    #[test]
    fn what_is_hardly_likelier_stays_as_merging_says() {
        let merged = [0, 0, 0, 0, 1, 1].map(Some);
        let kept = |second: &[f32]| {
            let mut labels = row(6).gathered(&told(second));
            row(6).keep(&mut labels, &merged, &told(second));
            labels
        };
        assert_eq!(kept(&[0.0, 0.1, 0.55, 0.6, 1.0, 1.0]), [0, 0, 0, 0, 1, 1]);
        assert_eq!(kept(&[0.0, 0.1, 0.55, 0.8, 1.0, 1.0]), [0, 0, 1, 1, 1, 1], "together they are");
        assert_eq!(kept(&[0.0, 0.1, 0.2, 0.2, 0.4, 1.0]), [0, 0, 0, 0, 1, 1]);
    }

    #[test]
    fn what_touches_nothing_stays_what_it_is() {
        let mut ground = row(4);
        ground.beside[1].clear();
        ground.beside[0].clear();
        ground.beside[2] = vec![3];
        assert_eq!(ground.gathered(&told(&[0.0, 0.6, 0.6, 1.0])), [0, 1, 1, 1]);
    }
}
