//! An object in the making: parts with their words, joints and shapes, and the dice.

use std::fmt::Display;

use object::articulated::ObjectError;
use object::condition::name_from_text;
use object::{
    ArticulatedObject, DPose3, DVec3, JointKind, JointMotion, KinematicTree, Part, Range,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::error::FamilyError;
use super::shapes::{Shape, block, cylinder, hoop};
use crate::dataset::Specimen;

/// The dice of one object.
#[derive(Clone, Debug)]
pub(super) struct Dice(Pcg64Mcg);

impl Dice {
    /// Thrown for a seed and the object called so.
    pub(super) fn new(seed: u64, id: impl Display) -> Self {
        let digest = *blake3::hash(format!("{seed} {id}").as_bytes()).as_bytes();
        Self(Pcg64Mcg::seed_from_u64(u64::from_le_bytes(std::array::from_fn(|i| digest[i]))))
    }

    /// A number from `low` to `high`.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// A whole number from `low` to `high`, both included.
    pub(super) fn count(&mut self, low: usize, high: usize) -> usize {
        self.0.random_range(low..=high)
    }

    /// True with this probability.
    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.0.random::<f64>() < share
    }
}

/// Parts so far, the root first.
#[derive(Clone, Debug, Default)]
pub(super) struct Draft(Vec<DraftPart>);

#[derive(Clone, Debug)]
struct DraftPart {
    words: Vec<String>,
    parent: Option<usize>,
    motions: Vec<JointMotion>,
    shape: Shape,
}

/// Ways to say the same.
pub(super) fn words(all: &[&str]) -> Vec<String> {
    all.iter().map(|w| (*w).to_owned()).collect()
}

/// Every way to put one of `places` before one of `things`, such as `upper left` before `drawer`.
pub(super) fn placed(places: &[&str], things: &[&str]) -> Vec<String> {
    let pair = |p: &&str| things.iter().map(|t| format!("{p} {t}")).collect::<Vec<_>>();
    places.iter().flat_map(pair).collect()
}

/// A hinge with limits, radians.
pub(super) fn hinge(axis: DVec3, pivot: DVec3, lower: f64, upper: f64) -> JointMotion {
    let range = Range::Limits { lower, upper };
    JointMotion { kind: JointKind::Revolute, axis, pivot, range }
}

/// A hinge without limits.
pub(super) fn spin(axis: DVec3, pivot: DVec3) -> JointMotion {
    JointMotion { kind: JointKind::Continuous, axis, pivot, range: Range::Continuous }
}

/// A slide from where it stands to `upper`, metres.
pub(super) fn slide(axis: DVec3, pivot: DVec3, upper: f64) -> JointMotion {
    let range = Range::Limits { lower: 0.0, upper };
    JointMotion { kind: JointKind::Prismatic, axis, pivot, range }
}

/// A point.
pub(super) fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

const GREY: [u8; 3] = [150, 150, 150];

/// A box by its middle and its sizes.
pub(super) fn cuboid(middle: DVec3, size: DVec3) -> Shape {
    block((middle - size / 2.0).to_array(), (middle + size / 2.0).to_array(), GREY)
}

/// A round rod from one point to another.
pub(super) fn rod(from: DVec3, to: DVec3, radius: f64) -> Shape {
    let along = to - from;
    let turn = object::DQuat::from_rotation_arc(DVec3::Z, along.normalize());
    cylinder(radius, 0.0, along.length(), GREY).moved(DPose3::from_parts(from, turn))
}

/// A turned profile of (radius, height) pairs, its axis along `axis` from `foot`.
pub(super) fn lathe(profile: &[(f64, f64)], foot: DVec3, axis: DVec3) -> Shape {
    let turn = object::DQuat::from_rotation_arc(DVec3::Z, axis);
    super::shapes::turned(profile, 32, GREY).moved(DPose3::from_parts(foot, turn))
}

/// A ring about the vertical by its middle, the radius of its bar's middle, and how thick that is.
pub(super) fn rim(middle: DVec3, radius: f64, thick: f64) -> Shape {
    hoop(radius, thick, 32, GREY).at(middle.x, middle.y, middle.z)
}

/// A bowed handle before a front: two posts and a bar, `long` metres along `along`.
pub(super) fn handle(middle: DVec3, along: DVec3, long: f64, out: DVec3) -> Shape {
    let (end, depth) = (along * long / 2.0, out * 0.035);
    let bar = rod(middle - end + depth, middle + end + depth, 0.006);
    let post = |p: DVec3| rod(p, p + depth, 0.005);
    bar.with(post(middle - end * 0.85)).with(post(middle + end * 0.85))
}

/// An open box without a lid: floor and four walls.
pub(super) fn tray(min: DVec3, max: DVec3, wall: f64) -> Shape {
    let side = |a: [f64; 3], b: [f64; 3]| block(a, b, GREY);
    let (a, b, t) = (min, max, wall);
    side([a.x, a.y, a.z], [b.x, b.y, a.z + t])
        .with(side([a.x, a.y, a.z + t], [a.x + t, b.y, b.z]))
        .with(side([b.x - t, a.y, a.z + t], [b.x, b.y, b.z]))
        .with(side([a.x + t, a.y, a.z + t], [b.x - t, a.y + t, b.z]))
        .with(side([a.x + t, b.y - t, a.z + t], [b.x - t, b.y, b.z]))
}

/// A cabinet's body: tray on its back, open towards −y.
pub(super) fn shell(min: DVec3, max: DVec3, wall: f64) -> Shape {
    let side = |a: [f64; 3], b: [f64; 3]| block(a, b, GREY);
    let (a, b, t) = (min, max, wall);
    side([a.x, a.y, a.z], [a.x + t, b.y, b.z])
        .with(side([b.x - t, a.y, a.z], [b.x, b.y, b.z]))
        .with(side([a.x + t, a.y, a.z], [b.x - t, b.y, a.z + t]))
        .with(side([a.x + t, a.y, b.z - t], [b.x - t, b.y, b.z]))
        .with(side([a.x + t, b.y - t, a.z + t], [b.x - t, b.y, b.z - t]))
}

impl Draft {
    /// Begins with the part that stands still.
    pub(super) fn new(words: Vec<String>, shape: Shape) -> Self {
        Self(vec![DraftPart { words, parent: None, motions: vec![], shape }])
    }

    /// Adds to what stands still.
    pub(super) fn add_to_root(&mut self, shape: Shape) {
        if let Some(root) = self.0.first_mut() {
            root.shape.add(&shape);
        }
    }

    /// Adds a part and gives its number.
    pub(super) fn add(
        &mut self,
        parent: usize,
        words: Vec<String>,
        motions: Vec<JointMotion>,
        shape: Shape,
    ) -> usize {
        self.0.push(DraftPart { words, parent: Some(parent), motions, shape });
        self.0.len() - 1
    }

    /// Proves the object.
    pub(super) fn finish(self, id: String) -> Result<Specimen, FamilyError> {
        let (mut all, mut labels, mut names) = (Shape::default(), Vec::new(), Vec::new());
        for (label, part) in self.0.iter().enumerate() {
            labels.extend(std::iter::repeat_n(label as u16, part.shape.faces.len()));
            all.add(&part.shape);
            let name = name_from_text(part.words.first().map_or("part", String::as_str), &names);
            names.push(name);
        }
        let part = |(part, name): (&DraftPart, String)| Part {
            name,
            text: part.words.first().cloned().unwrap_or_default(),
            parent: part.parent,
            joints: part.motions.iter().map(|m| m.kind).collect(),
        };
        let tree = KinematicTree::new(self.0.iter().zip(names).map(part).collect())?;
        let unit = |m: &JointMotion| JointMotion { axis: m.axis.normalize(), ..*m };
        let joints = self.0.iter().map(|p| p.motions.iter().map(unit).collect()).collect();
        let object: Result<_, ObjectError> =
            ArticulatedObject::new(all.mesh()?, tree, labels, joints);
        let wordings = self.0.into_iter().map(|p| p.words).collect();
        Ok(Specimen { id, object: object?, wordings })
    }
}
