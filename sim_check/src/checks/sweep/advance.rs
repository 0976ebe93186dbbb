//! One joint through its whole range: the deepest overlap on the way, and how far it gets freely.

use std::collections::BTreeMap;

use glamx::{DPose3, DVec3};
use object::mesh::Bounds;

use super::boxes::{box_distance, may_be_within};
use super::overlap::{Overlap, overlaps};
use super::scene::Scene;
use super::tree::Node;

/// Most distance queries for one side of one joint; beyond it the sweep has no answer.
const QUERY_LIMIT: usize = 1_000_000;
/// Points through the box test cost this share of a distance query.
const BOX_TESTS_PER_QUERY: usize = 16;

/// Most pairs of branches looked at before every pair of pieces is: by then nothing is passed over.
pub(super) const MOST_BRANCHES: usize = 200_000;
/// Most looks at one pair of branches on its way; then it is opened.
const MOST_LOOKS: usize = 256;
/// How near a branch may come before it is opened, as a share of its own size.
const BRANCH_STEP: f64 = 0.05;

/// What a sweep found on one side of rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Side {
    /// Where the sweep ended, radians or metres from rest, signed.
    pub end: f64,
    /// Per pair of links the deepest overlap and where, deepest first.
    pub worst: Vec<(Overlap, f64)>,
    /// The joint value nearest rest at which an overlap exceeds the bound.
    pub first_hit: Option<f64>,
    /// How many pairs of pieces were followed through the range.
    pub pairs: usize,
    /// Where the overlap of two links stands in `worst`, until that is sorted.
    known: BTreeMap<[usize; 2], usize>,
}

/// A sweep that would cost more than it may.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the sweep of joint `{joint}` needs more than {QUERY_LIMIT} distance queries")]
pub struct TooMuchWork {
    /// The joint.
    pub joint: String,
}

impl Side {
    /// The deepest overlap, if any pieces overlap at all.
    pub fn deepest(&self) -> Option<&(Overlap, f64)> {
        self.worst.first()
    }

    fn note(&mut self, scene: &Scene, overlap: Overlap, q: f64) {
        if overlap.depth > scene.bound() {
            let nearer = self.first_hit.is_none_or(|f| q.abs() < f.abs());
            self.first_hit = if nearer { Some(q) } else { self.first_hit };
        }
        let links = overlap.pieces.map(|p| scene.pieces[p].link);
        let place = *self.known.entry(links).or_insert(self.worst.len());
        match self.worst.get_mut(place) {
            Some(entry) if entry.0.depth < overlap.depth => *entry = (overlap, q),
            Some(_) => {}
            None => self.worst.push((overlap, q)),
        }
    }

    fn sorted(mut self) -> Self {
        self.known.clear();
        self.worst
            .sort_by(|a, b| b.0.depth.total_cmp(&a.0.depth).then(a.0.pieces.cmp(&b.0.pieces)));
        self
    }
}

/// Tip motion between two looks where pieces are near each other, metres: 2 mm, or 0.1 % of the
/// diagonal for large objects.
pub fn step(scene: &Scene) -> f64 {
    0.002f64.max(0.001 * scene.diagonal)
}

/// Moves one drive from rest to `end`, everything else at rest, and looks at every pair of pieces
/// that the motion brings nearer or farther.
///
/// Each pair advances as far as it can without overlapping by more than the bound, and at least by
/// [`step`]. So an overlap between two looks is at most half a step deeper than what is reported.
///
/// # Errors
/// [`TooMuchWork`] beyond a fixed number of queries.
pub fn sweep(scene: &Scene, drive: usize, end: f64) -> Result<Side, TooMuchWork> {
    if end == 0.0 {
        return Ok(Side::default());
    }
    if scene.drives[drive].followers.is_empty() {
        let rail = Rail::new(scene, drive);
        let near = rail.near_pairs(scene, drive, [0.0, end], |_| 2.0 * rail.step);
        return sweep_all(scene, drive, end, near);
    }
    let mut side = Side { end, ..Side::default() };
    sweep_gang(scene, drive, end, &mut side)?;
    Ok(side.sorted())
}

/// Takes pairs of pieces, one that stays and one that a drive without followers moves, through the
/// range.
pub(super) fn sweep_all(
    scene: &Scene,
    drive: usize,
    end: f64,
    pairs: Vec<[usize; 2]>,
) -> Result<Side, TooMuchWork> {
    let rail = Rail::new(scene, drive);
    let mut side = Side { end, pairs: pairs.len(), ..Side::default() };
    let mut budget = QUERY_LIMIT * BOX_TESTS_PER_QUERY;
    for pair in pairs.into_iter().filter(|[p, q]| scene.counts(*p, *q)) {
        rail.advance(scene, pair, &mut side, &mut budget)
            .ok_or_else(|| TooMuchWork { joint: scene.name(drive).to_owned() })?;
    }
    Ok(side.sorted())
}

/// Pairs of pieces, one that stays and one that the drive moves.
pub fn pairs(scene: &Scene, drive: usize) -> impl Iterator<Item = [usize; 2]> {
    let of = move |moved: bool| {
        let bodies = scene.bodies.iter().filter(move |b| b.moved_by[drive] == moved);
        bodies.flat_map(|b| b.pieces.iter().copied())
    };
    of(false).flat_map(move |still| of(true).map(move |moving| [still, moving]))
}

/// The motion of one joint as seen from the root frame, the rest at rest.
pub(crate) struct Rail<'s> {
    poses: &'s [DPose3],
    boxes: &'s [Bounds],
    pub(super) pivot: DVec3,
    axis: DVec3,
    turns: bool,
    step: f64,
}

impl<'s> Rail<'s> {
    pub(crate) fn new(scene: &'s Scene, drive: usize) -> Self {
        let rest = &scene.at_rest;
        let joint = &scene.robot.joints[scene.drives[drive].joint];
        let frame = rest.links[joint.parent] * joint.origin;
        let (pivot, axis) = (frame.translation, frame.rotation * joint.axis);
        let (poses, boxes, turns) = (&rest.poses[..], &rest.boxes[..], joint.kind.turns());
        Self { poses, boxes, pivot, axis, turns, step: step(scene) }
    }

    /// Pairs of pieces, one that stays and one that a drive without followers moves, whose boxes
    /// may come within a distance of each other between two values of the joint, in the order of
    /// [`pairs`]. The distance, metres, may depend on how far from the axis the moving piece reaches.
    pub(crate) fn near_pairs(
        &self,
        scene: &Scene,
        drive: usize,
        range: [f64; 2],
        distance: impl Fn(f64) -> f64,
    ) -> Vec<[usize; 2]> {
        let child = scene.robot.joints[scene.drives[drive].joint].child;
        let span = scene.robot.span(child);
        let slack = scene.tree.slack(scene.diagonal, self.pivot);
        let near = |still: &Node, moving: &Node| {
            let arm = if self.turns { self.arm(moving.cube.centre) } else { 1.0 };
            let reach = if self.turns { arm + 2.0 * moving.cube.half } else { 1.0 };
            self.comes_near([still, moving], range, arm, distance(reach) + slack)
        };
        let groups = |n: &Node| [!n.is_within(span), n.touches(span)];
        match scene.tree.pairs(groups, near, MOST_BRANCHES) {
            Some(mut found) => {
                let place = |&[still, moving]: &[usize; 2]| {
                    [still, moving].map(|p| (scene.pieces[p].body, p))
                };
                found.sort_by_key(place);
                found
            }
            None => pairs(scene, drive).collect(),
        }
    }

    /// Whether anything of a branch may come within a distance of another that stays. Its middle
    /// goes `arm` metres per unit of the joint.
    fn comes_near(&self, nodes: [&Node; 2], range: [f64; 2], arm: f64, distance: f64) -> bool {
        let [still, moving] = nodes;
        let (from, way) = (range[0], range[1] - range[0]);
        let mut at = 0.0;
        for _ in 0..MOST_LOOKS {
            let there = moving.cube.moved(&self.motion(from + way.signum() * at));
            let near = distance + BRANCH_STEP * moving.cube.half;
            if may_be_within(&still.bounds, &there, near) {
                return true;
            }
            if at >= way.abs() {
                return false;
            }
            let free = box_distance(&still.bounds, &there) - distance;
            at = (at + free / arm.max(f64::MIN_POSITIVE)).min(way.abs());
        }
        true
    }

    /// Distance of a point from the axis, metres.
    fn arm(&self, p: DVec3) -> f64 {
        (p - self.pivot).reject_from_normalized(self.axis).length()
    }

    /// What the joint at this value does to everything it moves.
    pub(super) fn motion(&self, q: f64) -> DPose3 {
        if self.turns {
            object::pose::turn_about(self.axis, self.pivot, q)
        } else {
            DPose3::from_translation(self.axis * q)
        }
    }

    fn pose(&self, piece: usize, q: f64) -> DPose3 {
        self.motion(q) * self.poses[piece]
    }

    /// Farthest a point of the piece travels per unit of the joint, metres.
    fn rate(&self, scene: &Scene, piece: usize) -> f64 {
        if !self.turns {
            return 1.0;
        }
        let arm = |p: &DVec3| self.arm(self.poses[piece].transform_point(*p));
        if let Some(round) = scene.pieces[piece].hull.round() {
            let ends = [-round.half, round.half].map(|z| arm(&(DVec3::Z * z)));
            return ends[0].max(ends[1]) + round.radius;
        }
        let hull = &scene.pieces[piece].hull;
        hull.points().iter().map(arm).fold(0.0, f64::max) + hull.beyond_points()
    }

    /// Takes one pair through the range; `None` when the budget is spent.
    fn advance(
        &self,
        scene: &Scene,
        [still, moving]: [usize; 2],
        side: &mut Side,
        budget: &mut usize,
    ) -> Option<()> {
        let [fixed, moved] = [still, moving].map(|p| &scene.pieces[p].hull);
        let rate = self.rate(scene, moving).max(1e-9);
        let (mut at, mut guess) = (0.0, None);
        loop {
            *budget = budget.checked_sub(1)?;
            let q = side.end.signum() * at;
            let pose = self.pose(moving, q);
            let apart = box_distance(&self.boxes[still], &moved.bounds_at(&pose));
            let free = if apart > 2.0 * self.step {
                apart
            } else {
                *budget = budget.checked_sub(BOX_TESTS_PER_QUERY)?;
                let between = self.poses[still].inv_mul(&pose);
                let gap = fixed.gap(moved, &between, guess);
                guess = Some(gap.normal);
                if gap.distance < 0.0 {
                    let pieces = [still.min(moving), still.max(moving)];
                    side.note(scene, Overlap { pieces, depth: -gap.distance }, q);
                }
                gap.distance + scene.bound()
            };
            if at >= side.end.abs() {
                return Some(());
            }
            at = (at + free.max(self.step) / rate).min(side.end.abs());
        }
    }
}

/// A drive with followers: all of them moved together in steps of at most [`step`] of tip motion,
/// bounded by the sum of what each could do alone.
fn sweep_gang(scene: &Scene, drive: usize, end: f64, side: &mut Side) -> Result<(), TooMuchWork> {
    let of = &scene.drives[drive];
    let reach = scene.bounds(&scene.with(&[(drive, end)])).diagonal().max(scene.diagonal);
    let rate = |joint: usize, by: f64| {
        by.abs() * if scene.robot.joints[joint].kind.turns() { reach } else { 1.0 }
    };
    let follow: f64 = of.followers.iter().map(|f| rate(f.0, f.1)).sum();
    let steps = (end.abs() * (rate(of.joint, 1.0) + follow) / step(scene)).ceil();
    let pairs = scene.pieces.len().pow(2).max(1);
    if steps * pairs as f64 > (QUERY_LIMIT * BOX_TESTS_PER_QUERY) as f64 {
        return Err(TooMuchWork { joint: scene.name(drive).to_owned() });
    }
    let steps = (steps as usize).max(1);
    for k in 0..=steps {
        let q = end * k as f64 / steps as f64;
        for overlap in overlaps(scene, &scene.with(&[(drive, q)]), |_, _| true) {
            side.note(scene, overlap, q);
        }
    }
    Ok(())
}
