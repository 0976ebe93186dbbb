//! Check S5: each joint moves alone, with everything it carries as one rigid body.
//!
//! A hinge swings in a field of gravity across its axis, and its period is compared with the
//! closed form. A slide is pushed by a known force, and its acceleration is compared.

use std::f64::consts::{PI, TAU};

use glamx::{DPose3, DQuat, DVec3};
use rapier3d_f64::dynamics::{GenericJoint, JointAxesMask, RigidBodyBuilder, RigidBodyHandle};
use rapier3d_f64::pipeline::PhysicsWorld;

use super::world::{RATE, mass_properties};
use crate::checks::sweep::Scene;
use crate::checks::sweep::bodies::Body;
use crate::mass::lump::Lump;

/// The period the field or spring is chosen for, seconds.
const PERIOD: f64 = 0.5;
/// Amplitude of the swing, radians.
const AMPLITUDE: f64 = 0.1;
/// A centre of mass nearer the axis than this share of the gyration radius swings on a spring
/// instead of in a field.
const CENTRED: f64 = 0.1;
/// Acceleration a slide is given, m/s², and for how long, seconds.
const ACCELERATION: f64 = 1.0;
const RUN: f64 = 0.25;

/// What a joint did and what the closed form says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// Seconds for a hinge, metres for a slide.
    pub measured: f64,
    /// The same by the closed form, from the file's masses.
    pub expected: f64,
    /// Whether a field of gravity, a spring or a force drove it.
    pub by: Driver,
}

/// What makes the joint move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driver {
    /// Gravity across the axis.
    Field,
    /// A torsion spring: the mass is balanced about the axis.
    Spring,
    /// A steady force along the slide.
    Force,
}

impl Swing {
    /// Relative difference; infinite if nothing was measured.
    pub fn error(&self) -> f64 {
        let error = (self.measured / self.expected - 1.0).abs();
        if error.is_finite() { error } else { f64::INFINITY }
    }
}

/// Lets one joint move and compares; `None` if what it carries has no sound mass.
pub fn swing(scene: &Scene, drive: usize) -> Option<Swing> {
    let rig = Rig::new(scene, drive)?;
    Some(if scene.turns(drive) { rig.hinge() } else { rig.slide() })
}

/// One rigid body on one joint, its frame at the pivot with x along the axis.
struct Rig {
    lump: Lump,
    /// Moment about the axis, kg·m², link by link from the file.
    inertia: f64,
}

impl Rig {
    fn new(scene: &Scene, drive: usize) -> Option<Self> {
        let robot = scene.robot;
        let joint = &robot.joints[scene.drives[drive].joint];
        let poses = &scene.at_rest.links;
        let along_x = DPose3::from_rotation(DQuat::from_rotation_arc(DVec3::X, joint.axis));
        let frame = poses[joint.child] * along_x;
        let local: Vec<DPose3> = poses.iter().map(|p| frame.inv_mul(p)).collect();
        let carried = || (0..robot.links.len()).filter(|&l| robot.is_under(l, joint.child));
        // All links of a body hang below the joint that carries its first.
        let bodies = scene.bodies.iter().filter(|b| robot.is_under(b.link, joint.child));
        let whole = |b: &Body| Lump::of_links(robot, b.links.iter().copied(), &local).is_sound();
        if !bodies.into_iter().all(whole) {
            return None;
        }
        let of_link = |l: usize| Lump::of_link(robot, l, &local[l]).about(DVec3::ZERO, DVec3::X);
        let inertia = carried().map(of_link).sum();
        Some(Self { lump: Lump::of_links(robot, carried(), &local), inertia })
    }

    fn world(&self, mask: JointAxesMask) -> (PhysicsWorld, RigidBodyHandle) {
        let mut world = PhysicsWorld { gravity: DVec3::ZERO, ..PhysicsWorld::default() };
        world.integration_parameters.dt = 1.0 / RATE;
        let anchor = world.insert_body(RigidBodyBuilder::fixed());
        let body = RigidBodyBuilder::dynamic()
            .additional_mass_properties(mass_properties(&self.lump))
            .can_sleep(false)
            .allow_fast_rotation(true);
        let body = world.insert_body(body);
        world.insert_impulse_joint(anchor, body, GenericJoint::new(mask));
        (world, body)
    }

    fn hinge(&self) -> Swing {
        let arm = self.lump.com.reject_from_normalized(DVec3::X);
        let inertia = self.inertia;
        let stiffness = inertia * (TAU / PERIOD).powi(2);
        let balanced = arm.length() < CENTRED * (inertia / self.lump.mass).sqrt();
        let (mut world, handle) = self.world(JointAxesMask::LOCKED_REVOLUTE_AXES);
        if !balanced {
            let strength = stiffness / (self.lump.mass * arm.length());
            world.gravity = arm.normalize() * strength;
        }
        if let Some(body) = world.bodies.get_mut(handle) {
            body.set_rotation(DQuat::from_rotation_x(AMPLITUDE), true);
        }
        let measured = period(&mut world, handle, if balanced { stiffness } else { 0.0 });
        // First terms of the pendulum's series; a spring's period knows no amplitude.
        let series = 1.0 + AMPLITUDE.powi(2) / 16.0;
        let (expected, by) =
            if balanced { (PERIOD, Driver::Spring) } else { (PERIOD * series, Driver::Field) };
        Swing { measured, expected, by }
    }

    fn slide(&self) -> Swing {
        let (mut world, handle) = self.world(JointAxesMask::LOCKED_PRISMATIC_AXES);
        if let Some(body) = world.bodies.get_mut(handle) {
            body.add_force_at_point(
                DVec3::X * (self.lump.mass * ACCELERATION),
                self.lump.com,
                true,
            );
        }
        (0..(RUN * RATE) as usize).for_each(|_| world.step());
        let measured = world.bodies.get(handle).map_or(f64::NAN, |b| b.linvel().x * RUN / 2.0);
        Swing { measured, expected: ACCELERATION * RUN * RUN / 2.0, by: Driver::Force }
    }
}

/// Twice the time between the first two passages through rest, seconds; NaN without them.
fn period(world: &mut PhysicsWorld, handle: RigidBodyHandle, stiffness: f64) -> f64 {
    let (mut before, mut passed): (f64, Vec<f64>) = (AMPLITUDE, Vec::new());
    for step in 1..=(2.0 * PERIOD * RATE) as usize {
        if let Some(body) = world.bodies.get_mut(handle) {
            body.reset_torques(true);
            body.add_torque(DVec3::X * (-stiffness * before), true);
        }
        world.step();
        let Some(body) = world.bodies.get(handle) else { return f64::NAN };
        let angle = 2.0 * body.rotation().x.atan2(body.rotation().w);
        let angle = if angle > PI { angle - TAU } else { angle };
        if before * angle < 0.0 {
            passed.push((step as f64 - angle / (angle - before)) / RATE);
        }
        if let &[first, second] = &passed[..] {
            return 2.0 * (second - first);
        }
        before = angle;
    }
    f64::NAN
}
