//! Which pairs of pieces count, and what is missing of a robot, for contact questions.

use std::collections::BTreeSet;

use super::bodies::Piece;
use crate::profile::subject::Subject;
use crate::robot::Robot;

/// What counts as a contact.
#[derive(Clone, Debug, Default)]
pub struct Terms {
    /// Pairs of bodies that are not looked at, the smaller index first.
    apart: BTreeSet<[usize; 2]>,
    /// For each piece what it may touch; empty where everything may touch everything.
    masks: Vec<[u32; 2]>,
}

impl Terms {
    /// Of an asset every pair counts. Of a robot those that a joint ties together do not: their
    /// housings overlap, and every simulator leaves them alone; nor do pairs that the file says
    /// pass through each other.
    pub(super) fn new(
        robot: &Robot,
        subject: Subject,
        of_link: &[usize],
        pieces: &[Piece],
    ) -> Self {
        if subject == Subject::Object {
            return Self::default();
        }
        let pair = |a: usize, b: usize| {
            let [a, b] = [a, b].map(|l| of_link.get(l).copied().unwrap_or_default());
            [a.min(b), a.max(b)]
        };
        let mut solid: BTreeSet<usize> = BTreeSet::new();
        for (l, link) in robot.links.iter().enumerate() {
            if !(link.collisions.is_empty() && link.visuals.is_empty()) {
                solid.extend(of_link.get(l).copied());
            }
        }
        // The body a joint hangs on, or the nearest above it that is more than a point.
        let above = |link: usize| {
            let mut at = link;
            while !of_link.get(at).is_some_and(|body| solid.contains(body)) {
                match robot.parent(at) {
                    Some(parent) => at = parent,
                    None => break,
                }
            }
            at
        };
        let moving = robot.joints.iter().filter(|j| j.kind.moves());
        let tied = moving.map(|j| pair(above(j.parent), j.child));
        let told = robot.beside.apart.iter().map(|&[a, b]| pair(a, b));
        let apart = tied.chain(told).collect();
        let masks = match robot.format.has_masks() {
            true => pieces.iter().map(|p| p.mask).collect(),
            false => Vec::new(),
        };
        Self { apart, masks }
    }

    /// Whether two bodies are looked at.
    pub fn look_at(&self, a: usize, b: usize) -> bool {
        !self.apart.contains(&[a.min(b), a.max(b)])
    }

    /// Whether two pieces may touch, their bodies aside.
    pub fn meet(&self, p: usize, q: usize) -> bool {
        let mask = |piece: usize| self.masks.get(piece).copied().unwrap_or([1, 1]);
        let ([t, a], [u, b]) = (mask(p), mask(q));
        t & b != 0 || u & a != 0
    }

    /// Leaves a pair of bodies alone from here on.
    pub(crate) fn leave(&mut self, a: usize, b: usize) {
        self.apart.insert([a.min(b), a.max(b)]);
    }
}
