//! Joints of an SDFormat model: kinds, axes, limits.

use glamx::{DPose3, DVec3};

use super::frames::{OWN, WITHIN, WORLD};
use super::model::{Sdf, Told};
use super::numbers::{end, flaw, number, vector};
use super::tree::Element;
use crate::read::assembly::{Bond, bare, relative};
use crate::read::depends::{JOINTED, MOVED, PLACED};
use crate::read::draft::MimicDraft;
use crate::robot::{Dynamics, Joint, Limit, Motion, Spring, Unread};

/// The version of the format from which on an axis is told in the joint's frame.
const IN_JOINT: u32 = 5;

impl Sdf<'_> {
    /// The joint between two bodies; none where it binds nothing, which is said.
    pub(super) fn bond(&mut self, told: &Told) -> Option<Bond> {
        let of = told.element;
        let known = self.draft.faults.numbers.len();
        let ends = [self.end(told, "parent")?, self.end(told, "child")?];
        if ends[0] == ends[1] {
            let words = format!("{}: joint `{}` leads from a link to itself", of.at(), told.name);
            self.draft.faults.references.push(words);
            return None;
        }
        let at = self.absolute(told.scope, told.frame);
        let kind = of.get("type").unwrap_or_default();
        let mut joint = bare(told.name.clone(), Motion::Fixed, DPose3::identity(), of.line);
        let mut mimic = None;
        let mut second = None;
        match kind {
            "fixed" => {}
            "revolute" | "continuous" | "prismatic" => {
                (joint, mimic) = self.axis(told, "axis", kind, joint);
            }
            "universal" | "revolute2" => {
                let after = Joint { name: format!("{}__2", told.name), ..joint.clone() };
                (joint, mimic) = self.axis(told, "axis", "revolute", joint);
                second = Some(self.axis(told, "axis2", "revolute", after).0);
            }
            "ball" => {
                joint.kind = Motion::Floating;
                joint.held = Some("is a ball, which has no single range".into());
            }
            "screw" => {
                (joint, _) = self.axis(told, "axis", "revolute", joint);
                joint.held = Some("is a screw, which turns and slides at once".into());
            }
            "gearbox" => {
                let what = format!("{}: a gearbox is not read here", of.at());
                self.draft.beside.unread.push(Unread { what, checks: MOVED });
                return None;
            }
            other => {
                let at = of.at();
                self.draft.faults.types.push(format!("{at}: joint type `{other}` is unknown"));
            }
        }
        if let Some(why) = self.draft.faults.numbers.get(known).cloned() {
            joint.held = Some(format!("cannot be moved: {why}"));
            self.draft.beside.unread.push(Unread { what: why, checks: JOINTED });
        }
        let Some(at) = at else {
            let what = format!("{}: where it stands is not known", of.at());
            self.draft.beside.unread.push(Unread { what, checks: PLACED });
            return Some(Bond { joint, at: DPose3::identity(), ends, mimic, second });
        };
        Some(Bond { joint, at, ends, mimic, second })
    }

    /// The body at one end of a joint.
    fn end(&mut self, told: &Told, tag: &str) -> Option<Option<usize>> {
        let of = told.element;
        let name = of.said(tag).or_else(|| of.child(tag).and_then(|c| c.get("link")));
        let Some(name) = name else {
            let words = format!("{}: names no {tag}", of.at());
            self.draft.faults.references.push(words);
            return None;
        };
        if name == WORLD && tag == "parent" {
            return Some(None);
        }
        let found = self.frames.body(told.scope, name);
        if found.is_none() || found == Some(None) && tag == "child" {
            let words = format!(
                "line {}: joint `{}` names the {tag} `{name}`, which does not exist",
                of.line, told.name
            );
            self.draft.faults.references.push(words);
            return None;
        }
        found
    }

    fn axis(
        &mut self,
        told: &Told,
        tag: &str,
        kind: &str,
        joint: Joint,
    ) -> (Joint, Option<MimicDraft>) {
        let Some(of) = told.element.child(tag) else {
            let words = format!("has no `{tag}`");
            flaw(&mut self.draft.faults, told.element, words);
            return (Joint { kind: Motion::Continuous, axis: DVec3::Z, ..joint }, None);
        };
        let written = match of.child("xyz") {
            Some(xyz) => vector(&mut self.draft.faults, xyz).unwrap_or(DVec3::Z),
            None => DVec3::Z,
        };
        let unit = written.normalize_or_zero();
        let axis = self.turned(told, of, unit);
        let faults = &mut self.draft.faults;
        let (mut limit, mut ends) = (Limit::NONE, [None; 2]);
        if let Some(told) = of.child("limit") {
            ends = [end(faults, told, "lower"), end(faults, told, "upper")];
            // Below zero there is none, as older versions write it.
            let most = |v: Option<f64>| v.filter(|v| *v >= 0.0);
            limit.effort = most(end(faults, told, "effort"));
            limit.velocity = most(end(faults, told, "velocity"));
        }
        let is_limited = kind != "continuous" && ends.iter().all(Option::is_some);
        if let [Some(lower), Some(upper)] = ends {
            (limit.lower, limit.upper) = if is_limited { (lower, upper) } else { (0.0, 0.0) };
        }
        if kind != "continuous" && ends.iter().any(Option::is_some) && !is_limited {
            let words = format!("{}: has a limit at one end alone", of.at());
            self.draft.beside.flags.push(("J1", words));
        }
        let faults = &mut self.draft.faults;
        let dynamics = of.child("dynamics");
        let mut said = |tag| dynamics.map_or(0.0, |d| number(faults, d, tag, 0.0));
        let (damping, friction) = (Some(said("damping")), Some(said("friction")));
        let (stiffness, at) = (said("spring_stiffness"), said("spring_reference"));
        let kind = match (kind, is_limited) {
            ("prismatic", _) => Motion::Prismatic,
            (_, true) => Motion::Revolute,
            (_, false) => Motion::Continuous,
        };
        let has_limit = is_limited || kind != Motion::Prismatic;
        let mimic = of.child("mimic").map(|m| self.mimic(told, m));
        let joint = Joint {
            kind,
            axis,
            axis_as_written: if unit == DVec3::ZERO { written } else { axis },
            limit: has_limit.then_some(limit),
            dynamics: Some(Dynamics { damping, friction }),
            spring: (stiffness > 0.0).then_some(Spring { stiffness, at }),
            ..joint
        };
        (joint, mimic)
    }

    /// An axis in the joint's frame, from the one it is told in.
    fn turned(&mut self, told: &Told, of: &Element, axis: DVec3) -> DVec3 {
        let by_model = of.is_so("use_parent_model_frame") || of.file.minor < IN_JOINT;
        let said = of.child("xyz").and_then(|xyz| xyz.get("expressed_in"));
        let frame = said.or(by_model.then_some(OWN));
        let Some(frame) = frame else { return axis };
        let places = self.frames.named(told.scope, frame).zip(self.frames.place(told.frame));
        match places {
            Some((from, to)) => relative(to, from).rotation * axis,
            None => {
                let words = format!("its axis is told in `{frame}`, which stands nowhere");
                flaw(&mut self.draft.faults, of, words);
                axis
            }
        }
    }

    fn mimic(&mut self, told: &Told, of: &Element) -> MimicDraft {
        let faults = &mut self.draft.faults;
        let multiplier = number(faults, of, "multiplier", 1.0);
        let offset = number(faults, of, "offset", 0.0);
        let reference = number(faults, of, "reference", 0.0);
        let prefix = told.name.rsplit_once(WITHIN).map_or(String::new(), |(p, _)| format!("{p}::"));
        let ending = if of.get("axis") == Some("axis2") { "__2" } else { "" };
        let joint = format!("{prefix}{}{ending}", of.get("joint").unwrap_or_default());
        MimicDraft { joint, multiplier, offset: offset - multiplier * reference }
    }
}
