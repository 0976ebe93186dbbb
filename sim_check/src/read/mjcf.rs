//! MJCF text → the same links and joints a URDF gives, so that one set of checks judges both.
//!
//! A body with a joint is a link whose frame stands at the joint's anchor. The root is the body
//! that floats freely, if it is the only one; else a link `world`, as in URDFs that are fixed to
//! it. Angles are in degrees unless the compiler says otherwise. What touches nothing (contype and
//! conaffinity 0) is seen; what touches is seen too where its body has nothing else to show. Planes
//! in the world are the ground and no part of the asset. What has no counterpart in URDF (balls,
//! several joints in one body, tendons, loops, includes) makes the checks of the tree unknown.

mod attributes;
mod bodies;
mod geoms;
mod masses;
mod meshes;
mod model;
mod numbers;
mod places;

use std::collections::BTreeMap;

use roxmltree::Node;

use crate::read::draft::{Draft, JointDraft, MAX_LINKS, MAX_SHAPES, MimicDraft};
use crate::read::rgba::rgba;
use crate::read::xml::Reader;
use attributes::{Compiler, Defaults, Element};
use model::Model;

/// Elements that change what a model means and are not read here.
const FOREIGN: &[&str] =
    &["include", "replicate", "composite", "flexcomp", "flex", "attach", "model", "tendon"];

/// Reads a `<mujoco>` element.
pub(crate) fn model(reader: &mut Reader, root: Node, draft: &mut Draft) {
    let name = root.attribute("model").unwrap_or("model").trim();
    draft.name = if name.is_empty() { "model".into() } else { name.to_owned() };
    let count = |tag: &str| root.descendants().filter(|n| n.has_tag_name(tag)).count();
    let (bodies, geoms) = (count("body"), count("geom"));
    if bodies >= MAX_LINKS || geoms > MAX_SHAPES {
        let most = format!("at most {MAX_LINKS} bodies and {MAX_SHAPES} geoms");
        return reader.fault(root, format!("{most}, found {bodies} and {geoms}"));
    }
    let compiler = Compiler::read(reader, root);
    let defaults = Defaults::read(reader, root);
    let (meshes, paints) = (BTreeMap::new(), BTreeMap::new());
    let mut model = Model { reader, compiler, defaults, meshes, paints, draft };
    model.report_foreign(root);
    model.meshes = model.mesh_assets(root);
    model.paints = model.materials(root);
    model.worldbody(root);
    model.drives(root);
    model.equalities(root);
    model.check_names();
}

impl Model<'_, '_> {
    fn foreign(&mut self, node: Node, what: &str) {
        let at = self.reader.at(node);
        self.draft.foreign.push(format!("{at}: {what} is not read here"));
    }

    /// Colours of materials; a texture is not read, and the colour beside it tints it alone.
    fn materials(&self, root: Node) -> BTreeMap<String, [u8; 4]> {
        let assets = root.children().filter(|n| n.has_tag_name("asset"));
        let all = assets.flat_map(|n| n.children()).filter(|n| n.has_tag_name("material"));
        let elements = all.map(|n| self.defaults.element(n, None));
        let bare = elements.filter(|e| e.get("texture").is_none());
        bare.filter_map(|e| Some((e.get("name")?.to_owned(), rgba(e.get("rgba")?)?))).collect()
    }

    fn report_foreign(&mut self, root: Node) {
        for tag in FOREIGN {
            if let Some(node) = root.descendants().find(|n| n.has_tag_name(*tag)) {
                self.foreign(node, "this element");
            }
        }
    }

    fn check_names(&mut self) {
        let links = self.draft.links.iter().map(|l| (l.name.as_str(), l.line));
        self.reader.check_names("body", links);
        let joints = self.draft.joints.iter().map(|j| (j.joint.name.as_str(), j.joint.line));
        self.reader.check_names("joint", joints);
    }

    fn joint(&mut self, name: &str) -> Option<&mut JointDraft> {
        self.draft.joints.iter_mut().find(|j| j.joint.name == name)
    }

    /// Efforts of actuators, and velocities under `custom`, where joints do not say them.
    fn drives(&mut self, root: Node) {
        let below = |tag: &'static str| {
            let parents = root.children().filter(move |n| n.has_tag_name(tag));
            parents.flat_map(|n| n.children()).filter(|n| n.is_element()).collect::<Vec<_>>()
        };
        for node in below("actuator") {
            let element = self.defaults.element(node, None);
            let Some(name) = element.get("joint").map(str::to_owned) else { continue };
            let effort = self.effort(&element);
            let limit = self.joint(&name).and_then(|j| j.joint.limit.as_mut());
            if let Some(limit) = limit {
                limit.effort = limit.effort.or(effort);
            }
        }
        for node in below("custom").into_iter().filter(|n| n.has_tag_name("numeric")) {
            let name = node.attribute("name").and_then(|n| n.strip_suffix("_velocity"));
            let velocity = self.reader.optional(node, "data");
            let joint = name.and_then(|name| self.joint(name));
            if let Some(limit) = joint.and_then(|j| j.joint.limit.as_mut()) {
                limit.velocity = limit.velocity.or(velocity);
            }
        }
    }

    /// The largest force of an actuator: its own range, or a motor's control range times its gear.
    fn effort(&mut self, actuator: &Element) -> Option<f64> {
        let range = self.numbers(actuator, "forcerange", 2);
        let gear = self.numbers(actuator, "gear", 1).map_or(1.0, |g| g[0]);
        let is_motor = actuator.node.has_tag_name("motor");
        let control = if is_motor { self.numbers(actuator, "ctrlrange", 2) } else { None };
        let largest = |r: Vec<f64>| r[0].abs().max(r[1].abs());
        range.map(largest).or_else(|| control.map(|r| largest(r) * gear.abs()))
    }

    /// Joints that follow others; whatever else ties bodies together is foreign.
    fn equalities(&mut self, root: Node) {
        let all = root.children().filter(|n| n.has_tag_name("equality"));
        for node in all.flat_map(|n| n.children()).filter(|n| n.is_element()) {
            let element = self.defaults.element(node, None);
            let off = element.get("active") == Some("false");
            match (node.tag_name().name(), element.get("joint1"), element.get("joint2")) {
                _ if off => {}
                ("joint", Some(follower), Some(leader)) => {
                    let [follower, leader] = [follower, leader].map(str::to_owned);
                    self.mimic(node, &follower, leader);
                }
                _ => self.foreign(node, "this equality"),
            }
        }
    }

    fn mimic(&mut self, node: Node, follower: &str, leader: String) {
        let element = self.defaults.element(node, None);
        let terms = self.numbers(&element, "polycoef", 1).unwrap_or_else(|| vec![0.0, 1.0]);
        if terms.iter().skip(2).any(|t| *t != 0.0) {
            return self.foreign(node, "a joint that follows another by more than a factor");
        }
        let (offset, multiplier) = (terms[0], terms.get(1).copied().unwrap_or(1.0));
        match self.joint(follower) {
            Some(joint) => joint.mimic = Some(MimicDraft { joint: leader, multiplier, offset }),
            None => self.reader.fault(node, format!("there is no joint `{follower}`")),
        }
    }
}

#[cfg(test)]
mod tests;
