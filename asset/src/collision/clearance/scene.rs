//! All links with their pieces: which ones meet while joints move, and making room where they do.

use glamx::DVec3;
use object::mesh::Bounds;
use rayon::prelude::*;

use super::carve::{Room, carve};
use super::meeting::{Closeness, Meeting};
use super::motion::Motion;
use crate::collision::cover::Cover;
use crate::collision::piece::MAX_PIECES;
use crate::collision::solid::Solid;

/// Most pieces one piece may become in one carving.
const MOST_PARTS: usize = 10;
/// What one more piece costs, in mean price per sample.
const PIECE_PRICE: f64 = 0.001;
/// What losing all of a link's volume costs.
const VOLUME_PRICE: f64 = 0.03;
/// Most carvings for one pair of links and one motion.
const MOST_ROUNDS: usize = 200;

/// One convex piece and the distance of every sample of its link from it.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) solid: Solid,
    row: Vec<f64>,
}

/// The pieces of one link; a piece's number stays its own, `None` once it is gone.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) cover: Cover,
    pub(crate) pieces: Vec<Option<Piece>>,
    volume: f64,
}

impl Body {
    /// A link's pieces and the samples they are to cover.
    pub(crate) fn new(solids: Vec<Solid>, cover: Cover) -> Self {
        let volume = solids.iter().map(Solid::volume).sum();
        let piece = |solid: Solid| Some(Piece { row: cover.row(&solid), solid });
        let pieces = solids.into_iter().map(piece).collect();
        Self { cover, pieces, volume }
    }

    /// The pieces left, with their numbers.
    pub(crate) fn alive(&self) -> impl Iterator<Item = (usize, &Piece)> {
        self.pieces.iter().enumerate().filter_map(|(i, p)| Some((i, p.as_ref()?)))
    }

    /// Share of the link's samples no piece covers.
    pub(crate) fn uncovered(&self) -> f64 {
        let rows = self.alive().map(|(_, p)| &p.row);
        self.cover.uncovered(&self.cover.nearest(rows))
    }

    /// Volume of the pieces, m³; overlaps count twice.
    pub(crate) fn volume(&self) -> f64 {
        self.alive().map(|(_, p)| p.solid.volume()).sum()
    }
}

/// Two pieces that come too close, and when.
#[derive(Clone, Debug)]
pub(crate) struct Conflict {
    /// Piece numbers within the two links.
    pub(crate) pieces: [usize; 2],
    /// The motions during which they do.
    pub(crate) when: Vec<Meeting>,
}

/// Two links that move against each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Encounter {
    /// The links, a before b.
    pub(crate) links: [usize; 2],
    /// Their motions.
    pub(crate) motion: Meeting,
}

/// One way to end a conflict: a piece replaced by what is left of it.
struct Remedy {
    /// 0 if a piece of link a is carved, 1 for b.
    side: usize,
    parts: Vec<Piece>,
    /// The pieces of the other link that it makes room for.
    served: Vec<usize>,
    cost: f64,
}

/// All links and how they are to be kept apart.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) bodies: Vec<Body>,
    /// Distance that carving leaves, metres.
    pub(crate) gap: f64,
    /// Pieces thinner than this are dropped, metres.
    pub(crate) width: f64,
    /// How much of the usual worth is enough for a further piece.
    pub(crate) share: f64,
}

impl Scene {
    /// All pairs of pieces of two links that come too close.
    pub(crate) fn conflicts(&self, encounter: &Encounter, close: &Closeness) -> Vec<Conflict> {
        let [a, b] = encounter.links.map(|l| &self.bodies[l]);
        let boxes_a = swept(a, &encounter.motion.a, close.gap);
        let boxes_b = swept(b, &encounter.motion.b, 0.0);
        let mut near = Vec::new();
        for (i, box_a) in &boxes_a {
            let beside = boxes_b.iter().filter(|(_, box_b)| box_a.intersects(box_b));
            near.extend(beside.map(|(j, _)| [*i, *j]));
        }
        near.into_par_iter().filter_map(|pair| self.conflict(encounter, pair, close)).collect()
    }

    fn conflict(&self, e: &Encounter, pieces: [usize; 2], close: &Closeness) -> Option<Conflict> {
        let [a, b] = [0, 1].map(|s| self.piece(e.links[s], pieces[s]));
        let when = e.motion.conflicts(&a?.solid, &b?.solid, close);
        (!when.is_empty()).then_some(Conflict { pieces, when })
    }

    fn piece(&self, link: usize, piece: usize) -> Option<&Piece> {
        self.bodies[link].pieces.get(piece)?.as_ref()
    }

    /// Carves until two links keep their distance over a motion; false if that cannot be without
    /// taking a link's last piece.
    pub(crate) fn settle(&mut self, encounter: &Encounter, close: &Closeness) -> bool {
        let mut open = self.conflicts(encounter, close);
        let mut settled = true;
        for _ in 0..MOST_ROUNDS {
            let Some(first) = open.first() else { return settled };
            let pieces = first.pieces;
            let Some(remedy) = self.remedy(encounter, &open, pieces) else {
                settled = false;
                open.remove(0);
                continue;
            };
            self.apply(encounter, close, pieces, remedy, &mut open);
        }
        settled && open.is_empty()
    }

    /// The cheapest carving, per conflict it ends, that ends the conflict of two pieces.
    fn remedy(&self, e: &Encounter, open: &[Conflict], pieces: [usize; 2]) -> Option<Remedy> {
        let mut groups = Vec::new();
        for side in [0, 1] {
            let mine = |c: &&Conflict| c.pieces[side] == pieces[side];
            let group: Vec<_> = open.iter().filter(mine).collect();
            let single: Vec<_> = group.iter().copied().filter(|c| c.pieces == pieces).collect();
            if group.len() > single.len() {
                groups.push((side, group));
            }
            groups.push((side, single));
        }
        let carving = |(side, group): &(usize, Vec<_>)| self.carving(e, group, *side);
        let remedies: Vec<_> = groups.par_iter().filter_map(carving).collect();
        let worth = |r: &Remedy| (r.cost.max(0.0) + 1e-4) / r.served.len() as f64;
        remedies.into_iter().min_by(|a, b| worth(a).total_cmp(&worth(b)))
    }

    /// What carving the piece that all these conflicts share on one side would do.
    fn carving(&self, e: &Encounter, group: &[&Conflict], side: usize) -> Option<Remedy> {
        let body = &self.bodies[e.links[side]];
        let number = group.first()?.pieces[side];
        let host = self.piece(e.links[side], number)?;
        let mut intruders = Vec::new();
        for conflict in group {
            let other = self.piece(e.links[1 - side], conflict.pieces[1 - side])?;
            let toward = |m: &Meeting| if side == 1 { *m } else { m.flipped() };
            intruders.extend(merged(&conflict.when).map(|m| (&other.solid, toward(&m))));
        }
        let others = body.alive().filter(|(i, _)| *i != number);
        let others = body.cover.nearest(others.map(|(_, p)| &p.row));
        let count = body.alive().count();
        let pieces = MOST_PARTS.min(MAX_PIECES + 1 - count.min(MAX_PIECES));
        let room = Room { gap: self.gap, width: self.width, pieces, share: self.share };
        let served = body.cover.served(&host.row, &others);
        let solids = carve(&host.solid, &intruders, &served, &body.cover, &room);
        if solids.is_empty() && count == 1 {
            return None;
        }
        let kept: f64 = solids.iter().map(Solid::volume).sum();
        let part = |solid: Solid| Piece { row: body.cover.row(&solid), solid };
        let parts: Vec<_> = solids.into_iter().map(part).collect();
        let with = |own: Vec<&Vec<f64>>| {
            body.cover.cost(&body.cover.nearest(own.into_iter().chain([&others])))
        };
        let lost = with(parts.iter().map(|p| &p.row).collect()) - with(vec![&host.row]);
        let volume = (host.solid.volume() - kept) / body.volume.max(f64::MIN_POSITIVE);
        let cost =
            lost + PIECE_PRICE * self.share * (parts.len() as f64 - 1.0) + VOLUME_PRICE * volume;
        let served = group.iter().map(|c| c.pieces[1 - side]).collect();
        Some(Remedy { side, parts, served, cost })
    }

    fn apply(
        &mut self,
        e: &Encounter,
        close: &Closeness,
        pieces: [usize; 2],
        remedy: Remedy,
        open: &mut Vec<Conflict>,
    ) {
        let (side, gone) = (remedy.side, pieces[remedy.side]);
        let body = &mut self.bodies[e.links[side]];
        body.pieces[gone] = None;
        let new = body.pieces.len()..body.pieces.len() + remedy.parts.len();
        body.pieces.extend(remedy.parts.into_iter().map(Some));
        let mut again = Vec::new();
        open.retain(|c| {
            if c.pieces[side] == gone {
                again.push(c.pieces[1 - side]);
            }
            c.pieces[side] != gone
        });
        for other in again {
            for part in new.clone() {
                let pair = if side == 0 { [part, other] } else { [other, part] };
                open.extend(self.conflict(e, pair, close));
            }
        }
    }
}

/// Intervals that follow each other as one; where both bodies move, one rectangle around all.
fn merged(when: &[Meeting]) -> impl Iterator<Item = Meeting> {
    let both = when.iter().all(|m| matches!([m.a, m.b], [Motion::Along(..), Motion::Along(..)]));
    let mut sorted = when.to_vec();
    let start = |m: &Meeting| m.a.ends().0 + m.b.ends().0;
    sorted.sort_by(|x, y| start(x).total_cmp(&start(y)));
    let mut runs: Vec<Meeting> = Vec::new();
    for next in sorted {
        match runs.last_mut() {
            Some(run) if both || touches(&run.a, &next.a) && touches(&run.b, &next.b) => {
                *run = Meeting { a: joined(&run.a, &next.a), b: joined(&run.b, &next.b) };
            }
            _ => runs.push(next),
        }
    }
    runs.into_iter()
}

fn touches(a: &Motion, b: &Motion) -> bool {
    b.ends().0 <= a.ends().1 + 1e-9
}

fn joined(a: &Motion, b: &Motion) -> Motion {
    a.over(a.ends().0.min(b.ends().0), a.ends().1.max(b.ends().1))
}

/// Boxes around everything the pieces of a body sweep, each grown by `margin`.
fn swept(body: &Body, motion: &Motion, margin: f64) -> Vec<(usize, Bounds)> {
    let around = |(i, piece): (usize, &Piece)| {
        let reach = |n: DVec3| motion.support(&piece.solid.vertices, n);
        let max = DVec3::new(reach(DVec3::X), reach(DVec3::Y), reach(DVec3::Z));
        let min = -DVec3::new(reach(-DVec3::X), reach(-DVec3::Y), reach(-DVec3::Z));
        (i, Bounds { min, max }.grown(margin))
    };
    body.alive().map(around).collect()
}
