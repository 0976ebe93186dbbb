//! Seeded merging: pieces join along their strongest links until every piece has a part.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use super::lexicon::{SizePrior, knob};

/// A link between two pieces: the evidence that they are one part (positive) or not (negative),
/// and how much evidence that is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// One piece.
    pub a: u32,
    /// The other.
    pub b: u32,
    /// Log-odds that both belong to one part.
    pub evidence: f64,
    /// How much the link counts when links are averaged.
    pub weight: f64,
}

#[derive(Clone, Copy)]
struct Candidate {
    score: f64,
    a: u32,
    b: u32,
    stamp: u32,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_score = self.score.total_cmp(&other.score);
        by_score.then(other.a.cmp(&self.a)).then(other.b.cmp(&self.b)).then(self.stamp.cmp(&other.stamp))
    }
}

/// A mean of evidence over the links between two clusters.
#[derive(Clone, Copy, Default)]
struct Sum {
    evidence: f64,
    weight: f64,
    stamp: u32,
}

/// Gives every piece that links (over other pieces) to a seeded one the label of its cluster.
///
/// Clusters with the best mean evidence merge first, two clusters with different labels never do,
/// and merging goes on, however weak the evidence, until nothing unlabelled touches anything
/// labelled. Ties go to the lower piece numbers.
pub fn merge(
    seeds: &[Option<u16>],
    share: &[f64],
    links: &[Link],
    priors: &[SizePrior],
) -> Vec<Option<u16>> {
    let mut clusters = Clusters::new(seeds, share, links, priors);
    while let Some(top) = clusters.heap.pop() {
        clusters.try_join(top);
    }
    (0..seeds.len()).map(|p| clusters.label[clusters.find(p as u32) as usize]).collect()
}

struct Clusters<'a> {
    priors: &'a [SizePrior],
    share: Vec<f64>,
    into: Vec<u32>,
    label: Vec<Option<u16>>,
    around: Vec<BTreeMap<u32, Sum>>,
    heap: BinaryHeap<Candidate>,
}

impl<'a> Clusters<'a> {
    fn new(seeds: &[Option<u16>], share: &[f64], links: &[Link], priors: &'a [SizePrior]) -> Self {
        let mut around = vec![BTreeMap::<u32, Sum>::new(); seeds.len()];
        for link in links.iter().filter(|l| l.a != l.b) {
            for (p, q) in [(link.a, link.b), (link.b, link.a)] {
                let sum = around[p as usize].entry(q).or_default();
                sum.evidence += link.evidence * link.weight;
                sum.weight += link.weight;
            }
        }
        let mut new = Self {
            priors,
            share: share.to_vec(),
            into: (0..seeds.len() as u32).collect(),
            label: seeds.to_vec(),
            around,
            heap: BinaryHeap::new(),
        };
        for a in 0..seeds.len() as u32 {
            let later: Vec<_> = new.around[a as usize].range(a + 1..).map(|(&b, &s)| (b, s)).collect();
            later.into_iter().for_each(|(b, sum)| new.offer(a, b, sum));
        }
        new
    }

    fn find(&self, mut p: u32) -> u32 {
        while self.into[p as usize] != p {
            p = self.into[p as usize];
        }
        p
    }

    fn offer(&mut self, a: u32, b: u32, sum: Sum) {
        let (la, lb) = (self.label[a as usize], self.label[b as usize]);
        if la.is_some() && lb.is_some() && la != lb {
            return;
        }
        let score = sum.evidence / sum.weight.max(f64::MIN_POSITIVE) + self.growth(a, b);
        self.heap.push(Candidate { score, a: a.min(b), b: a.max(b), stamp: sum.stamp });
    }

    /// What the size priors say about making two clusters one.
    fn growth(&self, a: u32, b: u32) -> f64 {
        let (a, b) = (a as usize, b as usize);
        let (part, grown) = match (self.label[a], self.label[b]) {
            (Some(p), None) => (p, a),
            (None, Some(p)) => (p, b),
            _ => return -knob("free", 0.0),
        };
        let prior = self.priors[usize::from(part)];
        let bonus = if prior.mean > -0.5 { knob("base", 0.0) } else { 0.0 };
        bonus + prior.cost(self.share[a] + self.share[b]) - prior.cost(self.share[grown])
    }

    fn try_join(&mut self, c: Candidate) {
        let alive = |p: u32| self.into[p as usize] == p;
        if !alive(c.a) || !alive(c.b) {
            return;
        }
        match self.around[c.a as usize].get(&c.b) {
            Some(sum) if sum.stamp == c.stamp => self.join(c.a, c.b),
            _ => {}
        }
    }

    /// Merges the cluster with fewer neighbours into the other.
    fn join(&mut self, a: u32, b: u32) {
        let fewer = self.around[a as usize].len() < self.around[b as usize].len();
        let (keep, gone) = if fewer { (b, a) } else { (a, b) };
        let (mine, theirs) = (self.label[keep as usize], self.label[gone as usize]);
        if mine.is_some() && theirs.is_some() && mine != theirs {
            return;
        }
        self.label[keep as usize] = mine.or(theirs);
        self.into[gone as usize] = keep;
        let moved = std::mem::take(&mut self.around[gone as usize]);
        self.around[keep as usize].remove(&gone);
        self.share[keep as usize] += self.share[gone as usize];
        for (other, sum) in moved.into_iter().filter(|&(o, _)| o != keep) {
            self.around[other as usize].remove(&gone);
            self.add(keep, other, sum);
        }
        let others: Vec<u32> = self.around[keep as usize].keys().copied().collect();
        for other in others {
            let sum = self.add(keep, other, Sum::default());
            self.offer(keep, other, sum);
        }
    }

    fn add(&mut self, p: u32, q: u32, sum: Sum) -> Sum {
        let mine = self.around[p as usize].entry(q).or_default();
        mine.evidence += sum.evidence;
        mine.weight += sum.weight;
        mine.stamp = mine.stamp.max(sum.stamp) + 1;
        let merged = *mine;
        self.around[q as usize].insert(p, merged);
        merged
    }
}
