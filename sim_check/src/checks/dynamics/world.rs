//! A robot in the physics engine: bodies with the file's own mass properties, impulse joints,
//! convex colliders without mass.
//!
//! - Joints are impulse joints: the engine's multibody joints fling overlapping links apart at any
//!   speed.
//! - Bodies never sleep: a sleeping body stops a joint short of its end.
//! - Bodies that a joint connects do not touch, as in every simulator; the checks of group C have
//!   looked at those pairs. The engine is told so of the robot's bodies ([`Strangers`]), not of
//!   those that welds make of them.

use glamx::{DPose3, DQuat, DVec3};
use rapier3d_f64::dynamics::{
    GenericJoint, ImpulseJointHandle, JointAxesMask, JointAxis, MassProperties, MotorModel,
    RigidBodyBuilder, RigidBodyHandle,
};
use rapier3d_f64::geometry::{
    ColliderBuilder, Group, InteractionGroups, InteractionTestMode, SharedShape,
};
use rapier3d_f64::pipeline::{ActiveHooks, PhysicsWorld};

use super::feet::{FOOT, feet};
use super::strangers::Strangers;
use super::weld::{Welds, body_lump};
use crate::checks::sweep::Scene;
use crate::mass::lump::Lump;
use crate::robot::Motion;

/// Usual number of steps per second.
pub const RATE: f64 = 240.0;
/// Inner iterations of the solver where joints hang on joints, in the air.
const CHAIN_ITERATIONS: usize = 12;
/// The same where some of them are held still: with 12, a lamp's yoke that is pushed on its held arm
/// gets 1.7 % less far than it should, with 24 0.2 %.
const HELD_ITERATIONS: usize = 24;
/// Who touches whom: what moves, and what it meets on its way.
const MOVING: Group = Group::GROUP_1;
const STILL: Group = Group::GROUP_2;
/// Friction coefficient of all contacts.
const CONTACT_FRICTION: f64 = 0.6;
/// Gain of a motor that stands for friction: high enough to be stopped by its force limit alone.
const STIFF: f64 = 1e8;
/// How far a joint gives before it slips, radians and metres: it is drawn back that far, since the
/// engine lets a heavy part that hangs on a light one creep whatever holds it.
const GIVES: [f64; 2] = [2e-3, 1e-4];

/// Share of its error a held joint makes good in a second, 1/s; a quarter at each step.
const HOLD: f64 = RATE / 4.0;
/// Damping, 1/s, of a joint that is to have its speed at once.
const FAST: f64 = 1e4;

/// Whether the root stands fast or may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// Fixed to the world.
    Fixed,
    /// Free to fall.
    Free,
}

/// Which colliders take part.
#[derive(Clone, Debug, PartialEq)]
pub enum Touch {
    /// None.
    Nothing,
    /// These pieces, what a drive moves against what it does not, where no joint connects their
    /// bodies. What stays does not push what stays: a drive that shoves one part into another has
    /// dragged the first along, and that is told of anyway.
    Pieces {
        /// Pieces of the scene.
        pieces: Vec<usize>,
        /// The drive, index into the scene's.
        drive: usize,
        /// How far ahead of a contact the engine looks for it, metres; never farther than it does
        /// by itself.
        ahead: f64,
    },
    /// The corners of each body's hull, with level ground at this height (metres) and not with each
    /// other: whether parts overlap is for group C.
    Ground(f64),
}

/// How hard the engine's solver works on each step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Smaller steps within a step. Where one joint is driven and nothing is in its way they add
    /// nothing, and one is taken.
    pub substeps: usize,
    /// Inner iterations in each of them; `None`: the engine's own number, or more where joints hang
    /// on joints.
    pub iterations: Option<usize>,
}

impl Effort {
    /// The engine's own.
    pub const USUAL: Self = Self { substeps: 4, iterations: None };
}

/// How a simulation starts.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Root fixed or free.
    pub base: Base,
    /// Steps per second, [`RATE`] or more.
    pub rate: f64,
    /// Colliders.
    pub touch: Touch,
    /// Of the solver.
    pub effort: Effort,
    /// m/s².
    pub gravity: DVec3,
    /// One value per joint of the robot.
    pub q: Vec<f64>,
    /// Joints that stay at their value whatever happens, index into the robot's: what they tie
    /// together is one body.
    pub welded: Vec<usize>,
}

/// A running simulation.
pub struct Sim<'a> {
    scene: &'a Scene<'a>,
    world: PhysicsWorld,
    welds: Welds,
    /// One for each group of welded bodies.
    bodies: Vec<RigidBodyHandle>,
    /// Where each body of the scene stands in its group's frame.
    places: Vec<DPose3>,
    /// The moving ones, by their number in the robot.
    joints: Vec<Linkage>,
    strangers: Strangers,
    gravity: DVec3,
    /// Whether joints hang on joints in the air.
    is_chain: bool,
}

/// A moving joint in the engine.
struct Linkage {
    joint: usize,
    handle: ImpulseJointHandle,
    bodies: [usize; 2],
    frames: [DPose3; 2],
    axis: JointAxis,
    value: f64,
    grip: Option<Grip>,
}

/// Dry friction in a joint.
struct Grip {
    /// N·m or N.
    friction: f64,
    /// The value it holds on to.
    anchor: f64,
}

/// Why a simulation cannot start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimFault {
    /// A moving body the engine cannot move.
    #[error("link `{0}` moves but has no sound mass and inertia")]
    Massless(String),
    /// A collider the engine refuses.
    #[error("the physics engine refuses the hull of {0}")]
    Collider(String),
}

/// The engine's unit of length for a scene, metres.
fn unit(scene: &Scene) -> f64 {
    (scene.diagonal / 2.0).clamp(0.01, 1.0)
}

/// How far ahead of a contact the engine looks at most, metres.
pub fn farthest_ahead(scene: &Scene) -> f64 {
    let parameters = rapier3d_f64::dynamics::IntegrationParameters::default();
    parameters.normalized_prediction_distance * unit(scene)
}

/// The joints that are welded, and those that nothing here moves: held ones, and what floats.
fn still(scene: &Scene, welded: &[usize]) -> Vec<usize> {
    let joints = scene.robot.joints.iter().enumerate();
    let is_still =
        |j: &crate::robot::Joint| j.kind.moves() && (j.held.is_some() || !j.kind.has_axis());
    let mut all: Vec<usize> = joints.filter(|(_, j)| is_still(j)).map(|(j, _)| j).collect();
    all.extend(welded.iter().copied().filter(|j| !is_still(&scene.robot.joints[*j])));
    all
}

/// Which of the robot's joints are welded.
fn welded(scene: &Scene, setup: &Setup) -> Vec<bool> {
    let mut welded = vec![false; scene.robot.joints.len()];
    setup.welded.iter().for_each(|&j| welded[j] = true);
    welded
}

/// Whether a body that moves hangs on another one that does: held still, it takes the solver more
/// rounds to carry along.
fn is_chain(scene: &Scene, setup: &Setup, welds: &Welds) -> bool {
    let robot = scene.robot;
    let root = welds.of(scene.body_index(robot.root()));
    let moves = |link: usize| welds.of(scene.body_index(link)) != root;
    let welded = welded(scene, setup);
    let turns = |j: usize| robot.joints[j].kind.has_axis() && !welded[j];
    let joints = (0..robot.joints.len()).filter(|&j| turns(j)).map(|j| &robot.joints[j]);
    joints.into_iter().any(|j| moves(j.parent) && moves(j.child))
}

/// Whether one joint is driven and nothing is in its way: the engine's smaller steps within a step
/// then add nothing.
fn is_alone(scene: &Scene, setup: &Setup) -> bool {
    let free = matches!(&setup.touch, Touch::Pieces { pieces, .. } if pieces.is_empty());
    let joints = &scene.robot.joints;
    let welded = welded(scene, setup);
    let turns = |j: &usize| joints[*j].kind.has_axis() && !welded[*j];
    free && (0..joints.len()).filter(turns).count() == 1
}

/// A collider's group, and those it touches if they say the same of it.
fn meets(own: Group, others: Group) -> InteractionGroups {
    InteractionGroups::new(own, others, InteractionTestMode::And)
}

/// A lump as the engine takes it.
pub fn mass_properties(lump: &Lump) -> MassProperties {
    let (moments, turn) = lump.principal();
    MassProperties::with_principal_inertia_frame(lump.com, lump.mass, moments, turn)
}

impl<'a> Sim<'a> {
    /// Puts the robot into the engine.
    ///
    /// # Errors
    /// [`SimFault`] if a body or collider cannot be built.
    pub fn new(scene: &'a Scene<'a>, setup: &Setup) -> Result<Self, SimFault> {
        let setup = &Setup { welded: still(scene, &setup.welded), ..setup.clone() };
        let mut world = PhysicsWorld { gravity: setup.gravity, ..PhysicsWorld::default() };
        world.integration_parameters.dt = 1.0 / setup.rate;
        world.integration_parameters.length_unit = unit(scene);
        world.integration_parameters.contact_recycling = false;
        world.integration_parameters.warmstart_joints = true;
        let welds = Welds::new(scene, &setup.welded);
        let is_grounded = matches!(setup.touch, Touch::Ground(_));
        let is_chain = !is_grounded && is_chain(scene, setup, &welds);
        let parameters = &mut world.integration_parameters;
        let needed = setup.effort.iterations.or(is_chain.then_some(CHAIN_ITERATIONS));
        if let Some(iterations) = needed {
            parameters.num_internal_pgs_iterations = iterations;
        }
        let substeps = if is_alone(scene, setup) { 1 } else { setup.effort.substeps };
        parameters.num_solver_iterations = substeps;
        let poses = scene.robot.link_poses(&setup.q);
        let places = (0..scene.bodies.len()).map(|b| welds.place(scene, b, &poses)).collect();
        let (bodies, joints, gravity) = (vec![], vec![], setup.gravity);
        let strangers = Strangers::of(scene);
        let mut sim =
            Self { scene, world, welds, bodies, places, joints, strangers, gravity, is_chain };
        sim.add_bodies(setup, &poses)?;
        sim.add_joints(setup, &poses);
        match setup.touch {
            Touch::Nothing => {}
            Touch::Pieces { ref pieces, drive, ahead } => {
                sim.look_ahead(ahead);
                sim.add_colliders(pieces, drive, &poses)?;
            }
            Touch::Ground(height) => sim.add_feet_and_ground(height, &poses),
        }
        sim.weigh();
        Ok(sim)
    }

    /// Makes the engine take in the masses now: it would know them after the first step only.
    fn weigh(&mut self) {
        for &handle in &self.bodies {
            if let Some(body) = self.world.bodies.get_mut(handle) {
                body.recompute_mass_properties_from_colliders(&self.world.colliders);
            }
        }
    }

    fn add_bodies(&mut self, setup: &Setup, poses: &[DPose3]) -> Result<(), SimFault> {
        let scene = self.scene;
        let root = scene.robot.root();
        let rooted = self.welds.of(scene.body_index(root));
        for (b, body) in scene.bodies.iter().enumerate() {
            let anchored = setup.base == Base::Fixed && self.welds.of(b) == rooted;
            if !anchored && !body_lump(scene, b, poses).is_sound() {
                return Err(SimFault::Massless(scene.robot.links[body.link].name.clone()));
            }
        }
        for (group, &top) in self.welds.tops().iter().enumerate() {
            let builder = if setup.base == Base::Fixed && group == rooted {
                RigidBodyBuilder::fixed()
            } else {
                let lump = self.welds.lump(scene, group, poses);
                RigidBodyBuilder::dynamic().additional_mass_properties(mass_properties(&lump))
            };
            let at = poses[scene.bodies[top].link];
            let builder = builder.pose(at).can_sleep(false).allow_fast_rotation(true);
            self.bodies.push(self.world.insert_body(builder));
        }
        Ok(())
    }

    fn add_joints(&mut self, setup: &Setup, poses: &[DPose3]) {
        let robot = self.scene.robot;
        let welded = welded(self.scene, setup);
        let turns = |j: &usize| robot.joints[*j].kind.has_axis() && !welded[*j];
        for j in (0..robot.joints.len()).filter(turns) {
            let joint = &robot.joints[j];
            let bodies = [joint.parent, joint.child].map(|l| self.scene.body_index(l));
            let along_x = DPose3::from_rotation(DQuat::from_rotation_arc(DVec3::X, joint.axis));
            let parent_body = poses[self.scene.bodies[bodies[0]].link];
            let frames =
                [parent_body.inv_mul(&(poses[joint.parent] * joint.origin)) * along_x, along_x];
            let (axis, mask) = if joint.kind.turns() {
                (JointAxis::AngX, JointAxesMask::LOCKED_REVOLUTE_AXES)
            } else {
                (JointAxis::LinX, JointAxesMask::LOCKED_PRISMATIC_AXES)
            };
            let mut built = GenericJoint::new(mask);
            let [first, second] = [0, 1].map(|s| self.places[bodies[s]] * frames[s]);
            built.set_local_frame1(first).set_local_frame2(second);
            if let Some((lower, upper)) = joint.ends().filter(|_| joint.kind != Motion::Continuous)
            {
                built.set_limits(axis, [lower, upper]);
            }
            let [a, b] = bodies.map(|b| self.handle(b));
            let handle = self.world.insert_impulse_joint(a, b, built);
            let value = setup.q.get(j).copied().unwrap_or(0.0);
            let grip = None;
            self.joints.push(Linkage { joint: j, handle, bodies, frames, axis, value, grip });
        }
    }

    /// The engine's own distance, 2 % of its unit of length, is that of a room full of things that
    /// fly about; between parts a hair apart each contact in it is solved for nothing.
    /// Further ahead than anything goes in a step is far enough to do without the engine's search
    /// for what passed through something within one.
    fn look_ahead(&mut self, ahead: f64) {
        let parameters = &mut self.world.integration_parameters;
        parameters.max_ccd_substeps = 0;
        let distance = ahead / parameters.length_unit;
        let own = parameters.normalized_prediction_distance;
        parameters.normalized_prediction_distance = distance.min(own);
    }

    fn add_colliders(
        &mut self,
        pieces: &[usize],
        drive: usize,
        poses: &[DPose3],
    ) -> Result<(), SimFault> {
        for &p in pieces {
            let piece = &self.scene.pieces[p];
            let refused = || SimFault::Collider(self.scene.label(p));
            let hull = piece.hull.to_polyhedron().ok_or_else(refused)?;
            let body = &self.scene.bodies[piece.body];
            let in_body = poses[body.link].inv_mul(&(poses[piece.link] * piece.origin));
            let place = self.places[piece.body] * in_body;
            let groups = match self.scene.bodies[piece.body].moved_by[drive] {
                true => meets(MOVING, MOVING | STILL),
                false => meets(STILL, MOVING),
            };
            let collider = ColliderBuilder::new(SharedShape::new(hull))
                .position(place)
                .density(0.0)
                .friction(CONTACT_FRICTION)
                .collision_groups(groups)
                .active_hooks(ActiveHooks::FILTER_CONTACT_PAIRS)
                .user_data(piece.body as u128);
            self.world.insert_collider(collider, Some(self.handle(piece.body)));
        }
        Ok(())
    }

    /// A hull meets level ground with its corners alone, so each corner becomes a small ball: the
    /// engine's own contact between polyhedra keeps four corners of a face, neighbours on a round
    /// foot, and lets it rock for ever.
    fn add_feet_and_ground(&mut self, height: f64, poses: &[DPose3]) {
        let radius = FOOT * self.scene.diagonal;
        for (b, body) in self.scene.bodies.iter().enumerate() {
            let handle = self.handle(b);
            for corner in feet(self.scene, body, poses) {
                let in_body = poses[body.link].inverse_transform_point(corner);
                let ball = ColliderBuilder::ball(radius)
                    .translation(self.places[b].transform_point(in_body))
                    .density(0.0)
                    .friction(CONTACT_FRICTION)
                    .collision_groups(meets(MOVING, STILL));
                self.world.colliders.insert_with_parent(ball, handle, &mut self.world.bodies);
            }
        }
        let half = 20.0 * self.scene.diagonal;
        let slab = ColliderBuilder::cuboid(half, half, half)
            .translation(DVec3::new(0.0, 0.0, height - radius - half))
            .friction(CONTACT_FRICTION)
            .collision_groups(meets(STILL, MOVING));
        self.world.insert_collider(slab, None);
    }

    /// Lets everything fall at a speed, m/s.
    pub fn fall(&mut self, speed: f64) {
        for &handle in &self.bodies {
            if let Some(body) = self.world.bodies.get_mut(handle) {
                body.set_linvel(DVec3::NEG_Z * speed, true);
            }
        }
    }

    /// One step.
    pub fn step(&mut self) {
        self.grip();
        self.world.step_with_events(&self.strangers, &());
        for k in 0..self.joints.len() {
            self.joints[k].value = self.measured(&self.joints[k]);
        }
    }

    /// The joint's value now, unwrapped from the last one.
    fn measured(&self, linkage: &Linkage) -> f64 {
        let [a, b] = [0, 1].map(|s| self.pose(linkage.bodies[s]) * linkage.frames[s]);
        let between = a.inv_mul(&b);
        if linkage.axis == JointAxis::LinX {
            return between.translation.x;
        }
        let angle = 2.0 * between.rotation.x.atan2(between.rotation.w);
        let turns = ((linkage.value - angle) / std::f64::consts::TAU).round();
        angle + turns * std::f64::consts::TAU
    }

    /// What a body of the scene is to the engine.
    fn handle(&self, body: usize) -> RigidBodyHandle {
        self.bodies[self.welds.of(body)]
    }

    /// Where a body of the scene stands.
    pub fn pose(&self, body: usize) -> DPose3 {
        let group = self.world.bodies.get(self.handle(body));
        group.map_or(DPose3::identity(), |b| *b.position()) * self.places[body]
    }

    /// The value of a joint of the robot, radians (unwrapped) or metres; 0 if it is welded.
    pub fn value(&self, joint: usize) -> f64 {
        self.linkage(joint).map_or(0.0, |l| l.value)
    }

    /// Where a joint of the robot stands among the moving ones, if it moves.
    fn place(&self, joint: usize) -> Option<usize> {
        self.joints.binary_search_by_key(&joint, |l| l.joint).ok()
    }

    fn linkage(&self, joint: usize) -> Option<&Linkage> {
        self.place(joint).map(|at| &self.joints[at])
    }

    /// Whether all positions and velocities are finite and nothing was quarantined.
    pub fn is_finite(&self) -> bool {
        let fine = |&h: &RigidBodyHandle| {
            self.world.bodies.get(h).is_some_and(|b| {
                b.position().is_finite() && b.linvel().is_finite() && b.angvel().is_finite()
            })
        };
        self.bodies.iter().all(fine)
    }

    /// Kinetic plus potential energy of all moving bodies, joules.
    pub fn energy(&self) -> f64 {
        let moving = self.bodies.iter().filter_map(|&h| self.world.bodies.get(h));
        let of = |b: &rapier3d_f64::dynamics::RigidBody| {
            b.kinetic_energy() - b.mass() * self.gravity.dot(b.center_of_mass())
        };
        moving.filter(|b| b.is_dynamic()).map(of).sum()
    }

    /// Total moving mass, kg.
    pub fn mass(&self) -> f64 {
        let moving = self.bodies.iter().filter_map(|&h| self.world.bodies.get(h));
        moving.filter(|b| b.is_dynamic()).map(|b| b.mass()).sum()
    }

    /// Where each body's centre of mass is, and how the body is turned.
    pub fn places(&self) -> Vec<DPose3> {
        let bodies = self.bodies.iter().filter_map(|&h| self.world.bodies.get(h));
        bodies.map(|b| DPose3::from_parts(b.center_of_mass(), b.position().rotation)).collect()
    }

    /// How far any body has moved (metres) and turned (radians) from where it was.
    pub fn strayed(&self, from: &[DPose3]) -> (f64, f64) {
        self.places().iter().zip(from).fold((0.0, 0.0), |(moved, turned), (now, was)| {
            let angle = now.rotation.angle_between(was.rotation);
            (now.translation.distance(was.translation).max(moved), angle.max(turned))
        })
    }

    /// Holds a joint at a value against the start of other drives, hundreds of rad/s².
    pub fn hold(&mut self, joint: usize, at: f64) {
        let Some(linkage) = self.linkage(joint) else { return };
        let (axis, speed) = (linkage.axis, HOLD * (at - linkage.value));
        if self.is_chain {
            self.world.integration_parameters.num_internal_pgs_iterations = HELD_ITERATIONS;
        }
        self.velocity(joint, axis, speed, FAST);
    }

    /// Drives a joint towards a value as a servo does: acceleration = 5 · damping · error −
    /// damping · speed, whatever it carries, and no faster than `fastest`, rad/s or m/s.
    pub fn servo(&mut self, joint: usize, target: f64, damping: f64, fastest: f64) {
        let Some(linkage) = self.linkage(joint) else { return };
        let wanted = 5.0 * (target - linkage.value);
        let axis = linkage.axis;
        self.velocity(joint, axis, wanted.clamp(-fastest, fastest), damping);
    }

    /// Drives a joint at a speed, whatever it carries: acceleration = damping · error of speed.
    fn velocity(&mut self, joint: usize, axis: JointAxis, speed: f64, damping: f64) {
        self.motor(joint, |built| {
            built.set_motor_model(axis, MotorModel::AccelerationBased);
            built.set_motor_velocity(axis, speed, damping);
            built.set_motor_max_force(axis, f64::MAX);
        });
    }

    /// Lets a joint move against friction (N·m or N) and damping (N·m·s/rad or N·s/m) only.
    pub fn rub(&mut self, joint: usize, friction: f64, damping: f64) {
        let Some(at) = self.place(joint) else { return };
        let linkage = &mut self.joints[at];
        let axis = linkage.axis;
        if friction > 0.0 {
            linkage.grip = Some(Grip { friction, anchor: linkage.value });
            return;
        }
        self.motor(joint, |built| {
            built.set_motor_model(axis, MotorModel::ForceBased);
            built.set_motor_velocity(axis, 0.0, damping);
            built.set_motor_max_force(axis, f64::MAX);
        });
    }

    /// Draws what friction holds back to where it slipped to last.
    fn grip(&mut self) {
        let share = HOLD / RATE / self.world.integration_parameters.dt;
        for linkage in &mut self.joints {
            let (axis, value) = (linkage.axis, linkage.value);
            let Some(grip) = linkage.grip.as_mut() else { continue };
            let gives = GIVES[usize::from(axis == JointAxis::LinX)];
            grip.anchor = grip.anchor.max(value - gives).min(value + gives);
            let Some(built) = self.world.impulse_joints.get_mut(linkage.handle, true) else {
                continue;
            };
            built.data.set_motor_model(axis, MotorModel::ForceBased);
            built.data.set_motor_velocity(axis, share * (grip.anchor - value), STIFF);
            built.data.set_motor_max_force(axis, grip.friction);
        }
    }

    fn motor(&mut self, joint: usize, set: impl FnOnce(&mut GenericJoint)) {
        let Some(linkage) = self.linkage(joint) else { return };
        if let Some(built) = self.world.impulse_joints.get_mut(linkage.handle, true) {
            set(&mut built.data);
        }
    }

    /// Pushes a joint with a steady torque (N·m) or force (N), equal and opposite on its parent.
    pub fn push(&mut self, joint: usize, effort: f64) {
        let Some(linkage) = self.linkage(joint) else { return };
        let frame = self.pose(linkage.bodies[0]) * linkage.frames[0];
        let along = frame.rotation * DVec3::X * effort;
        let turns = linkage.axis == JointAxis::AngX;
        for (body, along) in [(linkage.bodies[1], along), (linkage.bodies[0], -along)] {
            let handle = self.handle(body);
            let Some(b) = self.world.bodies.get_mut(handle) else { continue };
            if turns {
                b.add_torque(along, true);
            } else {
                b.add_force_at_point(along, frame.translation, true);
            }
        }
    }
}
