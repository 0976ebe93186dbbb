//! Joints of UsdPhysics: kinds, axes, limits, and where the file has them stand.

use glamx::{DPose3, DQuat, DVec3};

use super::model::{Usd, is_length, vector};
use crate::read::assembly::{Bond, bare, relative};
use crate::read::depends::{MOVED, PLACED};
use crate::read::draft::MimicDraft;
use crate::robot::{Dynamics, Joint, Limit, Motion, Spring, Unread};

/// How far from 0 a joint's value may stand for the rounding of single precision, radians or metres.
const ROUNDING: f64 = 1e-5;
/// How far a joint's two frames may stand apart, metres, and be turned, radians.
const APART: [f64; 2] = [1e-3, 0.01];
/// Directions of a generic joint.
const FREE: [&str; 6] = ["transX", "transY", "transZ", "rotX", "rotY", "rotZ"];

/// Whether a prim of that kind is a joint.
pub(super) fn is_joint(kind: &str) -> bool {
    kind.starts_with("Physics") && kind.ends_with("Joint")
}

/// How a joint moves: by its words for one direction.
struct Way {
    kind: Motion,
    axis: DVec3,
    /// What its drive, and its limit, are called.
    word: &'static str,
    lower: Option<f64>,
    upper: Option<f64>,
}

/// One end of a joint.
struct End {
    body: Option<usize>,
    /// Its frame in the world.
    frame: DPose3,
    /// How the prim it is told in is turned.
    turn: DQuat,
}

impl Usd<'_> {
    /// The joint between two bodies; none where it is off or binds nothing.
    pub(super) fn bond(&mut self, prim: usize) -> Option<Bond> {
        if !self.prims.flag(prim, "physics:jointEnabled", true) {
            return None;
        }
        let kind = self.prims.kind(prim).to_owned();
        if kind == "PhysicsDistanceJoint" {
            self.unread(prim, "a joint that keeps a distance is not read here", MOVED);
            return None;
        }
        let ends = [self.end(prim, 0)?, self.end(prim, 1)?];
        if ends[0].body == ends[1].body {
            let words = format!("{}: the joint leads from a body to itself", self.at(prim));
            self.draft.faults.references.push(words);
            return None;
        }
        let mut joint =
            bare(self.joint_name(prim), Motion::Fixed, DPose3::identity(), self.line(prim));
        let way = match kind.as_str() {
            "PhysicsFixedJoint" => None,
            "PhysicsRevoluteJoint" => self.single(prim, Motion::Revolute, "angular"),
            "PhysicsPrismaticJoint" => self.single(prim, Motion::Prismatic, "linear"),
            "PhysicsSphericalJoint" => {
                joint.kind = Motion::Floating;
                joint.held = Some("is a ball, which has no single range".into());
                None
            }
            "PhysicsJoint" => self.generic(prim, &mut joint),
            other => {
                let words = format!("{}: joint type `{other}` is unknown", self.at(prim));
                self.draft.faults.types.push(words);
                None
            }
        };
        let at = DPose3::from_parts(ends[1].frame.translation, ends[1].turn);
        let stands = relative(ends[0].frame, ends[1].frame);
        let mut mimic = None;
        let value = way.as_ref().map_or(0.0, |way| value(way, stands));
        if let Some(way) = &way {
            let axis = ends[1].frame.rotation * way.axis;
            joint.axis = (ends[1].turn.inverse() * axis).normalize_or_zero();
            joint.axis_as_written = joint.axis;
            self.fill(prim, way, value, &mut joint);
            mimic = self.mimic(prim, way);
        }
        if joint.kind != Motion::Floating {
            self.judge_frames(prim, &way, value, stands);
        }
        let ends = ends.map(|end| end.body);
        Some(Bond { joint, at, ends, mimic, second: None })
    }

    /// A joint's name, or its path where several are called the same.
    pub(super) fn joint_name(&self, prim: usize) -> String {
        let name = self.prims.name(prim);
        let same = |p: &usize| is_joint(self.prims.kind(*p)) && self.prims.name(*p) == name;
        match self.prims.all().filter(same).count() {
            1 => name.to_owned(),
            _ => self.prims.path(prim).trim_start_matches('/').to_owned(),
        }
    }

    fn end(&mut self, prim: usize, which: usize) -> Option<End> {
        let [body, place, turn] =
            ["body", "localPos", "localRot"].map(|w| format!("physics:{w}{which}"));
        let told = self.prims.numbers(prim, &place).and_then(vector).unwrap_or(DVec3::ZERO);
        let told = match is_length(told) {
            true => told,
            false => {
                let what = format!("{}: its {place} is beyond all bounds", self.at(prim));
                self.draft.faults.numbers.push(what.clone());
                self.draft.beside.unread.push(Unread { what, checks: PLACED });
                DVec3::ZERO
            }
        };
        let turn = match self.prims.numbers(prim, &turn) {
            Some(&[x, y, z, w]) => DQuat::from_xyzw(x, y, z, w),
            _ => DQuat::IDENTITY,
        };
        let is_turn = turn.is_finite() && turn.length() > 1e-6 && turn.length().is_finite();
        let turn = if is_turn { turn.normalize() } else { DQuat::IDENTITY };
        let Some(path) = self.prims.targets(prim, &body).first().cloned() else {
            let (at, own) = self.prims.world(told);
            return Some(End { body: None, frame: DPose3::from_parts(at, own * turn), turn: own });
        };
        let Some(target) = self.prims.find(&path) else {
            let words = format!("{}: its body{which} `{path}` does not exist", self.at(prim));
            self.draft.faults.references.push(words);
            return None;
        };
        let own = self.prims.turn(target);
        let body = self.prims.body_of(target).and_then(|b| self.bodies.get(&b).copied());
        let at = self.prims.point(target, told);
        let at = if is_length(at) { at } else { self.prims.point(target, DVec3::ZERO) };
        let frame = DPose3::from_parts(at, own * turn);
        Some(End { body, frame, turn: own })
    }

    fn single(&self, prim: usize, kind: Motion, word: &'static str) -> Option<Way> {
        let axis = match self.prims.word(prim, "physics:axis").unwrap_or("X") {
            "Y" => DVec3::Y,
            "Z" => DVec3::Z,
            _ => DVec3::X,
        };
        let said = |name: &str| self.prims.number(prim, name).filter(|n| n.is_finite());
        let (lower, upper) = (said("physics:lowerLimit"), said("physics:upperLimit"));
        Some(Way { kind, axis, word, lower, upper })
    }

    /// A joint that says of six directions which are locked: none free is fixed, one a hinge or a slide.
    fn generic(&self, prim: usize, joint: &mut Joint) -> Option<Way> {
        let said =
            |word: &str, end: &str| self.prims.number(prim, &format!("limit:{word}:physics:{end}"));
        let is_free = |word: &&str| {
            let is_limited = self.prims.has(prim, &format!("PhysicsLimitAPI:{word}"));
            let (low, high) = (said(word, "low"), said(word, "high"));
            !(is_limited && low.zip(high).is_some_and(|(low, high)| low >= high))
        };
        let free: Vec<&'static str> = FREE.into_iter().filter(is_free).collect();
        let &[word] = &free[..] else {
            if !free.is_empty() {
                joint.kind = Motion::Floating;
                joint.held = Some(format!("moves in {} directions at once", free.len()));
            }
            return None;
        };
        let axis = match word.as_bytes().last() {
            Some(b'X') => DVec3::X,
            Some(b'Y') => DVec3::Y,
            _ => DVec3::Z,
        };
        let kind = if word.starts_with("rot") { Motion::Revolute } else { Motion::Prismatic };
        let is_limited = self.prims.has(prim, &format!("PhysicsLimitAPI:{word}"));
        let end = |end: &str| said(word, end).filter(|n| is_limited && n.is_finite());
        Some(Way { kind, axis, word, lower: end("low"), upper: end("high") })
    }

    /// Limits, drive and friction; turns are in degrees.
    fn fill(&mut self, prim: usize, way: &Way, value: f64, joint: &mut Joint) {
        let turns = way.kind == Motion::Revolute;
        let metres = self.prims.metres;
        let unit = if turns { 1f64.to_radians() } else { metres };
        // Of a torque or a force in the stage's units, and of the same for each unit of the value.
        let force = self.prims.kilograms * metres * if turns { metres } else { 1.0 };
        let said = |name: String| self.prims.number(prim, &name).filter(|n| n.is_finite());
        let of_drive = |name: &str| said(format!("drive:{}:physics:{name}", way.word));
        let of_axis = |name: &str| said(format!("physxJointAxis:{}:{name}", way.word));
        let plain = |name: &str| said(name.to_owned());
        joint.kind = way.kind;
        let mut limit = Limit::NONE;
        match (way.lower, way.upper) {
            (Some(lower), Some(upper)) => {
                (limit.lower, limit.upper) = (lower * unit - value, upper * unit - value);
            }
            (None, None) if turns => joint.kind = Motion::Continuous,
            _ if turns => {
                joint.kind = Motion::Continuous;
                let words = format!("{}: has a limit at one end alone", self.at(prim));
                self.draft.beside.flags.push(("J1", words));
            }
            _ => joint.held = Some("has no limit at one of its ends".into()),
        }
        limit.effort = of_drive("maxForce").map(|n| n * force);
        let speed = of_axis("maxJointVelocity").or(plain("physxJoint:maxJointVelocity"));
        limit.velocity = speed.or(plain("newton:velocityLimit")).map(|n| n * unit);
        let has_range = way.lower.is_some() && way.upper.is_some();
        joint.limit = (has_range || turns).then_some(limit);
        joint.rest = value;
        let stiffness = of_drive("stiffness").unwrap_or(0.0) * force / unit;
        // Where a drive pulls to a place its damping is the drive's own.
        let damping = of_drive("damping").filter(|_| stiffness == 0.0).map(|n| n * force / unit);
        let damping = damping.or(plain("mjc:damping")).unwrap_or(0.0);
        let friction = of_axis("staticFrictionEffort").map(|n| n * force);
        let friction = friction.or(plain("newton:friction").map(|n| n * force));
        let friction = friction.or(plain("mjc:frictionloss")).unwrap_or(0.0);
        joint.dynamics = Some(Dynamics { damping: Some(damping), friction: Some(friction) });
        let spring = plain("mjc:stiffness").filter(|k| *k > 0.0);
        joint.spring = spring.map(|stiffness| Spring { stiffness, at: -value });
    }

    /// A follower in PhysX's words: value + gearing · leader + offset = 0.
    fn mimic(&self, prim: usize, way: &Way) -> Option<MimicDraft> {
        let all = &self.prims.prim(prim).targets;
        let key = all
            .keys()
            .find(|k| k.starts_with("physxMimicJoint:") && k.ends_with(":referenceJoint"))?;
        let leader = self.prims.find(all.get(key)?.first()?)?;
        let of = |name: &str| self.prims.number(prim, &key.replace("referenceJoint", name));
        let unit = if way.kind == Motion::Revolute { 1f64.to_radians() } else { self.prims.metres };
        let multiplier = -of("gearing").unwrap_or(1.0);
        let offset = -of("offset").unwrap_or(0.0) * unit;
        Some(MimicDraft { joint: self.joint_name(leader), multiplier, offset })
    }

    /// Flags a joint whose two frames do not meet: simulators pull its bodies together.
    fn judge_frames(&mut self, prim: usize, way: &Option<Way>, value: f64, stands: DPose3) {
        let moved = way.as_ref().map_or(DPose3::identity(), |way| match way.kind {
            Motion::Prismatic => DPose3::from_translation(way.axis * value),
            _ => DPose3::rotation(way.axis * value),
        });
        let off = relative(moved, stands);
        let (apart, turned) = (off.translation.length(), off.rotation.to_scaled_axis().length());
        let turned = turned.min(std::f64::consts::TAU - turned).abs();
        if apart > APART[0] || turned > APART[1] {
            let words = format!(
                "{}: its frames on both bodies stand {:.1} mm and {:.1} deg apart",
                self.at(prim),
                apart * 1e3,
                turned.to_degrees()
            );
            self.draft.beside.flags.push(("J5", words));
        }
    }
}

/// A joint's value where the file has its bodies.
fn value(way: &Way, stands: DPose3) -> f64 {
    use std::f64::consts::{PI, TAU};
    let value = match way.kind {
        Motion::Prismatic => stands.translation.dot(way.axis),
        _ => {
            let q = stands.rotation;
            let angle = 2.0 * DVec3::new(q.x, q.y, q.z).dot(way.axis).atan2(q.w);
            (angle + PI).rem_euclid(TAU) - PI
        }
    };
    if value.abs() < ROUNDING { 0.0 } else { value }
}
