//! Fewer convex pieces: what lies inside another is dropped, neighbours become one where that
//! fills no hollow.

use super::MAX_PIECES;
use super::solid::Solid;
use super::split::Gate;

/// Merging that fills no fine hollow goes on down to this many pieces.
const FEW: usize = 10;
/// Most pieces wanted of one link; clearing links of each other needs room up to [`MAX_PIECES`].
const WANTED: usize = 24;
/// Two pieces whose hull is larger by this share only are always merged.
const TRIFLE: f64 = 0.01;

/// Merges and drops until at most [`MAX_PIECES`] are left, fewer where the gate holds.
pub(crate) fn merge(mut solids: Vec<Solid>, gate: &Gate, tolerance: f64) -> Vec<Solid> {
    let reach = 1.6 * tolerance;
    drop_inside(&mut solids, 0.1 * gate.clearance, 1);
    let mut pairs = Pairs::of(&solids, reach);
    pairs.merge_while(&mut solids, |solids, p| p.excess < TRIFLE * p.volume && solids > 1, None);
    let mut pairs = Pairs::of(&solids, reach);
    pairs.merge_while(&mut solids, |solids, _| solids > FEW, Some(gate));
    drop_inside(&mut solids, 0.3 * tolerance, WANTED);
    for clearance in [0.2, 0.4, 0.8].map(|share| share * tolerance) {
        let coarse = Gate { clearance: clearance.max(gate.clearance), ..*gate };
        let mut pairs = Pairs::of(&solids, reach);
        pairs.merge_while(&mut solids, |solids, _| solids > WANTED, Some(&coarse));
    }
    drop_inside(&mut solids, 0.6 * tolerance, MAX_PIECES - 6);
    let mut pairs = Pairs::of(&solids, reach);
    pairs.merge_while(&mut solids, |solids, _| solids > MAX_PIECES - 4, None);
    solids.sort_by(|a, b| b.volume().total_cmp(&a.volume()));
    solids.truncate(MAX_PIECES);
    solids
}

/// Drops pieces, smallest first, that lie within `depth` metres of a larger one, while more than
/// `keep` are left.
fn drop_inside(solids: &mut Vec<Solid>, depth: f64, keep: usize) {
    solids.sort_by(|a, b| b.volume().total_cmp(&a.volume()));
    let mut at = solids.len();
    while at > 1 && solids.len() > keep {
        at -= 1;
        let inside = |host: &Solid| {
            let near = host.bounds.grown(depth);
            let small = &solids[at];
            near.min.cmple(small.bounds.min).all()
                && near.max.cmpge(small.bounds.max).all()
                && small.vertices.iter().all(|&v| host.distance(v, depth) <= depth)
        };
        if solids[..at].iter().any(inside) {
            solids.remove(at);
        }
    }
}

/// Two pieces that might become one.
struct Pair {
    first: usize,
    second: usize,
    /// Their hull, its volume and how much of it is in neither, m³.
    hull: Solid,
    volume: f64,
    excess: f64,
}

/// All pairs; piece numbers are never reused, dead pieces are `None` in the list.
struct Pairs {
    pairs: Vec<Pair>,
    /// Pieces farther apart than this, metres, or 5 % of the larger, are no pair.
    reach: f64,
}

impl Pairs {
    fn of(solids: &[Solid], reach: f64) -> Self {
        let mut pairs = Self { pairs: Vec::new(), reach };
        for second in 1..solids.len() {
            for first in 0..second {
                pairs.add(first, second, &solids[first], &solids[second]);
            }
        }
        pairs
    }

    fn add(&mut self, first: usize, second: usize, a: &Solid, b: &Solid) {
        let reach = self.reach.max(0.05 * a.bounds.diagonal().max(b.bounds.diagonal()));
        if a.bounds.grown(reach).intersects(&b.bounds)
            && let Some(hull) = a.around_both(b)
        {
            let volume = hull.volume();
            let excess = volume - a.volume() - b.volume();
            self.pairs.push(Pair { first, second, hull, volume, excess });
        }
    }

    /// Merges the pair of least excess while `wanted` (pieces left, pair), skipping what the gate
    /// turns down.
    fn merge_while(
        &mut self,
        solids: &mut Vec<Solid>,
        wanted: impl Fn(usize, &Pair) -> bool,
        gate: Option<&Gate>,
    ) {
        let mut alive: Vec<Option<Solid>> = solids.drain(..).map(Some).collect();
        let mut left = alive.len();
        while let Some(at) = self.least() {
            if !wanted(left, &self.pairs[at]) {
                break;
            }
            let pair = self.pairs.swap_remove(at);
            if gate.is_some_and(|g| !g.passes(&pair.hull)) {
                continue;
            }
            let new = alive.len();
            let gone = [pair.first, pair.second];
            gone.iter().for_each(|&i| alive[i] = None);
            self.pairs.retain(|p| !gone.contains(&p.first) && !gone.contains(&p.second));
            for (i, other) in alive.iter().enumerate() {
                if let Some(other) = other {
                    self.add(i, new, other, &pair.hull);
                }
            }
            alive.push(Some(pair.hull));
            left -= 1;
        }
        solids.extend(alive.into_iter().flatten());
    }

    fn least(&self) -> Option<usize> {
        let excess =
            |&(_, a): &(usize, &Pair), &(_, b): &(usize, &Pair)| a.excess.total_cmp(&b.excess);
        self.pairs.iter().enumerate().min_by(excess).map(|(at, _)| at)
    }
}
