//! Fewer convex pieces: what lies inside another is dropped, neighbours become one where that
//! fills no hollow.

use rayon::prelude::*;

use super::split::Gate;
use crate::collision::cover::Cover;
use crate::collision::piece::MAX_PIECES;
use crate::collision::solid::Solid;

/// Most pieces wanted of one link; clearing links of each other needs room up to [`MAX_PIECES`].
const WANTED: usize = 24;
/// Pieces this far apart may become one, in tolerances.
const REACH: f64 = 1.6;
/// Two pieces whose hull is larger by this share only are always merged.
const TRIFLE: f64 = 0.01;

/// How deep in a hollow the last mergers may reach, in tolerances, one round after the other.
const DEEPEST: [f64; 2] = [0.93, 0.98];

/// Merges and drops until at most [`MAX_PIECES`] are left, fewer where the gate holds.
///
/// `cover` holds samples of the link's surface and how far a piece may be from them; mergers that
/// fill no fine hollow go on down to `few` pieces.
pub(crate) fn merge(
    mut solids: Vec<Solid>,
    gate: &Gate,
    cover: &Cover,
    tolerance: f64,
    few: usize,
) -> Vec<Solid> {
    solids.sort_by(|a, b| b.volume().total_cmp(&a.volume()));
    let mut pieces = Pieces::new(solids, cover, REACH * tolerance);
    pieces.drop_inside(0.1 * gate.clearance, 1);
    pieces.merge_while(|count, pair| pair.excess < TRIFLE * pair.volume && count > 1, None);
    pieces.merge_while(|count, _| count > few, Some(gate));
    pieces.drop_inside(0.3 * tolerance, WANTED);
    for clearance in [0.2, 0.4, 0.8].map(|share| share * tolerance) {
        let coarse = Gate { clearance: clearance.max(gate.clearance), ..*gate };
        pieces.merge_while(|count, _| count > WANTED, Some(&coarse));
    }
    pieces.drop_inside(0.6 * tolerance, MAX_PIECES - 6);
    pieces.drop_served(MAX_PIECES - 6);
    for deepest in DEEPEST.map(|share| share * tolerance) {
        let last = Gate { clearance: 0.8 * tolerance, deepest, ..*gate };
        pieces.merge_while(|count, _| count > MAX_PIECES - 1, Some(&last));
    }
    pieces.merge_while(|count, _| count > MAX_PIECES - 1, None);
    pieces.bares_nothing = false;
    pieces.merge_while(|count, _| count > MAX_PIECES - 1, None);
    pieces.largest(MAX_PIECES)
}

/// Two pieces that might become one.
struct Pair {
    first: usize,
    second: usize,
    /// Their hull, its volume and how much of it is in neither, m³.
    hull: Solid,
    volume: f64,
    excess: f64,
    /// Whether the gate of this round turned it down.
    refused: bool,
    /// Whether it leaves a sample bare, once that is known.
    bares: Option<bool>,
}

/// Pieces and all pairs of them; a piece's number is never reused, `None` once it is gone.
struct Pieces<'a> {
    alive: Vec<Option<Solid>>,
    /// Distance of each sample of the surface from each piece.
    rows: Vec<Vec<f64>>,
    cover: &'a Cover,
    pairs: Vec<Pair>,
    /// Whether a merger may leave no sample bare that it found covered.
    bares_nothing: bool,
    /// Pieces farther apart than this, metres, or 5 % of the larger, are no pair.
    reach: f64,
}

impl<'a> Pieces<'a> {
    fn new(solids: Vec<Solid>, cover: &'a Cover, reach: f64) -> Self {
        let rows = solids.par_iter().map(|s| cover.row(s)).collect();
        let alive = solids.into_iter().map(Some).collect();
        let pairs = Vec::new();
        let mut pieces = Self { alive, rows, cover, pairs, bares_nothing: true, reach };
        (1..pieces.alive.len()).for_each(|second| pieces.add_pairs_of(second));
        pieces
    }

    /// Adds the pairs of a piece with all before it.
    fn add_pairs_of(&mut self, second: usize) {
        let pairs = (0..second).into_par_iter().filter_map(|first| self.pair(first, second));
        let pairs: Vec<Pair> = pairs.collect();
        self.pairs.extend(pairs);
    }

    fn pair(&self, first: usize, second: usize) -> Option<Pair> {
        let (a, b) = (self.alive[first].as_ref()?, self.alive[second].as_ref()?);
        let reach = self.reach.max(0.05 * a.bounds.diagonal().max(b.bounds.diagonal()));
        if !a.bounds.grown(reach).intersects(&b.bounds) {
            return None;
        }
        let hull = a.around_both(b)?;
        let volume = hull.volume();
        let excess = volume - a.volume() - b.volume();
        Some(Pair { first, second, hull, volume, excess, refused: false, bares: None })
    }

    fn count(&self) -> usize {
        self.alive.iter().flatten().count()
    }

    fn take(&mut self, gone: usize) {
        self.alive[gone] = None;
        self.pairs.retain(|p| p.first != gone && p.second != gone);
    }

    /// Merges the pair of least excess while `wanted` (pieces left, pair), skipping what the gate
    /// turns down.
    fn merge_while(&mut self, wanted: impl Fn(usize, &Pair) -> bool, gate: Option<&Gate>) {
        self.pairs.iter_mut().for_each(|p| p.refused = false);
        while let Some(at) = self.least() {
            if !wanted(self.count(), &self.pairs[at]) {
                break;
            }
            let hollow = gate.is_some_and(|g| !g.passes(&self.pairs[at].hull));
            if hollow || self.bares_nothing && self.bares(at) {
                self.pairs[at].refused = true;
                continue;
            }
            let pair = self.pairs.swap_remove(at);
            let row = self.cover.row(&pair.hull);
            self.take(pair.first);
            self.take(pair.second);
            let new = self.alive.len();
            self.alive.push(Some(pair.hull));
            self.rows.push(row);
            self.add_pairs_of(new);
        }
    }

    /// Whether a sample that one of a pair covers is bare of their hull, which has only so many
    /// corners.
    fn bares(&mut self, at: usize) -> bool {
        let pair = &self.pairs[at];
        let known = pair.bares.unwrap_or_else(|| {
            let row = self.cover.row(&pair.hull);
            let before = self.rows[pair.first].iter().zip(&self.rows[pair.second]);
            let limit = self.cover.limit;
            before.zip(row).any(|((a, b), now)| now > limit && a.min(*b) <= limit)
        });
        self.pairs[at].bares = Some(known);
        known
    }

    /// The pair of least excess that was not turned down.
    fn least(&self) -> Option<usize> {
        let open = self.pairs.iter().enumerate().filter(|(_, p)| !p.refused);
        open.min_by(|(_, a), (_, b)| a.excess.total_cmp(&b.excess)).map(|(at, _)| at)
    }

    /// Numbers of the pieces left, largest first.
    fn by_size(&self) -> Vec<usize> {
        let volume = |i: usize| self.alive[i].as_ref().map_or(0.0, Solid::volume);
        let left = (0..self.alive.len()).filter(|&i| self.alive[i].is_some());
        let mut left: Vec<(usize, f64)> = left.map(|i| (i, volume(i))).collect();
        left.sort_by(|a, b| b.1.total_cmp(&a.1));
        left.into_iter().map(|(i, _)| i).collect()
    }

    /// Drops pieces, smallest first, that lie within `depth` metres of a larger one, while more
    /// than `keep` are left.
    fn drop_inside(&mut self, depth: f64, keep: usize) {
        let order = self.by_size();
        for at in (1..order.len()).rev() {
            if self.count() <= keep {
                break;
            }
            let Some(small) = &self.alive[order[at]] else { continue };
            let holds = |&host: &usize| {
                self.alive[host].as_ref().is_some_and(|host| host.is_around(small, depth))
            };
            if order[..at].iter().any(holds) {
                self.take(order[at]);
            }
        }
    }

    /// Drops pieces whose whole surface others cover well enough, the one whose loss costs least
    /// first, while more than `keep` are left.
    fn drop_served(&mut self, keep: usize) {
        while self.count() > keep {
            let order = self.by_size();
            let rows: Vec<_> = order.iter().map(|&i| &self.rows[i]).collect();
            let Some(at) = self.cover.spare(&rows, |_| true) else { break };
            self.take(order[at]);
        }
    }

    fn largest(mut self, most: usize) -> Vec<Solid> {
        let order = self.by_size();
        order.into_iter().take(most).filter_map(|i| self.alive[i].take()).collect()
    }
}
