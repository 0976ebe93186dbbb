//! Merging on a graph of segments: the pair of clusters with the best mean evidence first, and
//! never two clusters with different labels.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use crate::classic::lexicon::sizes::SizePrior;
use crate::classic::segment::oversegment::segment::Segment;

/// How clusters grow beside the evidence of the borders between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Habits {
    /// What two clusters without a label must be better than one with a label to merge first: a
    /// cluster that waits is still free to go either way.
    pub patience: f64,
    /// How much it counts that another label is nearer, see [`label`].
    pub nearness: f64,
    /// How much the usual sizes of parts count.
    pub size: f64,
}

/// Most by which another label's being nearer counts, before [`Habits::nearness`].
const NEARNESS_CAP: f64 = 5.0;

/// A link between two segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Link {
    /// One segment.
    pub a: u32,
    /// The other.
    pub b: u32,
    /// Evidence that both belong together; log-odds where parts are decided.
    pub evidence: f64,
    /// How much the link counts in the mean over all links between two clusters.
    pub weight: f64,
    /// What it costs to pass from one to the other on the way to a prompt.
    pub barrier: f64,
}

/// The cluster a segment ended up in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Group {
    /// The cluster's number: segments of one number are linked.
    pub number: u32,
    /// Its label; `None` if no link leads to a seed.
    pub label: Option<u16>,
}

/// Groups the segments by merging while the mean evidence between two groups is above `stop`, for each of
/// some such bounds: the merging is one and the same, it only ends sooner or later. Says for each bound the
/// group of each segment, numbered in order of first segment, and how many there are.
pub(crate) fn groups(segments: usize, links: &[Link], stops: &[f64]) -> Vec<(Vec<u32>, usize)> {
    let mut clusters = Clusters::new(vec![None; segments], links);
    clusters.start(stops.iter().copied().fold(f64::INFINITY, f64::min));
    let mut order: Vec<usize> = (0..stops.len()).collect();
    order.sort_by(|&a, &b| stops[b].total_cmp(&stops[a]));
    let mut found = vec![(Vec::new(), 0); stops.len()];
    for place in order {
        clusters.merge(stops[place]);
        let mut number = vec![None; segments];
        let mut count = 0;
        let of_segment = (0..segments as u32).map(|p| {
            *number[clusters.find(p) as usize].get_or_insert_with(|| {
                count += 1;
                count - 1
            })
        });
        found[place].0 = of_segment.collect();
        found[place].1 = count as usize;
    }
    found
}

/// Gives every segment that links (over other segments) to a seeded one the label of its cluster.
///
/// Besides the links' evidence, two things decide which cluster grows. One is its size: a part that
/// its words call small is slow to take in something large. The other is `far`, the distance of
/// each segment from each label on a logarithmic scale: what is nearer to another label comes
/// later. Merging goes on, however weak the evidence, until no unlabelled segment touches a label
/// that may have it. Ties go to the lower segment features.
pub(crate) fn label(
    segments: &[Segment],
    links: &[Link],
    priors: &[SizePrior],
    (far, habits): (Vec<Vec<f64>>, Habits),
) -> Vec<Group> {
    let mut clusters = Clusters::new(segments.iter().map(|p| p.seed).collect(), links);
    let weigh = |(mut ways, p): (Vec<f64>, &Segment)| {
        ways.iter_mut().for_each(|w| *w *= p.share);
        Reach { share: p.share, ways }
    };
    let reach = far.into_iter().zip(segments).map(weigh).collect();
    clusters.growth = Some(Growth { priors, habits, reach });
    clusters.start(f64::NEG_INFINITY);
    clusters.merge(f64::NEG_INFINITY);
    let group = |p: usize| {
        let number = clusters.find(p as u32);
        Group { number, label: clusters.label[number as usize] }
    };
    (0..segments.len()).map(group).collect()
}

/// A pair of clusters that may merge; out of date once its stamp is not its border's any more.
#[derive(Clone, Copy, PartialEq)]
struct Candidate {
    score: f64,
    a: u32,
    b: u32,
    stamp: u32,
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let rest = (other.a, other.b, other.stamp).cmp(&(self.a, self.b, self.stamp));
        self.score.total_cmp(&other.score).then(rest)
    }
}

/// All links between two clusters together.
#[derive(Clone, Copy, Default)]
struct Border {
    evidence: f64,
    weight: f64,
    stamp: u32,
}

/// What clusters weigh when they grow.
struct Growth<'a> {
    priors: &'a [SizePrior],
    habits: Habits,
    reach: Vec<Reach>,
}

/// A cluster's share of the surface, and how far it is from each label, summed by share.
#[derive(Clone, Default)]
struct Reach {
    share: f64,
    ways: Vec<f64>,
}

struct Clusters<'a> {
    label: Vec<Option<u16>>,
    into: Vec<u32>,
    around: Vec<BTreeMap<u32, Border>>,
    heap: BinaryHeap<Candidate>,
    /// What is no better than this is never merged.
    stop: f64,
    growth: Option<Growth<'a>>,
}

impl Clusters<'_> {
    fn new(label: Vec<Option<u16>>, links: &[Link]) -> Self {
        let n = label.len();
        let (into, around) = ((0..n as u32).collect(), vec![BTreeMap::new(); n]);
        let (heap, stop) = (BinaryHeap::new(), f64::NEG_INFINITY);
        let mut new = Self { label, into, around, heap, stop, growth: None };
        for link in links.iter().filter(|l| l.a != l.b) {
            let evidence = link.evidence * link.weight;
            new.add(link.a, link.b, Border { evidence, weight: link.weight, stamp: 0 });
        }
        new
    }

    /// Offers every pair that has a border and may merge before the evidence falls to `stop`.
    fn start(&mut self, stop: f64) {
        self.stop = stop;
        for a in 0..self.label.len() as u32 {
            let later: Vec<_> =
                self.around[a as usize].range(a + 1..).map(|(&b, &s)| (b, s)).collect();
            later.into_iter().for_each(|(b, border)| self.offer(a, b, border));
        }
    }

    /// Merges until the best evidence is no more than `stop`, which is at least that of the start.
    fn merge(&mut self, stop: f64) {
        while let Some(&top) = self.heap.peek() {
            if top.score <= stop {
                return;
            }
            self.heap.pop();
            let border = self.around[top.a as usize].get(&top.b);
            if border.is_some_and(|b| b.stamp == top.stamp) {
                self.join(top.a, top.b);
            }
        }
    }

    fn find(&self, mut p: u32) -> u32 {
        while self.into[p as usize] != p {
            p = self.into[p as usize];
        }
        p
    }

    fn offer(&mut self, a: u32, b: u32, border: Border) {
        let (la, lb) = (self.label[a as usize], self.label[b as usize]);
        if la.is_some() && lb.is_some() && la != lb {
            return;
        }
        let mean = border.evidence / border.weight.max(f64::MIN_POSITIVE);
        let score = mean + self.growth.as_ref().map_or(0.0, |g| g.score((a, la), (b, lb)));
        // Merging is over with the first candidate of this kind.
        if score <= self.stop {
            return;
        }
        self.heap.push(Candidate { score, a: a.min(b), b: a.max(b), stamp: border.stamp });
    }

    /// Merges the cluster with fewer neighbours into the other.
    fn join(&mut self, a: u32, b: u32) {
        let fewer = self.around[a as usize].len() < self.around[b as usize].len();
        let (keep, gone) = if fewer { (b, a) } else { (a, b) };
        self.label[keep as usize] = self.label[keep as usize].or(self.label[gone as usize]);
        self.into[gone as usize] = keep;
        if let Some(growth) = &mut self.growth {
            growth.merge(keep, gone);
        }
        let mut moved = std::mem::take(&mut self.around[gone as usize]);
        self.around[keep as usize].remove(&gone);
        moved.remove(&keep);
        for (&other, &border) in &moved {
            self.around[other as usize].remove(&gone);
            self.add(keep, other, border);
        }
        let grows = self.growth.is_some();
        let here = self.label[keep as usize].is_some();
        let around = self.around[keep as usize].keys().copied();
        let stale = |o: &u32| grows && (here || self.label[*o as usize].is_some());
        let changed: Vec<u32> = around.filter(|o| stale(o) || moved.contains_key(o)).collect();
        for other in changed {
            let border = self.add(keep, other, Border::default());
            self.offer(keep, other, border);
        }
    }

    /// Adds to the border between two clusters, on both sides; old candidates go out of date.
    fn add(&mut self, p: u32, q: u32, more: Border) -> Border {
        let border = self.around[p as usize].entry(q).or_default();
        border.evidence += more.evidence;
        border.weight += more.weight;
        border.stamp = border.stamp.max(more.stamp) + 1;
        let sum = *border;
        self.around[q as usize].insert(p, sum);
        sum
    }
}

impl Growth<'_> {
    /// What speaks for making two clusters one, beside the border between them.
    fn score(&self, a: (u32, Option<u16>), b: (u32, Option<u16>)) -> f64 {
        let (part, grown, taken) = match (a, b) {
            ((a, Some(part)), (b, None)) | ((b, None), (a, Some(part))) => (part, a, b),
            _ => return -self.habits.patience,
        };
        let (grown, taken) = (&self.reach[grown as usize], &self.reach[taken as usize]);
        let after = grown.share + taken.share;
        let size = match self.priors.get(usize::from(part)) {
            Some(prior) if !prior.allows(after) => f64::NEG_INFINITY,
            Some(prior) => self.habits.size * (prior.score(after) - prior.score(grown.share)),
            None => 0.0,
        };
        size - self.habits.nearness * taken.detour(part)
    }

    fn merge(&mut self, keep: u32, gone: u32) {
        let gone = std::mem::take(&mut self.reach[gone as usize]);
        let keep = &mut self.reach[keep as usize];
        keep.share += gone.share;
        keep.ways.iter_mut().zip(gone.ways).for_each(|(k, g)| *k += g);
    }
}

impl Reach {
    /// How much farther `part` is than the nearest label, in the mean.
    fn detour(&self, part: u16) -> f64 {
        let best = self.ways.iter().copied().fold(f64::INFINITY, f64::min);
        let way = self.ways.get(usize::from(part)).copied().unwrap_or(best);
        ((way - best) / self.share.max(1e-12)).min(NEARNESS_CAP)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use object::DVec3;
    use object::mesh::Bounds;

    fn link(a: u32, b: u32, evidence: f64) -> Link {
        Link { a, b, evidence, weight: 1.0, barrier: 0.0 }
    }

    fn segment(seed: Option<u16>, share: f64) -> Segment {
        let (bounds, zero) = (Bounds::of([DVec3::ZERO, DVec3::ONE]), DVec3::ZERO);
        Segment { seed, share, area: share, centre: zero, bounds, normal: zero }
    }

    fn labels(segments: &[Segment], links: &[Link], texts: &[&str]) -> Vec<Option<u16>> {
        let prior = |(i, t): (usize, &&str)| SizePrior::of(t, i == 0);
        let priors: Vec<_> = texts.iter().enumerate().map(prior).collect();
        let far = vec![vec![0.0; texts.len()]; segments.len()];
        let habits = Habits { patience: 0.3, nearness: 0.7, size: 1.0 };
        label(segments, links, &priors, (far, habits)).iter().map(|g| g.label).collect()
    }

    #[test]
    fn groups_stop_where_the_mean_evidence_falls_short() {
        let links = [link(0, 1, 2.0), link(1, 2, 0.5), link(2, 3, 2.0), link(0, 3, 1.0)];
        assert_eq!(groups(5, &links, &[0.8]), [(vec![0, 0, 1, 1, 2], 3)]);
        assert_eq!(groups(5, &links, &[0.7])[0].1, 2, "the mean of 0.5 and 1.0 is 0.75");
    }

    #[test]
    fn groups_for_several_bounds_are_those_for_each_alone() {
        let mut state = 7_u32;
        let mut next = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        };
        let mut any = || link(next() % 60, next() % 60, f64::from(next() % 9) / 4.0 - 1.0);
        let links: Vec<Link> = (0..150).map(|_| any()).collect();
        let stops = [0.2, -0.3, 0.9, 0.2, f64::NEG_INFINITY];
        let alone = stops.map(|stop| groups(60, &links, &[stop]).remove(0));
        assert_eq!(groups(60, &links, &stops), alone);
    }

    #[test]
    fn labels_spread_along_the_stronger_link_and_never_meet() {
        let segments =
            [segment(Some(0), 0.4), segment(None, 0.1), segment(Some(1), 0.4), segment(None, 0.1)];
        let links = [link(0, 1, 1.0), link(1, 2, 3.0), link(0, 2, 9.0)];
        let got = labels(&segments, &links, &["body", "door"]);
        assert_eq!(got, [Some(0), Some(1), Some(1), None]);
    }

    #[test]
    fn a_button_does_not_swallow_a_cabinet() {
        let segments = [segment(Some(0), 0.1), segment(None, 0.89), segment(Some(1), 0.01)];
        let links = [link(0, 1, 1.0), link(1, 2, 5.0)];
        assert_eq!(labels(&segments, &links, &["body", "button"])[1], Some(0));
        assert_eq!(labels(&segments, &links[1..], &["body", "button"])[1], None);
    }
}
