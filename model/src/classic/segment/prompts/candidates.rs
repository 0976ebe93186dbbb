//! Candidates for parts without points: units that hang together, from single ones to nearly the
//! whole object.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};
use std::ops::Range;

use crate::classic::segment::grow::merge::Link;
use crate::classic::segment::oversegment::units::{Mass, Unit, Units};

/// Everything that could be a part.
#[derive(Debug)]
pub(crate) struct Candidates {
    /// Single units first, then clusters in order of growth.
    pub list: Vec<Candidate>,
    /// The units, such that those of any candidate stand side by side.
    order: Vec<u32>,
}

/// Units that may be one part.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// Where its units stand in the order.
    span: Range<usize>,
    /// All of them together.
    pub mass: Mass,
    /// Evidence over the weakest border inside it; infinite for a single unit.
    pub formed: f64,
    /// Evidence over the border at which it goes up in a larger one; minus infinite if it never does.
    pub left: f64,
    /// The two it grew from.
    halves: Option<[u32; 2]>,
}

impl Candidate {
    /// Where its units stand in the order of all.
    pub(crate) fn span(&self) -> &Range<usize> {
        &self.span
    }

    /// Whether both have a unit in common: then one holds the other.
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        self.span.start < other.span.end && other.span.start < self.span.end
    }
}

impl Candidates {
    /// Every unit, and every cluster that grows when the two with the best mean evidence between
    /// them become one, over and over.
    pub(crate) fn of(units: &Units) -> Self {
        let single = |unit: &Unit| Candidate {
            span: 0..0,
            mass: unit.mass,
            formed: f64::INFINITY,
            left: f64::NEG_INFINITY,
            halves: None,
        };
        let mut growth = Growth::new(units.list.iter().map(single).collect(), &units.links);
        while let Some(best) = growth.heap.pop() {
            if growth.alive[best.a as usize] && growth.alive[best.b as usize] {
                growth.join(best);
            }
        }
        let mut new = Self { list: growth.candidates, order: Vec::new() };
        new.line_up(&growth.alive);
        new
    }

    /// The units of a candidate.
    pub(crate) fn units(&self, candidate: usize) -> &[u32] {
        self.list.get(candidate).map_or(&[], |c| &self.order[c.span.clone()])
    }

    /// Walks each tree of clusters from its root, halves before wholes.
    fn line_up(&mut self, is_root: &[bool]) {
        let roots = (0..self.list.len()).rev().filter(|&c| is_root[c]);
        let mut open: Vec<(usize, bool)> = roots.map(|c| (c, false)).collect();
        while let Some((c, done)) = open.pop() {
            match self.list[c].halves {
                None => {
                    self.list[c].span = self.order.len()..self.order.len() + 1;
                    self.order.push(c as u32);
                }
                Some([a, b]) if done => {
                    let [a, b] = [a, b].map(|h| self.list[h as usize].span.clone());
                    self.list[c].span = a.start.min(b.start)..a.end.max(b.end);
                }
                Some([a, b]) => open.extend([(c, true), (b as usize, false), (a as usize, false)]),
            }
        }
    }
}

/// Two clusters that may become one. A cluster's number is new after each growth, so a pair is out of
/// date once one of the two is gone.
#[derive(Clone, Copy, PartialEq)]
struct Pair {
    evidence: f64,
    a: u32,
    b: u32,
}

impl Eq for Pair {}

impl PartialOrd for Pair {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Pair {
    fn cmp(&self, other: &Self) -> Ordering {
        let rest = (other.a, other.b).cmp(&(self.a, self.b));
        self.evidence.total_cmp(&other.evidence).then(rest)
    }
}

struct Growth {
    candidates: Vec<Candidate>,
    alive: Vec<bool>,
    /// Evidence times weight, and weight, to each living neighbour.
    around: Vec<BTreeMap<u32, (f64, f64)>>,
    heap: BinaryHeap<Pair>,
}

impl Growth {
    fn new(candidates: Vec<Candidate>, links: &[Link]) -> Self {
        let n = candidates.len();
        let mut around = vec![BTreeMap::<u32, (f64, f64)>::new(); n];
        for l in links.iter().filter(|l| l.a != l.b) {
            for (p, q) in [(l.a, l.b), (l.b, l.a)] {
                let border = around[p as usize].entry(q).or_default();
                *border = (border.0 + l.evidence * l.weight, border.1 + l.weight);
            }
        }
        let mut new = Self { candidates, alive: vec![true; n], around, heap: BinaryHeap::new() };
        for a in 0..n as u32 {
            let later: Vec<_> = new.around[a as usize].range(a + 1..).map(|(&b, _)| b).collect();
            later.into_iter().for_each(|b| new.offer(a, b));
        }
        new
    }

    fn offer(&mut self, a: u32, b: u32) {
        if let Some(&(sum, weight)) = self.around[a as usize].get(&b) {
            let evidence = sum / weight.max(f64::MIN_POSITIVE);
            self.heap.push(Pair { evidence, a: a.min(b), b: a.max(b) });
        }
    }

    fn join(&mut self, pair: Pair) {
        let [a, b] = [pair.a as usize, pair.b as usize];
        let new = self.alive.len() as u32;
        let formed = pair.evidence.min(self.candidates[a].formed).min(self.candidates[b].formed);
        let mass = self.candidates[a].mass.with(&self.candidates[b].mass);
        let (halves, left) = (Some([pair.a, pair.b]), f64::NEG_INFINITY);
        self.candidates.push(Candidate { span: 0..0, mass, formed, left, halves });
        let mut around = std::mem::take(&mut self.around[a]);
        for (other, (sum, weight)) in std::mem::take(&mut self.around[b]) {
            let border = around.entry(other).or_default();
            *border = (border.0 + sum, border.1 + weight);
        }
        around.retain(|&other, _| other != pair.a && other != pair.b);
        for old in [a, b] {
            self.alive[old] = false;
            self.candidates[old].left = pair.evidence;
        }
        for (&other, &border) in &around {
            let theirs = &mut self.around[other as usize];
            theirs.remove(&pair.a);
            theirs.remove(&pair.b);
            theirs.insert(new, border);
        }
        let others: Vec<u32> = around.keys().copied().collect();
        self.around.push(around);
        self.alive.push(true);
        others.into_iter().for_each(|other| self.offer(new, other));
    }
}

#[cfg(test)]
mod tests {
    use object::mesh::Bounds;

    use super::*;

    fn units(count: usize, links: &[(u32, u32, f64)]) -> Units {
        let unit = Unit { face: 0, mass: Mass::nothing() };
        let link = |&(a, b, evidence)| Link { a, b, evidence, weight: 1.0, barrier: 0.0 };
        Units {
            of_face: vec![],
            list: vec![unit; count],
            links: links.iter().map(link).collect(),
            touching: BTreeMap::new(),
            bounds: Bounds::of([]),
        }
    }

    #[test]
    fn candidates_grow_over_the_best_border_first() {
        let all = Candidates::of(&units(4, &[(0, 1, 1.0), (1, 2, 3.0), (0, 2, 2.0)]));
        let mut groups: Vec<_> = (0..all.list.len()).map(|c| all.units(c).to_vec()).collect();
        groups.iter_mut().for_each(|g| g.sort_unstable());
        assert_eq!(groups, [vec![0], vec![1], vec![2], vec![3], vec![1, 2], vec![0, 1, 2]]);
        let found = &all.list;
        assert_eq!((found[4].formed, found[4].left), (3.0, 1.5));
        assert_eq!((found[0].formed, found[3].left), (f64::INFINITY, f64::NEG_INFINITY));
        assert!(found[4].overlaps(&found[2]) && !found[4].overlaps(&found[0]));
    }
}
