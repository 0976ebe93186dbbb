//! Merging along a graph: the pair with the best mean evidence first, never two labels into one.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use super::lexicon::{SizePrior, knob};

/// A link between two pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// One piece.
    pub a: u32,
    /// The other.
    pub b: u32,
    /// Evidence that both belong together; log-odds where parts are decided.
    pub evidence: f64,
    /// How much the link counts in the mean over all links between two clusters.
    pub weight: f64,
}

/// Groups the pieces by merging while the mean evidence between two groups is above `stop`.
/// Returns the group of each piece, numbered in order of first piece, and how many there are.
pub fn groups(pieces: usize, links: &[Link], stop: f64) -> (Vec<u32>, usize) {
    let mut clusters = Clusters::new(&vec![None; pieces], &vec![0.0; pieces], &[], links);
    clusters.run(stop);
    let mut number = BTreeMap::new();
    let of_piece = (0..pieces as u32).map(|p| {
        let next = number.len() as u32;
        *number.entry(clusters.find(p)).or_insert(next)
    });
    let of_piece = of_piece.collect();
    (of_piece, number.len())
}

/// Gives every piece that links (over other pieces) to a seeded one the label of its cluster.
///
/// `share` is each piece's share of the whole surface: a cluster whose label is said to be small
/// (by `priors`, one per label) is slow to grow. Merging goes on, however weak the evidence, until
/// nothing unlabelled touches anything labelled. Ties go to the lower piece numbers.
pub fn label(
    seeds: &[Option<u16>],
    share: &[f64],
    priors: &[SizePrior],
    links: &[Link],
) -> Vec<Option<u16>> {
    let mut clusters = Clusters::new(seeds, share, priors, links);
    clusters.run(f64::NEG_INFINITY);
    (0..seeds.len()).map(|p| clusters.label[clusters.find(p as u32) as usize]).collect()
}

/// A pair of clusters that may merge; out of date once its stamp is not its pair's any more.
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

struct Clusters<'a> {
    priors: &'a [SizePrior],
    share: Vec<f64>,
    label: Vec<Option<u16>>,
    into: Vec<u32>,
    around: Vec<BTreeMap<u32, Border>>,
    heap: BinaryHeap<Candidate>,
}

impl<'a> Clusters<'a> {
    fn new(seeds: &[Option<u16>], share: &[f64], priors: &'a [SizePrior], links: &[Link]) -> Self {
        let mut new = Self {
            priors,
            share: share.to_vec(),
            label: seeds.to_vec(),
            into: (0..seeds.len() as u32).collect(),
            around: vec![BTreeMap::new(); seeds.len()],
            heap: BinaryHeap::new(),
        };
        for link in links.iter().filter(|l| l.a != l.b) {
            let border =
                Border { evidence: link.evidence * link.weight, weight: link.weight, stamp: 0 };
            new.add(link.a, link.b, border);
        }
        for a in 0..seeds.len() as u32 {
            let later = new.around[a as usize].range(a + 1..);
            let later: Vec<_> = later.map(|(&b, &border)| (b, border)).collect();
            later.into_iter().for_each(|(b, border)| new.offer(a, b, border));
        }
        new
    }

    fn run(&mut self, stop: f64) {
        while let Some(top) = self.heap.pop() {
            let current = self.around[top.a as usize].get(&top.b);
            let valid = current.is_some_and(|b| b.stamp == top.stamp);
            if valid && top.score > stop {
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
        let score = border.evidence / border.weight.max(f64::MIN_POSITIVE) + self.growth(a, b);
        self.heap.push(Candidate { score, a: a.min(b), b: a.max(b), stamp: border.stamp });
    }

    /// What the size priors say about making two clusters one.
    fn growth(&self, a: u32, b: u32) -> f64 {
        let (a, b) = (a as usize, b as usize);
        let (part, grown) = match (self.label[a], self.label[b]) {
            (Some(p), None) => (p, a),
            (None, Some(p)) => (p, b),
            _ => return -knob("free", 0.7),
        };
        let Some(prior) = self.priors.get(usize::from(part)) else { return 0.0 };
        prior.score(self.share[a] + self.share[b]) - prior.score(self.share[grown])
    }

    /// Merges the cluster with fewer neighbours into the other.
    fn join(&mut self, a: u32, b: u32) {
        let fewer = self.around[a as usize].len() < self.around[b as usize].len();
        let (keep, gone) = if fewer { (b, a) } else { (a, b) };
        let (k, g) = (keep as usize, gone as usize);
        self.label[k] = self.label[k].or(self.label[g]);
        self.share[k] += self.share[g];
        self.into[g] = keep;
        let moved = std::mem::take(&mut self.around[g]);
        self.around[k].remove(&gone);
        let moved: Vec<_> = moved.into_iter().filter(|&(o, _)| o != keep).collect();
        for &(other, border) in &moved {
            self.around[other as usize].remove(&gone);
            self.add(keep, other, border);
        }
        let changed: Vec<u32> = match self.label[k] {
            Some(_) => self.around[k].keys().copied().collect(),
            None => moved.iter().map(|&(o, _)| o).chain(self.labelled_around(keep)).collect(),
        };
        for other in changed {
            let border = self.add(keep, other, Border::default());
            self.offer(keep, other, border);
        }
    }

    fn labelled_around(&self, p: u32) -> Vec<u32> {
        if self.priors.is_empty() {
            return Vec::new();
        }
        let keys = self.around[p as usize].keys().copied();
        keys.filter(|&o| self.label[o as usize].is_some()).collect()
    }

    /// Adds to the border between two clusters, on both sides; the old candidates are out of date.
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
