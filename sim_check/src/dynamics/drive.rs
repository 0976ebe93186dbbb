//! S3 and S4: every joint driven past both ends of its range, and pushed against them.

use std::f64::consts::TAU;

use glamx::{DPose3, DVec3};
use object::mesh::Bounds;

use super::world::{Base, RATE, Setup, Sim, SimFault, Touch};
use crate::sweep::Scene;
use crate::sweep::advance::pairs;
use crate::sweep::hull::Hull;

/// How far past an end a drive aims, as a share of the range.
const PAST: f64 = 0.2;
/// Time to reach an end, seconds.
const TRAVEL: f64 = 1.5;
/// How long the end is held against the drive, seconds.
const HELD: f64 = 0.1;
/// How long the limits are pushed, seconds.
const PUSHED: f64 = 0.2;
/// Servo damping, 1/s: with its stiffness of 5 times that, a drive is overdamped.
const DAMPING: f64 = 40.0;
/// The same for joints that follow another.
const FIRM: f64 = 400.0;
/// Poses that say which pieces come near each other on the way.
const LOOKS: usize = 24;
/// A limited joint whose range is a full turn but for this share is driven round like a
/// continuous one: an angle cannot tell its ends apart.
const FULL_TURN: f64 = 0.95;

/// What driving a joint to both ends came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driven {
    /// Share of the range it covered.
    pub reached: f64,
    /// Furthest beyond an end, as a share of the range; 0 without limits.
    pub overshoot: f64,
    /// Furthest another joint moved, as a share of what it may (2 deg or 5 mm).
    pub others: f64,
    /// Whether every state was finite.
    pub finite: bool,
}

/// Drives one joint to both ends and 20 % beyond, gravity off, the root fixed, the others held.
///
/// # Errors
/// [`SimFault`] if it cannot be simulated.
pub fn drive(scene: &Scene, drive: usize) -> Result<Driven, SimFault> {
    let touch = Touch::Pieces(near_on_the_way(scene, drive));
    let mut run = Run::new(scene, drive, scene.rest(), touch)?;
    let (lower, upper) = run.range;
    let span = upper - lower;
    if run.round {
        run.go(TAU, |at| at >= 0.97 * TAU);
        let reached = run.sim.value(run.joint) / TAU;
        return Ok(run.outcome(reached, 0.0));
    }
    run.go(upper + PAST * span, |at| at >= upper - 0.02 * span);
    let high = run.sim.value(run.joint);
    run.go(lower - PAST * span, |at| at <= lower + 0.02 * span);
    let low = run.sim.value(run.joint);
    let overshoot = (run.highest - upper).max(lower - run.lowest).max(0.0) / span;
    Ok(run.outcome((high.min(upper) - low.max(lower)) / span, overshoot))
}

/// Pushes one joint against both limits with twice its effort: how far it gets beyond, radians or
/// metres; `None` if it has no limits.
///
/// # Errors
/// [`SimFault`] if it cannot be simulated.
pub fn push(scene: &Scene, drive: usize, effort: f64) -> Result<Option<f64>, SimFault> {
    let mut beyond = 0f64;
    for (end, sign) in [(scene.drives[drive].lower, -1.0), (scene.drives[drive].upper, 1.0)] {
        let mut run = Run::new(scene, drive, scene.with(&[(drive, end)]), Touch::Nothing)?;
        if run.round {
            return Ok(None);
        }
        run.sim.push(run.joint, 2.0 * effort * sign);
        for _ in 0..(PUSHED * RATE) as usize {
            run.step();
        }
        let furthest = if sign > 0.0 { run.highest - end } else { end - run.lowest };
        beyond = if run.finite { beyond.max(furthest) } else { f64::INFINITY };
    }
    Ok(Some(beyond))
}

/// Pieces that come near each other while the drive goes through its range and belong to bodies
/// that no joint connects: the only ones whose contacts the engine would compute.
///
/// Between two looks no point gets farther from both than half its way: that counts as near too.
fn near_on_the_way(scene: &Scene, drive: usize) -> Vec<usize> {
    let of = &scene.drives[drive];
    let at = |k: usize| of.lower + (of.upper - of.lower) * k as f64 / LOOKS as f64;
    let poses = |k: usize| scene.piece_poses(&scene.with(&[(drive, at(k))]));
    let looks: Vec<Vec<DPose3>> = (0..=LOOKS).map(poses).collect();
    let pieces = || scene.pieces.iter().enumerate();
    let boxed = |l: &Vec<DPose3>| pieces().map(|(p, of)| of.hull.bounds_at(&l[p])).collect();
    let boxes: Vec<Vec<Bounds>> = looks.iter().map(boxed).collect();
    let margin = 0.02 * scene.diagonal;
    let reach: Vec<f64> =
        pieces().map(|(p, of)| margin + longest_way(&of.hull, &looks, p) / 2.0).collect();
    let swept = |p: usize| Bounds::of(boxes.iter().flat_map(|b| [b[p].min, b[p].max]));
    let swept: Vec<Bounds> = (0..scene.pieces.len()).map(|p| swept(p).grown(margin)).collect();
    let mut near = vec![false; scene.pieces.len()];
    for [still, moving] in pairs(scene, drive) {
        let pass = || swept[moving].intersects(&boxes[0][still]);
        let meet = || boxes.iter().any(|b| b[moving].grown(reach[moving]).intersects(&b[still]));
        let apart = !joined(scene, [still, moving].map(|p| scene.pieces[p].body));
        if apart && !(near[still] && near[moving]) && pass() && meet() {
            (near[still], near[moving]) = (true, true);
        }
    }
    (0..near.len()).filter(|&p| near[p]).collect()
}

/// The longest way a corner of a piece goes from one look to the next, metres.
fn longest_way(hull: &Hull, looks: &[Vec<DPose3>], piece: usize) -> f64 {
    let way = |from: &DPose3, to: &DPose3| {
        let of = |p: &DVec3| from.transform_point(*p).distance(to.transform_point(*p));
        hull.points().iter().map(of).fold(0.0, f64::max)
    };
    looks.windows(2).map(|w| way(&w[0][piece], &w[1][piece])).fold(0.0, f64::max)
}

/// Bodies that nothing can move while the drive runs: they hang on the fixed root by branches of
/// their own and have no piece that touches.
fn out_of_reach(scene: &Scene, drive: usize, touch: &Touch) -> Vec<usize> {
    let touching = |b: usize| match touch {
        Touch::Pieces(pieces) => pieces.iter().any(|&p| scene.pieces[p].body == b),
        Touch::Nothing => false,
        Touch::Ground(_) => true,
    };
    let bodies = 0..scene.bodies.len();
    let taking_part = |b: &usize| scene.bodies[*b].moved_by[drive] || touching(*b);
    let branches: Vec<usize> =
        bodies.clone().filter(taking_part).map(|b| branch(scene, b)).collect();
    bodies.filter(|&b| !branches.contains(&branch(scene, b))).collect()
}

/// The first link of the branch a body is in: the body below the root that it hangs on, or the root.
fn branch(scene: &Scene, body: usize) -> usize {
    let mut at = scene.bodies[body].link;
    while let Some(parent) = scene.robot.parent(at) {
        let above = scene.body_of_link[parent];
        if above == scene.robot.root() {
            break;
        }
        at = above;
    }
    at
}

/// Whether a joint ties two bodies together.
fn joined(scene: &Scene, bodies: [usize; 2]) -> bool {
    let [a, b] = bodies.map(|b| scene.bodies[b].link);
    scene.robot.joints.iter().any(|j| {
        let ends = [scene.body_of_link[j.parent], scene.body_of_link[j.child]];
        ends == [a, b] || ends == [b, a]
    })
}

/// One joint in motion, the others held where they started.
struct Run<'a> {
    sim: Sim<'a>,
    scene: &'a Scene<'a>,
    drive: usize,
    joint: usize,
    range: (f64, f64),
    round: bool,
    start: Vec<f64>,
    /// Joints that are to stay where they started.
    held: Vec<usize>,
    lowest: f64,
    highest: f64,
    others: f64,
    finite: bool,
}

impl<'a> Run<'a> {
    fn new(
        scene: &'a Scene<'a>,
        drive: usize,
        q: Vec<f64>,
        touch: Touch,
    ) -> Result<Self, SimFault> {
        let of = &scene.drives[drive];
        let (joint, range) = (of.joint, (of.lower, of.upper));
        let round = of.continuous || (scene.turns(drive) && range.1 - range.0 > FULL_TURN * TAU);
        let start = q.clone();
        let still = out_of_reach(scene, drive, &touch);
        let setup = Setup { base: Base::Fixed, touch, gravity: DVec3::ZERO, q, still };
        let sim = Sim::new(scene, &setup)?;
        let at = start[joint];
        let moves = |j: &usize| *j == joint || of.followers.iter().any(|f| f.0 == *j);
        let all = 0..scene.robot.joints.len();
        let held = all.filter(|j| scene.robot.joints[*j].kind.has_axis() && !moves(j)).collect();
        let (lowest, highest) = (at, at);
        Ok(Self {
            sim,
            held,
            scene,
            drive,
            joint,
            range,
            round,
            start,
            lowest,
            highest,
            others: 0.0,
            finite: true,
        })
    }

    /// Drives towards `target` until `there` holds, then holds against the end for a while.
    fn go(&mut self, target: f64, there: impl Fn(f64) -> bool) {
        let mut held = 0;
        for _ in 0..(TRAVEL * RATE) as usize {
            self.sim.servo(self.joint, target, DAMPING);
            self.follow(target);
            self.step();
            held += usize::from(there(self.sim.value(self.joint)));
            if held as f64 > HELD * RATE || !self.finite {
                break;
            }
        }
    }

    /// Followers go where the leader now is; the engine knows no mimics.
    fn follow(&mut self, _target: f64) {
        let at = self.sim.value(self.joint);
        for &(j, by, plus) in &self.scene.drives[self.drive].followers {
            self.sim.servo(j, by * at + plus, FIRM);
        }
    }

    fn step(&mut self) {
        // Again at every step: what a drive further up the chain shakes loose must come back.
        for &joint in &self.held {
            self.sim.hold(joint, self.start[joint]);
        }
        self.sim.step();
        self.finite &= self.sim.is_finite();
        let at = self.sim.value(self.joint);
        (self.lowest, self.highest) = (self.lowest.min(at), self.highest.max(at));
        for (d, other) in self.scene.drives.iter().enumerate().filter(|(d, _)| *d != self.drive) {
            let moved = (self.sim.value(other.joint) - self.start[other.joint]).abs();
            let bound = if self.scene.turns(d) { 2f64.to_radians() } else { 0.005 };
            self.others = self.others.max(moved / bound);
        }
    }

    fn outcome(&self, reached: f64, overshoot: f64) -> Driven {
        let finite = self.finite && reached.is_finite() && overshoot.is_finite();
        Driven { reached, overshoot, others: self.others, finite }
    }
}
