//! S3 and S4: every joint driven past both ends of its range, and pushed against them.

use std::f64::consts::TAU;

use glamx::{DPose3, DVec3};
use object::mesh::Bounds;

use super::strangers::Strangers;
use super::weld::untouched;
use super::world::{Base, Effort, RATE, Setup, Sim, SimFault, Touch, farthest_ahead};
use crate::checks::sweep::Scene;
use crate::checks::sweep::advance::{Rail, pairs};
use crate::checks::sweep::boxes::box_distance;
use crate::checks::sweep::hull::Hull;
use crate::checks::sweep::stance::Stance;
use crate::profile::bounds::{OPENED, OVERSHOOT, REACHED};

/// How a drive is looked at: steps per second, the fastest it may go, in ranges a second, and whether
/// all other joints are welded, not only those that nothing touches.
#[derive(Clone, Copy)]
struct Look {
    rate: f64,
    fastest: f64,
    welded: bool,
}

/// A first look, and a closer one.
const FIRST: Look = Look { rate: RATE, fastest: f64::INFINITY, welded: false };
const CLOSER: Look = Look { rate: 4.0 * RATE, fastest: 1.0, welded: true };
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
/// Poses that say which pieces come near each other on the way, and what is near, as a share of the
/// diagonal: far more than held joints give way.
const LOOKS: usize = 24;
const NEAR: f64 = 0.005;
/// Of a robot with more bodies than this the share is that much less: the diagonal of a chain grows
/// with its links, what held joints give way does not. More than household things have, and arms
/// with hands (55 bodies).
const MANY: f64 = 64.0;
/// A limited joint whose range is a full turn but for this share is driven round like a
/// continuous one: an angle cannot tell its ends apart.
const FULL_TURN: f64 = 0.95;

/// What driving a joint to both ends came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driven {
    /// Share of the range it covered.
    pub reached: f64,
    /// The least and the most it came to while it was to go to either end, radians or metres; a
    /// whole turn for what goes round.
    pub covered: [f64; 2],
    /// Furthest beyond an end, as a share of the range; 0 without limits.
    pub overshoot: f64,
    /// Furthest another joint moved, as a share of what it may (2 deg or 5 mm).
    pub others: f64,
    /// Whether every state was finite.
    pub finite: bool,
}

impl Driven {
    fn is_sound(&self) -> bool {
        let moved = self.reached >= REACHED && self.overshoot <= OVERSHOOT;
        self.finite && moved && self.others <= 1.0
    }
}

/// Drives one joint to both ends and 20 % beyond, gravity off, the root fixed, the others held.
///
/// What seems to jam, or to drag another part along, is driven once more: slowly, in finer steps,
/// and between parts that cannot give way. That second run counts. In the first, the engine already
/// pushes parts that would meet within a step, and it does not hold a light part still on which a
/// heavy one turns. In the second, a joint stops before it would push another part along.
///
/// # Errors
/// [`SimFault`] if it cannot be simulated.
pub fn drive(scene: &Scene, drive: usize) -> Result<Driven, SimFault> {
    let way = on_the_way(scene, drive);
    let first = driven(scene, drive, FIRST, &way)?;
    if first.is_sound() {
        return Ok(first);
    }
    let closer = driven(scene, drive, CLOSER, &way)?;
    Ok(if closer.is_sound() { closer } else { Driven { others: first.others, ..closer } })
}

/// One look.
fn driven(scene: &Scene, drive: usize, look: Look, way: &Way) -> Result<Driven, SimFault> {
    let (pieces, ahead) = (way.pieces.clone(), way.longest * RATE / look.rate);
    let touch = Touch::Pieces { pieces, drive, ahead };
    let mut run = Run::new(scene, drive, scene.rest(), touch, look)?;
    let (lower, upper) = run.range;
    let span = upper - lower;
    if run.round {
        run.go(TAU, |at| at >= 0.97 * TAU);
        let reached = run.sim.value(run.joint) / TAU;
        return Ok(run.outcome(reached, [0.0, TAU], 0.0));
    }
    run.go(upper + PAST * span, |at| at >= upper - 0.02 * span);
    let high = run.sim.value(run.joint);
    run.go(lower - PAST * span, |at| at <= lower + 0.02 * span);
    let low = run.sim.value(run.joint);
    let overshoot = (run.highest - upper).max(lower - run.lowest).max(0.0) / span;
    let covered = [low.max(lower), high.min(upper)];
    Ok(run.outcome((covered[1] - covered[0]) / span, covered, overshoot))
}

/// Pushes one joint against both limits with twice its effort: how far it gets beyond, radians or
/// metres; `None` if it has no limits.
///
/// # Errors
/// [`SimFault`] if it cannot be simulated.
pub fn push(scene: &Scene, drive: usize, effort: f64) -> Result<Option<f64>, SimFault> {
    let mut beyond = 0f64;
    for (end, sign) in [(scene.drives[drive].lower, -1.0), (scene.drives[drive].upper, 1.0)] {
        let mut run = Run::new(scene, drive, scene.with(&[(drive, end)]), Touch::Nothing, FIRST)?;
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

/// What a drive meets.
struct Way {
    /// Pieces that come near each other.
    pieces: Vec<usize>,
    /// The longest way a corner of a piece goes from one look to the next, metres: further than in a
    /// step.
    longest: f64,
}

/// Pieces that come near each other while the drive goes through its range and belong to bodies
/// that no joint connects: the only ones whose contacts the engine would compute. A step is shorter
/// than what lies between two looks, so looking that far ahead it passes through nothing.
fn on_the_way(scene: &Scene, drive: usize) -> Way {
    let mut path = Path::new(scene, drive);
    let strangers = Strangers::of(scene);
    let mut near = vec![false; scene.pieces.len()];
    for pair in path.pairs(drive) {
        let meet = strangers.meet(pair.map(|p| scene.pieces[p].body));
        if meet && !pair.iter().all(|&p| near[p]) && path.brings_near(pair) {
            pair.iter().for_each(|&p| near[p] = true);
        }
    }
    let pieces: Vec<usize> = (0..near.len()).filter(|&p| near[p]).collect();
    // Where nothing touches nobody looks ahead.
    let longest = if pieces.is_empty() { 0.0 } else { path.longest(drive) };
    Way { pieces, longest }
}

/// Looks at the pieces on the way of a drive through its range; each is placed when asked for.
struct Path<'a> {
    scene: &'a Scene<'a>,
    /// How near counts, metres.
    margin: f64,
    /// The configuration of each look.
    looks: Vec<Stance<'a, 'a>>,
    /// The longest way a corner of each piece goes from one look to the next, metres.
    ways: Vec<Option<f64>>,
    range: [f64; 2],
}

impl<'a> Path<'a> {
    fn new(scene: &'a Scene<'a>, drive: usize) -> Self {
        let of = &scene.drives[drive];
        let at = |k: usize| of.lower + (of.upper - of.lower) * k as f64 / LOOKS as f64;
        let looks = (0..=LOOKS).map(|k| Stance::of(scene, &[(drive, at(k))])).collect();
        let links = scene.bodies.len().max(1) as f64;
        let margin = NEAR * scene.diagonal * (MANY / links).min(1.0);
        let ways = vec![None; scene.pieces.len()];
        Self { scene, margin, looks, ways, range: [of.lower, of.upper] }
    }

    /// Pairs of pieces, one that stays and one that moves, without those that are never near.
    fn pairs(&self, drive: usize) -> Vec<[usize; 2]> {
        if !self.scene.drives[drive].followers.is_empty() {
            return pairs(self.scene, drive).collect();
        }
        let between = (self.range[1] - self.range[0]) / LOOKS as f64;
        let reach = |arm: f64| self.margin + arm * between / 2.0;
        Rail::new(self.scene, drive).near_pairs(self.scene, drive, self.range, reach)
    }

    /// Whether two pieces, the first at rest, come nearer than [`NEAR`] of the diagonal. Between two
    /// looks no point gets farther from both than half its way: that counts as near too.
    fn brings_near(&mut self, [still, moving]: [usize; 2]) -> bool {
        let way = self.way(moving);
        let reach = self.margin + way / 2.0;
        let rest = self.bounds(still, 0);
        let (mut look, mut guess) = (0, None);
        while look < self.looks.len() {
            let apart = box_distance(&self.bounds(moving, look), &rest);
            let apart =
                if apart > reach { apart } else { self.gap([still, moving], look, &mut guess) };
            if apart <= reach {
                return true;
            }
            // What is farther than it can come until then need not be looked at.
            look += 1 + ((apart - reach) / way.max(f64::MIN_POSITIVE)) as usize;
        }
        false
    }

    fn bounds(&mut self, piece: usize, look: usize) -> Bounds {
        self.scene.pieces[piece].hull.bounds_at(&self.looks[look].piece(piece))
    }

    fn gap(&mut self, pieces: [usize; 2], look: usize, guess: &mut Option<DVec3>) -> f64 {
        let [still, moving] = pieces.map(|p| &self.scene.pieces[p].hull);
        let [from, to] = pieces.map(|p| self.looks[look].piece(p));
        let gap = still.gap(moving, &from.inv_mul(&to), *guess);
        *guess = Some(gap.normal);
        gap.distance
    }

    /// The longest way a corner of a piece goes from one look to the next, metres.
    fn way(&mut self, piece: usize) -> f64 {
        if let Some(known) = self.ways[piece] {
            return known;
        }
        let poses: Vec<DPose3> = self.looks.iter_mut().map(|look| look.piece(piece)).collect();
        let way = longest_way(&self.scene.pieces[piece].hull, &poses);
        self.ways[piece] = Some(way);
        way
    }

    /// The longest way of any piece; where it is farther than the engine ever looks ahead, no more
    /// than that is known of it.
    fn longest(&mut self, drive: usize) -> f64 {
        let enough = farthest_ahead(self.scene) * CLOSER.rate / RATE;
        let mut longest = 0f64;
        for body in self.scene.bodies.iter().filter(|b| b.moved_by[drive]) {
            for &piece in &body.pieces {
                longest = longest.max(self.way(piece));
            }
            if longest > enough {
                break;
            }
        }
        longest
    }
}

/// The longest way a corner of a hull goes from one pose to the next, metres.
fn longest_way(hull: &Hull, poses: &[DPose3]) -> f64 {
    let way = |from: &DPose3, to: &DPose3| {
        if from == to {
            return 0.0;
        }
        let of = |p: &DVec3| from.transform_point(*p).distance(to.transform_point(*p));
        hull.points().iter().map(of).fold(0.0, f64::max)
    };
    poses.windows(2).map(|w| way(&w[0], &w[1])).fold(0.0, f64::max)
}

/// The pieces whose contacts the engine computes.
fn touching(touch: &Touch) -> &[usize] {
    match touch {
        Touch::Pieces { pieces, .. } => pieces,
        Touch::Nothing | Touch::Ground(_) => &[],
    }
}

/// One joint in motion, the others held where they started.
struct Run<'a> {
    sim: Sim<'a>,
    scene: &'a Scene<'a>,
    drive: usize,
    joint: usize,
    range: (f64, f64),
    round: bool,
    look: Look,
    start: Vec<f64>,
    /// Joints that are to stay where they started.
    held: Vec<usize>,
    /// Drives that could be dragged along.
    watched: Vec<usize>,
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
        look: Look,
    ) -> Result<Self, SimFault> {
        let of = &scene.drives[drive];
        let (joint, range) = (of.joint, (of.lower, of.upper));
        let round = of.continuous || (scene.turns(drive) && range.1 - range.0 > FULL_TURN * TAU);
        let start = q.clone();
        let moves = |j: &usize| *j == joint || of.followers.iter().any(|f| f.0 == *j);
        let turns = |j: &usize| scene.robot.joints[*j].kind.has_axis();
        let others = || (0..scene.robot.joints.len()).filter(|j| turns(j) && !moves(j));
        let welded = match look.welded {
            true => others().collect(),
            false => untouched(scene, drive, touching(&touch)),
        };
        let mut fast = vec![false; scene.robot.joints.len()];
        welded.iter().for_each(|&j| fast[j] = true);
        let loose = |j: &usize| !fast[*j];
        let held = others().filter(|j| loose(j)).collect();
        let others = (0..scene.drives.len()).filter(|d| *d != drive);
        let watched = others.filter(|d| loose(&scene.drives[*d].joint)).collect();
        let (base, effort, gravity) = (Base::Fixed, Effort::USUAL, DVec3::ZERO);
        let setup = Setup { base, rate: look.rate, touch, effort, gravity, q, welded };
        let sim = Sim::new(scene, &setup)?;
        let at = start[joint];
        let (lowest, highest) = (at, at);
        Ok(Self {
            sim,
            held,
            watched,
            scene,
            drive,
            joint,
            range,
            round,
            look,
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
        let span = if self.round { TAU } else { self.range.1 - self.range.0 };
        let fastest = self.look.fastest * span;
        for _ in 0..(TRAVEL * self.look.rate) as usize {
            self.sim.servo(self.joint, target, DAMPING, fastest);
            self.follow(target);
            self.step();
            held += usize::from(there(self.sim.value(self.joint)));
            if held as f64 > HELD * self.look.rate || !self.finite {
                break;
            }
        }
    }

    /// Followers go where the leader now is; the engine knows no mimics.
    fn follow(&mut self, _target: f64) {
        let at = self.sim.value(self.joint);
        for &(j, by, plus) in &self.scene.drives[self.drive].followers {
            self.sim.servo(j, by * at + plus, FIRM, f64::INFINITY);
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
        for &d in &self.watched {
            let other = &self.scene.drives[d];
            let moved = (self.sim.value(other.joint) - self.start[other.joint]).abs();
            let bound = OPENED.of(self.scene.turns(d));
            self.others = self.others.max(moved / bound);
        }
    }

    fn outcome(&self, reached: f64, covered: [f64; 2], overshoot: f64) -> Driven {
        let finite = self.finite && reached.is_finite() && overshoot.is_finite();
        Driven { reached, covered, overshoot, others: self.others, finite }
    }
}
