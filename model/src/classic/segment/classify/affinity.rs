//! Affinity: how likely segments are of one part, along paths of neighbours, and what follows from
//! that for each segment and part.

use crate::classic::segment::classify::facts::Probabilities;
use crate::classic::segment::classify::pairwise::SegmentPair;
use crate::classic::segment::oversegment::flood::costs_from;
use crate::classic::segment::oversegment::hurdles::Hurdles;

/// Features of a segment and a part that follow from which neighbours are of one part.
pub(crate) const AFFINITY_FEATURES: usize = 10;
/// What they are called, in order.
pub(crate) const AFFINITY_NAMES: [&str; AFFINITY_FEATURES] = [
    "affinity_path",
    "affinity_path_over_least",
    "affinity_worst",
    "affinity_worst_over_other",
    "affinity_to_seed",
    "affinity_to_parent_seed",
    "affinity_agreed",
    "affinity_best",
    "affinity_lead",
    "affinity_none",
];

/// No pair is less likely than this to join segments of one part.
const LEAST: f32 = 1e-6;
/// Surprise of what cannot be reached.
const FAR: f64 = 30.0;
/// What is said of segments that do not meet.
const APART: f64 = -1.0;

/// Which neighbours are of one part, and what follows from that.
#[derive(Clone, Debug, Default)]
pub(crate) struct Affinity {
    /// For each pair, how likely its segments are of one part.
    chances: Vec<f32>,
    /// For each segment, its neighbours and how likely each is of the same part.
    around: Vec<Vec<(u32, f32)>>,
    /// For each segment and part with a prompt.
    ways: Vec<Vec<Option<Way>>>,
}

/// What lies between a segment and the prompts of a part. Surprise is −ln of a chance.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// Surprise that all steps stay in one part, where that is least.
    sum: f64,
    /// Surprise of the worst step, where that is least.
    worst: f64,
    /// The sum to the nearest part.
    least_sum: f64,
    /// The worst step to the nearest other part.
    other_worst: f64,
    /// How likely segment and prompt are of one part, if they meet.
    direct: f64,
    /// How likely segment and the parent's prompt are of one part, if they meet.
    direct_parent: f64,
}

/// A part as far as it matters here.
pub(crate) struct Prompted<'a> {
    /// The segments that its prompts lie on.
    pub seeds: &'a [u32],
    /// What it hangs on.
    pub parent: Option<usize>,
}

impl Affinity {
    /// What follows from the chances of pairs, where `seed_of` is the part whose prompt lies on each
    /// segment. No way leads on from a segment with a prompt.
    pub(crate) fn of(
        (segment_pairs, chances): (&[SegmentPair], &[f32]),
        seed_of: &[Option<u16>],
        parts: &[Prompted<'_>],
    ) -> Self {
        let mut around = vec![Vec::new(); seed_of.len()];
        for (segment_pair, &chance) in segment_pairs.iter().zip(chances) {
            around[segment_pair.small as usize].push((segment_pair.large, chance));
            around[segment_pair.large as usize].push((segment_pair.small, chance));
        }
        let ways = ways(&around, seed_of, parts);
        Self { chances: chances.to_vec(), around, ways }
    }

    /// For each pair, how likely its segments are of one part.
    pub(crate) fn chances(&self) -> &[f32] {
        &self.chances
    }

    /// For each part, how likely it is of a neighbour and that neighbour of one part with the segment, where
    /// that is likeliest; nothing where nothing was said of pairs.
    pub(crate) fn best(&self, segment: usize, probabilities: &Probabilities) -> Vec<f64> {
        let mut best = vec![0.0; probabilities[segment].len()];
        for &(other, chance) in self.around.get(segment).into_iter().flatten() {
            for (best, &b) in best.iter_mut().zip(&probabilities[other as usize]) {
                *best = f64::max(*best, f64::from(chance) * f64::from(b));
            }
        }
        best
    }

    /// The affinity features of a segment and a part, under these class probabilities and what is
    /// [`best`](Self::best) of them; zeros where nothing was said of pairs.
    pub(crate) fn features(
        &self,
        (segment, part): (usize, usize),
        probabilities: &Probabilities,
        best: &[f64],
    ) -> [f64; AFFINITY_FEATURES] {
        let Some(way) = self.ways.get(segment).and_then(|w| w[part]) else {
            return [0.0; AFFINITY_FEATURES];
        };
        let (mut agreed, mut asked, mut nobody) = (0.0, 0.0, 1.0);
        for &(other, chance) in &self.around[segment] {
            let (estimated, chance) = (&probabilities[other as usize], f64::from(chance));
            agreed += chance * f64::from(estimated[part]);
            asked += chance;
            nobody *= 1.0 - chance * f64::from(estimated[part]);
        }
        let others = best.iter().enumerate().filter(|b| b.0 != part).map(|b| *b.1);
        [
            way.sum,
            way.sum - way.least_sum,
            way.worst,
            way.worst - way.other_worst,
            way.direct,
            way.direct_parent,
            if asked > 0.0 { agreed / asked } else { 0.0 },
            best[part],
            best[part] - others.fold(0.0, f64::max),
            nobody,
        ]
    }
}

fn ways(
    around: &[Vec<(u32, f32)>],
    seed_of: &[Option<u16>],
    parts: &[Prompted<'_>],
) -> Vec<Vec<Option<Way>>> {
    let negative_log_likelihood =
        |&(i, chance): &(u32, f32)| (i, -f64::from(chance.max(LEAST)).ln());
    let roads: Vec<Vec<(u32, f64)>> =
        around.iter().map(|n| n.iter().map(negative_log_likelihood).collect()).collect();
    let is_seeded = |n: u32| seed_of[n as usize].is_some();
    let least = |costs: Vec<f64>| costs.into_iter().map(|cost| cost.min(FAR)).collect();
    let sum = |p: &Prompted| least(costs_from(&roads, p.seeds, is_seeded));
    let hurdles = Hurdles::of(&roads, is_seeded);
    let worst = |p: &Prompted| least(hurdles.from(p.seeds));
    let sums: Vec<Vec<f64>> = parts.iter().map(sum).collect();
    let worsts: Vec<Vec<f64>> = parts.iter().map(worst).collect();
    let direct = |segment: usize, part: usize| {
        let is_seed = |n: &&(u32, f32)| seed_of[n.0 as usize].map(usize::from) == Some(part);
        let met = around[segment].iter().filter(is_seed).map(|n| f64::from(n.1));
        met.fold(APART, f64::max)
    };
    let one = |segment: usize, part: usize| {
        parts[part].seeds.first()?;
        let others = (0..parts.len()).filter(|&p| p != part);
        Some(Way {
            sum: sums[part][segment],
            worst: worsts[part][segment],
            least_sum: sums.iter().map(|s| s[segment]).fold(FAR, f64::min),
            other_worst: others.map(|p| worsts[p][segment]).fold(FAR, f64::min),
            direct: direct(segment, part),
            direct_parent: parts[part].parent.map_or(APART, |p| direct(segment, p)),
        })
    };
    (0..around.len())
        .map(|segment| (0..parts.len()).map(|part| one(segment, part)).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classic::segment::classify::pairwise::PAIR_FEATURES;

    /// Five segments in a row, the first with the prompt of part 0, the last with that of part 1; a third
    /// part has no prompt.
    fn row(chances: [f32; 4]) -> (Affinity, Probabilities) {
        let segment_pair =
            |small: u32| SegmentPair { small, large: small + 1, features: [0.0; PAIR_FEATURES] };
        let segment_pairs: Vec<SegmentPair> = (0..4).map(segment_pair).collect();
        let parts = [
            Prompted { seeds: &[0], parent: None },
            Prompted { seeds: &[4], parent: Some(0) },
            Prompted { seeds: &[], parent: Some(0) },
        ];
        let affinity =
            Affinity::of((&segment_pairs, &chances), &[Some(0), None, None, None, Some(1)], &parts);
        let mut probabilities = vec![vec![0.0; 3]; 5];
        (probabilities[0][0], probabilities[4][1]) = (1.0, 1.0);
        (affinity, probabilities)
    }

    fn said(
        affinity: &Affinity,
        (segment, part): (usize, usize),
        probabilities: &Probabilities,
    ) -> [f64; AFFINITY_FEATURES] {
        let best = affinity.best(segment, probabilities);
        affinity.features((segment, part), probabilities, &best)
    }

    #[test]
    fn a_way_is_as_surprising_as_its_steps_together_and_its_worst_step_counts_apart() {
        let (affinity, probabilities) = row([0.5, 0.25, 0.5, 0.9]);
        let [sum, longer, worst, behind, ..] = said(&affinity, (2, 0), &probabilities);
        assert!((sum - 8f64.ln()).abs() < 1e-6 && (worst - 4f64.ln()).abs() < 1e-6);
        let to_other = -(0.45f64.ln());
        assert!((longer - (8f64.ln() - to_other)).abs() < 1e-6, "{longer}");
        assert!((behind - 2f64.ln()).abs() < 1e-6, "{behind}");
    }

    #[test]
    fn neighbours_speak_for_what_is_believed_of_them() {
        let (affinity, probabilities) = row([0.5, 0.25, 0.5, 0.75]);
        let [.., direct, parent, agreed, best, lead, nobody] =
            said(&affinity, (3, 1), &probabilities);
        assert_eq!((direct, parent), (0.75, APART));
        assert!((agreed - 0.6).abs() < 1e-6 && (best, lead, nobody) == (0.75, 0.75, 0.25));
        let [.., direct, _, agreed, best, lead, nobody] = said(&affinity, (3, 0), &probabilities);
        assert_eq!((direct, agreed, best, lead, nobody), (APART, 0.0, 0.0, -0.75, 1.0));
    }

    #[test]
    fn of_what_has_no_prompt_or_was_never_told_of_kin_nothing_is_said() {
        let (affinity, probabilities) = row([0.5; 4]);
        assert_eq!(said(&affinity, (1, 2), &probabilities), [0.0; AFFINITY_FEATURES]);
        assert_eq!(said(&Affinity::default(), (1, 0), &probabilities), [0.0; AFFINITY_FEATURES]);
    }
}
