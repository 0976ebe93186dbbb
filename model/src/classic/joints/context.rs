//! One joint that is to be found: the moving part, what it touches, what stays behind when it
//! moves, and what its words say.

use object::condition::GivenJoint;
use object::{DVec3, KinematicTree};
use rayon::prelude::*;

use crate::classic::joints::candidates::Sources;
use crate::classic::joints::contact::Contact;
use crate::classic::joints::labelled::Labelled;
use crate::classic::joints::scene::{Body, Scene};
use crate::classic::joints::sweep::Probe;
use crate::classic::lexicon::words::{Meaning, Role, meaning};

/// A handle takes up at most this share of the part's surface.
const HANDLE: f64 = 0.3;
/// What is farther than this from all that stays is no hinge: a share of the object's diagonal.
const CLEAR: f64 = 0.02;
/// A handle's foot is as near as this to it, seen along what the part is thin along: a share of the
/// object's diagonal.
const FOOT: f64 = 0.03;
/// Middles closer than this are in line: a share of the object's diagonal.
const ALIGNED: f64 = 1e-6;
/// What hands find shows where the front is if it lies farther off the middle than this: a share of
/// the object's diagonal.
const BESIDE: f64 = 0.04;
/// What whoever uses an object has before them.
const FRONT: [Role; 7] = [
    Role::Knob,
    Role::Pointer,
    Role::Button,
    Role::Drawer,
    Role::Door,
    Role::FallDoor,
    Role::Lever,
];
/// Wheels show how they roll if they look less round about the other axis by this factor.
const PLAIN: f64 = 2.0;
/// How many probes candidates are compared with.
const FEW: usize = 48;

/// Everything known about a joint before its axis is chosen.
pub struct JointContext<'a> {
    /// Index of the part that moves.
    pub part: usize,
    /// The bodies.
    pub scene: &'a Scene,
    /// The part that moves.
    pub body: &'a Body,
    /// The part it hangs on.
    pub parent: &'a Body,
    /// Where it touches.
    pub contact: Contact,
    /// Bodies that stay.
    pub still: Vec<usize>,
    /// Points of everything that moves along.
    pub probes: Vec<Probe>,
    /// A few of them, to compare candidates with.
    pub few: Vec<Probe>,
    /// Axis of the parent's own joint.
    pub parent_axis: Option<DVec3>,
    /// What its text says.
    pub meaning: Meaning,
    /// Where one would take hold of it: what sticks out of it, or the parts it carries.
    pub handle: Option<DVec3>,
    /// Where a hand would take hold of it: levers and knobs it carries, or what sticks out of it and
    /// stands clear of all that stays.
    pub grip: Option<DVec3>,
    /// What sticks out of it near what stays, as the knuckles of a hinge do.
    pub knuckle: Option<DVec3>,
    /// Whether other parts hang on it.
    pub carries: bool,
    /// How many parts hang on what it hangs on, itself among them.
    pub siblings: usize,
    /// How many joints it has.
    pub joints: usize,
    /// Middle of the nearest part of the same role on the same parent.
    pub twin: Option<DVec3>,
    /// The level way from the object's middle to what hands find on other parts.
    pub reached: Option<DVec3>,
    /// The axle that wheels on other parts share, if they do.
    pub rolling: Option<DVec3>,
    /// The level way from the object's middle to the wheels on other parts.
    pub wheeled: Option<DVec3>,
    given: Vec<GivenJoint>,
}

impl<'a> JointContext<'a> {
    /// What is known about the joint of `part`; `None` for the root.
    pub fn new(
        scene: &'a Scene,
        from: &Labelled,
        part: usize,
        parent_axis: Option<DVec3>,
        seed: u64,
    ) -> Option<Self> {
        let tree = from.tree;
        let up = tree.parent(part)?;
        let (moving, still): (Vec<usize>, Vec<usize>) =
            (0..tree.len()).partition(|&p| tree.is_under(p, part));
        let carried = moving.iter().copied().filter(|&p| p != part);
        let contact = Contact::new(scene, [part, up], &still, seed);
        let starts: Vec<DVec3> =
            moving.iter().flat_map(|&p| scene.bodies[p].probes.iter().copied()).collect();
        let probes: Vec<Probe> =
            starts.par_iter().map(|&start| Probe::new(scene, &still, start)).collect();
        let (body, parent) = (&scene.bodies[part], &scene.bodies[up]);
        let meanings: Vec<Meaning> =
            tree.parts().iter().map(|p| meaning(&p.text, from.category)).collect();
        let roles: Vec<Role> = meanings.iter().map(|m| m.role).collect();
        let is_held = |&p: &usize| matches!(roles[p], Role::Lever | Role::Knob);
        let held: Vec<DVec3> =
            carried.clone().filter(is_held).map(|p| scene.bodies[p].centroid).collect();
        let out = sticking_out(body, parent);
        let (clear, near): (Vec<DVec3>, Vec<DVec3>) =
            out.iter().partition(|&&x| scene.nearest(&still, x, CLEAR).is_none());
        let near = apart(near, &clear, thin(body));
        let carried: Vec<DVec3> = carried.map(|p| scene.bodies[p].centroid).collect();
        Some(JointContext {
            part,
            handle: middle(&carried).or_else(|| middle(&out)),
            grip: middle(&held).or_else(|| middle(&clear)),
            knuckle: middle(&near),
            carries: moving.len() > 1,
            siblings: tree.children(up).count(),
            joints: tree.parts()[part].joints.len(),
            twin: twin(scene, (tree, &roles), part),
            reached: beside(scene, &roles, (&still, &FRONT)),
            wheeled: beside(scene, &roles, (&still, &[Role::Wheel])),
            rolling: rolling(scene, &roles, part),
            few: probes.iter().copied().step_by(probes.len() / FEW + 1).collect(),
            probes,
            meaning: meanings[part],
            given: from.given(part).to_vec(),
            scene,
            body,
            parent,
            contact,
            still,
            parent_axis,
        })
    }

    /// What is given of one of its joints; nothing where nothing is.
    pub fn given(&self, joint: usize) -> GivenJoint {
        self.given.get(joint).copied().unwrap_or_default()
    }

    /// Where candidates come from.
    pub fn sources(&self) -> Sources<'_> {
        let Self { scene, body, contact, parent, parent_axis, .. } = self;
        Sources { scene, body, contact, parent, parent_axis: *parent_axis }
    }

    /// From the middle of what the part hangs on to the part, in half extents of the former.
    pub fn outward(&self) -> DVec3 {
        let half = self.parent.bounds.size() / 2.0 + DVec3::splat(0.01);
        (self.body.centroid - self.parent.bounds.centre()) / half
    }
}

/// The coordinate axis along which a body is thinnest.
fn thin(body: &Body) -> DVec3 {
    let size = body.bounds.size();
    let thinner = |a: DVec3, b: DVec3| if size.dot(b) < size.dot(a) { b } else { a };
    [DVec3::X, DVec3::Y, DVec3::Z].into_iter().reduce(thinner).unwrap_or(DVec3::Z)
}

/// The points that are not, seen along an axis, close to any of some others: the foot of a handle stands
/// under it.
fn apart(points: Vec<DVec3>, others: &[DVec3], axis: DVec3) -> Vec<DVec3> {
    let is_under = |x: DVec3| {
        others.iter().any(|&o| (o - x).reject_from_normalized(axis).length_squared() < FOOT.powi(2))
    };
    points.into_iter().filter(|&x| !is_under(x)).collect()
}

/// Points on what sticks out of a flat part, away from its parent; none where that is much of it.
fn sticking_out(body: &Body, parent: &Body) -> Vec<DVec3> {
    let (size, thin) = (body.bounds.size(), thin(body));
    let off = (body.bounds.centre() - parent.bounds.centre()).dot(thin);
    // Of a part in the middle of its parent the last digit must not say which side is out.
    let outward = if off < -ALIGNED { -1.0 } else { 1.0 };
    let depth = |x: DVec3| (x - body.bounds.centre()).dot(thin) * outward;
    let far = size.dot(thin) * 0.2;
    let points = body.samples.iter().map(|s| s.position);
    let out: Vec<DVec3> = points.filter(|&x| depth(x) > far).collect();
    let few = (out.len() as f64) < HANDLE * body.samples.len() as f64;
    if few { out } else { Vec::new() }
}

/// The mean of some points.
fn middle(points: &[DVec3]) -> Option<DVec3> {
    (!points.is_empty()).then(|| points.iter().sum::<DVec3>() / points.len() as f64)
}

/// The middle of the nearest sibling of the same role.
fn twin(scene: &Scene, (tree, roles): (&KinematicTree, &[Role]), part: usize) -> Option<DVec3> {
    let here = scene.bodies[part].centroid;
    let alike = (0..tree.len())
        .filter(|&p| p != part && tree.parent(p) == tree.parent(part) && roles[p] == roles[part])
        .map(|p| scene.bodies[p].centroid);
    alike.min_by(|a, b| a.distance_squared(here).total_cmp(&b.distance_squared(here)))
}

/// The level way from the middle of the object to the parts of some roles among others, if they lie off it.
fn beside(scene: &Scene, roles: &[Role], (among, wanted): (&[usize], &[Role])) -> Option<DVec3> {
    let is_wanted = |&p: &usize| wanted.contains(&roles[p]);
    let found: Vec<DVec3> =
        among.iter().copied().filter(is_wanted).map(|p| scene.bodies[p].centroid).collect();
    let way = middle(&found)?.with_z(0.0);
    (way.length() > BESIDE).then(|| way.normalize())
}

/// The level axis about which the wheels, but for this part, look round: across it they are as long as
/// they are high, be they one wheel or a pair on an axle.
fn rolling(scene: &Scene, roles: &[Role], part: usize) -> Option<DVec3> {
    let is_wheel = |&p: &usize| p != part && roles[p] == Role::Wheel;
    let sizes = (0..roles.len()).filter(is_wheel).map(|p| scene.bodies[p].bounds.size());
    let sum: DVec3 = sizes.sum();
    let [about_x, about_y] = [sum.y, sum.x].map(|across| (across - sum.z).abs());
    let (less, more) = (about_x.min(about_y), about_x.max(about_y));
    let axle = if about_x < about_y { DVec3::X } else { DVec3::Y };
    (more > PLAIN * less).then_some(axle)
}
