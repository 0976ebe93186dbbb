//! What drives the joints of an MJCF model, and what ties them together.

use roxmltree::Node;

use super::attributes::Element;
use super::bodies::WORLD;
use super::model::Model;
use crate::read::depends::MOVED;
use crate::read::draft::{JointDraft, MimicDraft, Tie};

/// How far a servo may be asked beyond its joint's range, as a share of that, for rounding.
const WIDER: f64 = 0.01;

/// The elements below a section of a model, such as `actuator`.
fn below<'d>(root: Node<'d, 'd>, tag: &'static str) -> Vec<Node<'d, 'd>> {
    let parents = root.children().filter(move |n| n.has_tag_name(tag));
    parents.flat_map(|n| n.children()).filter(|n| n.is_element()).collect()
}

impl Model<'_, '_> {
    fn joint(&mut self, name: &str) -> Option<&mut JointDraft> {
        self.draft.joints.iter_mut().find(|j| j.joint.name == name)
    }

    /// Efforts of actuators, and velocities under `custom`, where joints do not say them.
    pub(super) fn drives(&mut self, root: Node) {
        let mut driven = 0;
        for node in below(root, "actuator") {
            let element = self.defaults.element(node, None);
            driven += 1;
            let named = element.get("joint").or(element.get("jointinparent"));
            let Some(name) = named.map(str::to_owned) else { continue };
            let effort = self.effort(&element);
            self.too_wide(&element, &name);
            let limit = self.joint(&name).and_then(|j| j.joint.limit.as_mut());
            if let Some(limit) = limit {
                limit.effort = limit.effort.or(effort);
            }
        }
        // A door may have a motor of its own.
        if driven > 1 {
            self.draft.beside.signs.push(format!("{driven} actuators"));
        }
        for node in below(root, "custom").into_iter().filter(|n| n.has_tag_name("numeric")) {
            let Some(name) = node.attribute("name").and_then(|n| n.strip_suffix("_velocity"))
            else {
                continue;
            };
            // One may hold as many numbers as one likes; the first is the velocity.
            let first = node.attribute("data").and_then(|data| data.split_whitespace().next());
            let velocity = first.and_then(|word| self.reader.parse(node, "data", word));
            if let Some(limit) = self.joint(name).and_then(|j| j.joint.limit.as_mut()) {
                limit.velocity = limit.velocity.or(velocity);
            }
        }
    }

    /// The largest force of an actuator at its joint: its own range, or a motor's control range,
    /// times its gear.
    fn effort(&mut self, actuator: &Element) -> Option<f64> {
        let gear = self.numbers(actuator, "gear", 1).map_or(1.0, |g| g[0]).abs();
        let is_motor = actuator.node.has_tag_name("motor");
        let limited = |name: &str| actuator.get(name) != Some("false");
        let range = self.numbers(actuator, "forcerange", 2).filter(|_| limited("forcelimited"));
        let control = self.numbers(actuator, "ctrlrange", 2);
        let control = control.filter(|_| is_motor && limited("ctrllimited"));
        let largest = |r: Vec<f64>| r[0].abs().max(r[1].abs()) * gear;
        range.or(control).map(largest).filter(|force| *force > 0.0)
    }

    /// A servo that may be asked for what its joint cannot reach.
    fn too_wide(&mut self, actuator: &Element, joint: &str) {
        let Some(asked) = self.numbers(actuator, "ctrlrange", 2) else { return };
        let is_servo = actuator.node.has_tag_name("position");
        let zero = self.coordinates.iter().find(|(n, ..)| n.as_deref() == Some(joint));
        let zero = zero.map_or(0.0, |(.., zero)| *zero);
        let limits = self.joint(joint).and_then(|j| j.joint.ends());
        let Some((lower, upper)) = limits.filter(|_| is_servo) else { return };
        let (lower, upper) = (lower + zero, upper + zero);
        let spare = WIDER * (upper - lower).abs();
        if asked[0] < lower - spare || asked[1] > upper + spare {
            let at = self.reader.at(actuator.node);
            let [from, to] = [asked[0], asked[1]];
            let words = format!(
                "{at}: may ask joint `{joint}` for {from} to {to}, which goes {lower:.4} to {upper:.4}"
            );
            self.draft.beside.flags.push(("J4", words));
        }
    }

    /// Joints that follow others, and bodies that are tied into loops.
    pub(super) fn equalities(&mut self, root: Node) {
        for node in below(root, "equality") {
            let element = self.defaults.element(node, None);
            let off = element.get("active") == Some("false");
            let said = |name: &str| element.get(name).map(str::to_owned);
            match (node.tag_name().name(), said("joint1"), said("joint2")) {
                _ if off => {}
                ("joint", Some(follower), Some(leader)) => self.follow(node, &follower, leader),
                ("joint", Some(joint), None) => self.hold(node, &joint, "is held by an equality"),
                ("connect" | "weld", ..) => self.tie(node, &element),
                ("tendon", ..) => self.unread(node, "an equality of tendons", MOVED),
                ("flex" | "flexvert" | "flexstrain", ..) => {}
                _ => self.unread(node, "this equality", MOVED),
            }
        }
    }

    fn hold(&mut self, node: Node, joint: &str, why: &str) {
        let at = self.reader.at(node);
        match self.joint(joint) {
            Some(found) => found.joint.held = Some(format!("{why} ({at})")),
            None => self.reader.fault(node, format!("there is no joint `{joint}`")),
        }
    }

    /// Two bodies tied together: what lies between them moves no longer on its own. A body that a
    /// program moves (mocap) drives what is tied to it, and holds nothing at rest.
    fn tie(&mut self, node: Node, element: &Element) {
        let at = self.reader.at(node);
        let said = |name: &str| element.get(name).map(str::to_owned);
        let sites = said("site1").zip(said("site2"));
        let of_site = |m: &Self, site: String| m.sites.get(&site).cloned();
        let bodies = match (said("body1"), sites) {
            (Some(first), _) => Some([first, said("body2").unwrap_or_else(|| WORLD.into())]),
            (None, Some((a, b))) => {
                of_site(self, a).zip(of_site(self, b)).map(|(first, second)| [first, second])
            }
            (None, None) => None,
        };
        let Some(bodies) = bodies else {
            return self.reader.fault(node, "names no two bodies to tie together");
        };
        if bodies.iter().any(|body| self.mocaps.contains(body)) {
            return;
        }
        self.draft.ties.push(Tie { bodies, why: format!("is part of a closed loop ({at})") });
    }

    fn follow(&mut self, node: Node, follower: &str, leader: String) {
        let element = self.defaults.element(node, None);
        let terms = self.numbers(&element, "polycoef", 1).unwrap_or_else(|| vec![0.0, 1.0]);
        if terms.iter().skip(2).any(|t| *t != 0.0) {
            let why = "is tied to another joint by more than a factor";
            self.hold(node, &leader, why);
            return self.hold(node, follower, why);
        }
        // Measured from where each stands as the file is written, as MuJoCo does.
        let (offset, multiplier) = (terms[0], terms.get(1).copied().unwrap_or(1.0));
        match self.joint(follower) {
            Some(joint) => joint.mimic = Some(MimicDraft { joint: leader, multiplier, offset }),
            None => self.reader.fault(node, format!("there is no joint `{follower}`")),
        }
    }

    /// Pairs of bodies that a model lets pass through each other.
    pub(super) fn excludes(&mut self, root: Node) {
        for node in below(root, "contact").into_iter().filter(|n| n.has_tag_name("exclude")) {
            let said = |name: &str| node.attribute(name).unwrap_or_default().to_owned();
            self.draft.apart.push(["body1", "body2"].map(said));
        }
    }

    /// The pose that the first keyframe declares, and one named `home` before others.
    pub(super) fn keyframes(&mut self, root: Node) {
        let keys = below(root, "keyframe");
        let is_home = |n: &&Node| n.attribute("name") == Some("home");
        let chosen = keys.iter().find(is_home).or(keys.first());
        let Some(node) = chosen.filter(|n| n.has_attribute("qpos")) else { return };
        let element = self.defaults.element(*node, None);
        let Some(values) = self.numbers(&element, "qpos", 1) else { return };
        let due: usize = self.coordinates.iter().map(|c| c.1).sum();
        if due != values.len() {
            let at = self.reader.at(*node);
            let words = format!("{at}: qpos has {} numbers, the joints have {due}", values.len());
            return self.draft.beside.flags.push(("J2", words));
        }
        let mut from = 0;
        for (name, width, zero) in &self.coordinates {
            if let (Some(name), 1) = (name, width) {
                self.draft.rests.insert(name.clone(), values[from] - zero);
            }
            from += width;
        }
        self.draft.declared = node.attribute("name").unwrap_or("the first").to_owned();
    }
}
