//! S1 and S2: a swing that must not gain energy, and a drop from 1 cm that must come to rest.

use std::f64::consts::PI;

use glamx::DVec3;

use super::world::{Base, Effort, RATE, Setup, Sim, SimFault, Touch};
use crate::checks::sweep::Scene;
use crate::profile::bounds::{DRIFT, GAIN, SETTLE, TIPPED, radians};
use crate::robot::Motion;

/// Standard gravity, m/s².
pub const GRAVITY: DVec3 = DVec3::new(0.0, 0.0, -9.81);
/// Steps per second of the drop: at the usual number the joints of an arm creep whatever their
/// friction, and what stands on an edge and falls in finer steps stays up.
const FINE: f64 = 2.0 * RATE;
/// A first look, and a closer one. With the engine's default of 1, a cabinet with a door and a
/// drawer creeps over level ground at 1 mm/s for ever. With 8, a top-heavy tap that stands is
/// thrown over.
const FIRST: Look = Look { effort: Effort { substeps: 2, iterations: Some(10) }, settle: 0.75 };
const CLOSER: Look = Look { effort: Effort { substeps: 4, iterations: Some(40) }, settle: SETTLE };
/// A first look counts where it stays within this share of every bound.
const SURE: f64 = 0.25;
/// Height of the drop, metres.
const HEIGHT: f64 = 0.01;
/// What pushing a body out of the ground within one step may lift it, metres: the engine's doing, and
/// a thing the size of a die would be blamed for it.
const SLOP: f64 = 2e-4;
/// At rest: what a body that moved and turned this fast would have gone in so long, m/s, rad/s and
/// seconds, no body does. Where it is counts: what presses against a limit has a speed in the engine
/// and stays where it is.
const QUIET: (f64, f64) = (0.01, 0.05);
const QUIET_TIME: f64 = 0.125;
/// A root that leans this far will not stand up again: there is nothing more to wait for, radians.
const FALLEN: f64 = PI / 3.0;
/// How long the joints swing freely, seconds.
const SWING: f64 = 1.0;

/// How a drop is looked at.
#[derive(Clone, Copy)]
struct Look {
    effort: Effort,
    /// How long it may take to settle, seconds.
    settle: f64,
}

/// What a drop came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drop {
    /// When it came to rest, seconds; `None` if it did not.
    pub settled: Option<f64>,
    /// Sideways motion of the centre of its base, metres.
    pub drift: f64,
    /// How far the root leans, radians.
    pub tilt: f64,
    /// Its energy.
    pub energy: Energy,
}

/// Energy over a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Most gained over the start, as a share of what the motion could turn over.
    pub gain: f64,
    /// Whether every state was finite.
    pub finite: bool,
}

/// Most sideways motion allowed: 2 mm, or 0.2 % of the diagonal where that is more.
pub fn drift_bound(scene: &Scene) -> f64 {
    DRIFT.of(scene.diagonal)
}

impl Drop {
    /// Whether it is so far within all bounds that a closer look would not say otherwise.
    pub(super) fn is_sure(&self, scene: &Scene) -> bool {
        let shares = [self.drift / drift_bound(scene), self.tilt / radians(TIPPED)];
        self.settled.is_some() && self.energy.is_sure() && shares.iter().all(|s| *s <= SURE)
    }
}

impl Energy {
    /// The same.
    fn is_sure(&self) -> bool {
        self.finite && self.gain / GAIN <= SURE
    }
}

/// Drops the robot upright from 1 cm onto level ground, its joints held by their own friction and
/// damping only. Of the fall, where nothing happens, only the speed is taken: it starts at the
/// ground. What does not plainly stay where it stands is dropped once more, in a closer look, and
/// that counts.
///
/// # Errors
/// [`SimFault`] if it cannot be simulated.
pub fn drop(scene: &Scene) -> Result<Drop, SimFault> {
    let first = dropped(scene, FIRST)?;
    if first.is_sure(scene) { Ok(first) } else { dropped(scene, CLOSER) }
}

fn dropped(scene: &Scene, look: Look) -> Result<Drop, SimFault> {
    let q = scene.rest();
    let bounds = scene.bounds(&q);
    let (touch, effort, welded) = (Touch::Ground(bounds.min.z), look.effort, vec![]);
    let setup = Setup { base: Base::Free, rate: FINE, touch, effort, gravity: GRAVITY, q, welded };
    let mut sim = Sim::new(scene, &setup)?;
    sim.fall((2.0 * GRAVITY.length() * HEIGHT).sqrt());
    for (j, joint) in scene.robot.joints.iter().enumerate() {
        let dynamics = joint.dynamics;
        let given = |of: Option<f64>| of.filter(|v| v.is_finite() && *v > 0.0).unwrap_or(0.0);
        let friction = given(dynamics.and_then(|d| d.friction));
        sim.rub(j, friction, given(dynamics.and_then(|d| d.damping)));
    }
    let root = root_body(scene);
    let foot = DVec3::new(bounds.centre().x, bounds.centre().y, bounds.min.z);
    let mut meter = Meter::new(&sim, scene, SLOP);
    let (mut places, mut since, mut settled) = (sim.places(), 0, None);
    for step in 1..=(look.settle * FINE) as usize {
        sim.step();
        meter.read(&sim);
        let (moved, turned) = sim.strayed(&places);
        if moved > QUIET.0 * QUIET_TIME || turned > QUIET.1 * QUIET_TIME {
            (places, since) = (sim.places(), step);
        }
        if (step - since) as f64 >= QUIET_TIME * FINE {
            settled = Some(step as f64 / FINE);
        }
        if settled.is_some() || lean(&sim, root) > FALLEN {
            break;
        }
    }
    let pose = sim.pose(root);
    let moved = pose.transform_point(foot) - foot;
    let tilt = lean(&sim, root);
    let drift = DVec3::new(moved.x, moved.y, 0.0).length();
    Ok(Drop { settled, drift, tilt, energy: meter.energy })
}

/// How far a body leans, radians; its frame stood upright at the start.
fn lean(sim: &Sim, body: usize) -> f64 {
    (sim.pose(body).rotation * DVec3::Z).angle_between(DVec3::Z)
}

/// Lets every joint swing freely from the middle of its range, the root fixed, no friction, no
/// contacts: what the engine makes of the masses must not gain energy. What plainly gains none in
/// whole steps is not looked at in smaller ones.
///
/// # Errors
/// [`SimFault`] if it cannot be simulated.
pub fn swing(scene: &Scene) -> Result<Energy, SimFault> {
    let first = swung(scene, Effort { substeps: 1, ..Effort::USUAL })?;
    if first.is_sure() { Ok(first) } else { swung(scene, Effort::USUAL) }
}

fn swung(scene: &Scene, effort: Effort) -> Result<Energy, SimFault> {
    let middle = |d: usize| {
        let of = &scene.drives[d];
        (d, if of.continuous { PI / 2.0 } else { (of.lower + of.upper) / 2.0 })
    };
    let moved: Vec<_> = (0..scene.drives.len()).map(middle).collect();
    let q = scene.with(&moved);
    let (touch, welded) = (Touch::Nothing, vec![]);
    let setup = Setup { base: Base::Fixed, rate: RATE, touch, effort, gravity: GRAVITY, q, welded };
    let mut sim = Sim::new(scene, &setup)?;
    let mut meter = Meter::new(&sim, scene, 0.0);
    for _ in 0..(SWING * RATE) as usize {
        sim.step();
        meter.read(&sim);
    }
    Ok(meter.energy)
}

fn root_body(scene: &Scene) -> usize {
    scene.body_index(scene.robot.root())
}

/// Whether the file fixes the robot to the world: a root called `world` without geometry.
pub fn is_anchored(scene: &Scene) -> bool {
    if let Some(base) = scene.base {
        return base == crate::profile::subject::Base::Fixed;
    }
    let root = &scene.robot.links[scene.robot.root()];
    let held = |j: &crate::robot::Joint| j.kind == Motion::Fixed && j.parent == scene.robot.root();
    let bare = root.collisions.is_empty() && root.visuals.is_empty();
    root.name == "world" && bare && scene.robot.joints.iter().any(held)
}

/// Watches the energy of a run.
struct Meter {
    /// Energy above which there is a gain, joules.
    start: f64,
    scale: f64,
    energy: Energy,
}

impl Meter {
    /// `slop` is a height, metres, whose energy is no gain.
    fn new(sim: &Sim, scene: &Scene, slop: f64) -> Self {
        let energy = Energy { gain: 0.0, finite: sim.is_finite() };
        let weight = sim.mass() * 9.81;
        let scale = weight * (HEIGHT + 0.1 * scene.diagonal);
        let start = sim.energy() + weight * slop;
        Self { start, scale: scale.max(f64::MIN_POSITIVE), energy }
    }

    fn read(&mut self, sim: &Sim) {
        let gain = (sim.energy() - self.start) / self.scale;
        self.energy.finite &= sim.is_finite() && gain.is_finite();
        self.energy.gain = self.energy.gain.max(gain);
    }
}
