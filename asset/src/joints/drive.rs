//! What moves and holds a joint: effort, speed, damping and friction from mass and gravity.
//!
//! Nobody can see these in a photo, so they follow rules and are marked as defaults. Friction keeps
//! the joint where it is, against gravity at rest and against what stands on it. A drive is strong
//! enough to move the joint anywhere.

use glamx::{DMat3, DQuat, DVec3};
use object::{JointMotion, Origin, Range, Sourced};

use crate::standing::ground::{Foot, GRAVITY};

/// Friction exceeds what gravity pulls at rest by this factor.
const HOLD: f64 = 1.3;
/// The same for what the object stands on: it is set down, not laid down.
const STAND: f64 = 2.0;
/// Least friction of a hinge: this share of the moved weight times its radius of gyration.
const BEARING: f64 = 0.02;
/// Least friction of a slide: this share of the moved weight.
const RUNNER: f64 = 0.05;
/// Rolling resistance: this share of what a wheel bears, times its radius. No simulator knows it of
/// rigid wheels, so that the bearing has it.
const ROLLING: f64 = 0.03;
/// An axis this level or more is one that things roll about: the upward share of its direction.
const LEVEL: f64 = 0.3;
/// Effort exceeds gravity and friction by this factor.
pub(crate) const RESERVE: f64 = 3.0;
/// A drive reaches full speed within this time, s.
const START: f64 = 0.25;
/// Damping lets free motion fade with this time constant, s.
const FADE: f64 = 0.5;
/// Speeds that cross the range in one second stay within these, rad/s and m/s.
const TURN_SPEED: [f64; 2] = [0.5, std::f64::consts::TAU];
const SLIDE_SPEED: [f64; 2] = [0.05, 1.0];

/// Something that moves with a joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load {
    /// kg.
    pub(crate) mass: f64,
    /// Asset frame at rest, metres.
    pub(crate) centre: DVec3,
    /// About the centre, kg·m².
    pub(crate) inertia: DMat3,
}

/// The four figures of a joint's drive.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drive {
    pub(crate) effort: Sourced<f64>,
    pub(crate) velocity: Sourced<f64>,
    pub(crate) damping: Sourced<f64>,
    pub(crate) friction: Sourced<f64>,
}

/// The drive of a joint that carries `loads`, the other joints at rest, and through which the object
/// stands on `feet`. Asset frame.
pub(crate) fn drive(motion: &JointMotion, loads: &[Load], feet: &[Foot]) -> Drive {
    let pull = Pull::of(motion, loads).standing(motion, feet);
    let velocity = speed(motion);
    let hold = HOLD * pull.at_rest;
    let friction = hold.max(pull.least_friction).max(1e-5);
    let effort = RESERVE * (pull.worst + friction) + pull.inertia * velocity / START;
    let unit = if motion.kind.turns() { "N m" } else { "N" };
    let default = |value, how| Sourced::new(value, Origin::Default, how);
    Drive {
        effort: default(
            effort,
            format!(
                "{RESERVE} x (worst gravity {:.4} + friction) {unit} + full speed in {START} s",
                pull.worst
            ),
        ),
        velocity: default(velocity, "crosses its range in 1 s, within usual bounds".into()),
        damping: default(pull.inertia / FADE, format!("free motion fades in {FADE} s")),
        friction: default(
            friction,
            format!(
                "{HOLD} x gravity at rest ({:.4} {unit}), or more for its bearing or the ground",
                pull.at_rest
            ),
        ),
    }
}

/// What gravity and inertia do about one joint.
struct Pull {
    at_rest: f64,
    /// The same with its sign: along the joint.
    along: f64,
    worst: f64,
    least_friction: f64,
    inertia: f64,
}

impl Pull {
    fn of(motion: &JointMotion, loads: &[Load]) -> Self {
        let mass: f64 = loads.iter().map(|l| l.mass).sum();
        if !motion.kind.turns() {
            let along = -mass * GRAVITY * motion.axis.z;
            let least_friction = RUNNER * mass * GRAVITY;
            let at_rest = along.abs();
            return Self { at_rest, along, worst: at_rest, least_friction, inertia: mass };
        }
        let inertia = loads.iter().map(|l| about_axis(l, motion)).sum::<f64>().max(1e-12);
        let moment: DVec3 = loads.iter().map(|l| (l.centre - motion.pivot) * l.mass).sum();
        let torque = |angle: f64| {
            let turned = DQuat::from_axis_angle(motion.axis, angle) * moment;
            motion.axis.dot(turned.cross(DVec3::NEG_Z)) * GRAVITY
        };
        let (lower, upper) = motion.range.ends();
        let along_range = (0..=64).map(|i| lower + (upper - lower) * f64::from(i) / 64.0);
        let worst = along_range.map(|q| torque(q).abs()).fold(0.0, f64::max);
        let least_friction = BEARING * GRAVITY * (mass * inertia).sqrt();
        let along = torque(0.0);
        Self { at_rest: along.abs(), along, worst, least_friction, inertia }
    }

    /// With what the ground does to the joint through the feet behind it.
    fn standing(self, motion: &JointMotion, feet: &[Foot]) -> Self {
        if feet.is_empty() {
            return self;
        }
        let arm = |f: &Foot| f.at - motion.pivot;
        let up = |f: &Foot| DVec3::Z * f.force;
        let push = |f: &Foot| match motion.kind.turns() {
            true => motion.axis.dot(arm(f).cross(up(f))),
            false => motion.axis.dot(up(f)),
        };
        let stands = (self.along + feet.iter().map(push).sum::<f64>()).abs();
        let rolls = motion.kind.turns() && motion.axis.z.abs() <= LEVEL;
        let radius = |f: &Foot| arm(f).reject_from_normalized(motion.axis).length();
        let rolling = |f: &Foot| if rolls { ROLLING * f.force * radius(f) } else { 0.0 };
        let rolling = feet.iter().map(rolling).sum::<f64>();
        let least_friction = self.least_friction.max(rolling);
        Self { least_friction: least_friction.max(STAND * stands), ..self }
    }
}

/// Moment of inertia of a load about the joint's axis line, kg·m².
fn about_axis(load: &Load, motion: &JointMotion) -> f64 {
    let arm = motion.axis.cross(load.centre - motion.pivot).length_squared();
    motion.axis.dot(load.inertia * motion.axis) + load.mass * arm
}

fn speed(motion: &JointMotion) -> f64 {
    let [least, most] = if motion.kind.turns() { TURN_SPEED } else { SLIDE_SPEED };
    match motion.range {
        Range::Continuous => most,
        limits => limits.span().clamp(least, most),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use object::JointKind;

    fn lid(axis: DVec3) -> (JointMotion, Load) {
        let range = Range::Limits { lower: 0.0, upper: std::f64::consts::FRAC_PI_2 };
        let motion = JointMotion { kind: JointKind::Revolute, axis, pivot: DVec3::ZERO, range };
        let inertia = DMat3::from_diagonal(DVec3::splat(0.01));
        (motion, Load { mass: 2.0, centre: DVec3::new(0.0, -0.25, 0.0), inertia })
    }

    #[test]
    fn a_level_lid_is_held_and_can_be_lifted() {
        let (motion, load) = lid(DVec3::NEG_X);
        let d = drive(&motion, &[load], &[]);
        let gravity = 2.0 * GRAVITY * 0.25;
        assert!((d.friction.value - 1.3 * gravity).abs() < 1e-12);
        assert!(d.effort.value >= 3.0 * (gravity + d.friction.value));
        assert!((d.damping.value - 2.0 * (0.01 + 2.0 * 0.0625)).abs() < 1e-12);
    }

    #[test]
    fn a_door_on_upright_hinges_needs_its_bearing_only() {
        let (motion, load) = lid(DVec3::Z);
        let d = drive(&motion, &[load], &[]);
        let gyration = (2.0_f64 * (0.01 + 0.125)).sqrt();
        assert!((d.friction.value - 0.02 * GRAVITY * gyration).abs() < 1e-12);
    }

    #[test]
    fn a_hanging_flap_is_at_rest_but_heavy_when_opened() {
        let (motion, mut load) = lid(DVec3::X);
        load.centre = DVec3::new(0.0, 0.0, -0.25);
        let d = drive(&motion, &[load], &[]);
        let opened = 2.0 * GRAVITY * 0.25;
        assert!(d.friction.value < opened && d.effort.value > 3.0 * opened);
    }

    #[test]
    fn a_lift_carries_its_weight_and_a_drawer_only_rubs() {
        let (mut motion, load) = lid(DVec3::Z);
        motion.kind = JointKind::Prismatic;
        assert!((drive(&motion, &[load], &[]).friction.value - 1.3 * 2.0 * GRAVITY).abs() < 1e-12);
        motion.axis = DVec3::NEG_Y;
        assert!((drive(&motion, &[load], &[]).friction.value - 0.05 * 2.0 * GRAVITY).abs() < 1e-12);
    }

    #[test]
    fn a_leg_holds_what_stands_on_it_and_a_wheel_rolls_to_a_halt() {
        let (motion, load) = lid(DVec3::X);
        let foot = Foot { part: 0, at: DVec3::new(0.0, -0.5, -1.0), force: 30.0 };
        let pushed = 30.0 * 0.5 - 2.0 * GRAVITY * 0.25;
        let leg = drive(&motion, &[load], &[foot]);
        assert!((leg.friction.value - 2.0 * pushed).abs() < 1e-12, "{leg:?}");
        let under = Foot { at: DVec3::new(0.7, 0.0, -0.3), ..foot };
        let centred = Load { centre: DVec3::ZERO, mass: 0.1, ..load };
        let wheel = drive(&motion, &[centred], &[under]);
        assert!((wheel.friction.value - 0.03 * 30.0 * 0.3).abs() < 1e-12, "{wheel:?}");
    }
}
