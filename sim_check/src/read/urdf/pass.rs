//! Our own pass over a `<robot>` element: every broken rule with its line, and the outline of the
//! links and joints, whose numbers `urdf-rs` fills in.
//!
//! What is found here is what `urdf-rs` 0.10 drops (lines, whether a thing was said at all, a
//! quaternion before version 1.1), accepts (words that are no numbers, `nan`, one name twice, a link
//! that is not there) or refuses for the whole file (a link without a name, a second `origin`).

use std::collections::BTreeSet;

use glamx::{DMat3, DPose3, DQuat, DVec3};
use roxmltree::Node;

use super::paint::Paints;
use crate::read::depends::{JOINTED, PLACED, WEIGHED};
use crate::read::draft::{Draft, JointDraft, MAX_LINKS, MAX_SHAPES, MimicDraft, NameFault};
use crate::read::xml::{Reader, shown};
use crate::robot::{
    Beside, Dynamics, Geometry, Inertial, Joint, Limit, Link, Motion, Shape, Unread,
};

impl Reader<'_> {
    /// Lists what is wrong with a `<robot>` element; all numbers of the outline are zero.
    pub(super) fn outline<'d>(&mut self, root: Node<'d, 'd>, draft: &mut Draft) {
        self.spares = true;
        draft.name = root.attribute("name").unwrap_or_default().trim().to_owned();
        if draft.name.is_empty() {
            let words = "the robot has no name".into();
            self.faults.names.push(NameFault { words, is_odd: true });
        }
        self.find_macros(root);
        let of_kind = |tag: &'static str| {
            root.children().filter(move |n| n.has_tag_name(tag)).collect::<Vec<_>>()
        };
        let (links, joints) = (of_kind("link"), of_kind("joint"));
        if links.len().max(joints.len()) > MAX_LINKS {
            let (l, j) = (links.len(), joints.len());
            self.fault(root, format!("at most {MAX_LINKS} links and joints, found {l} and {j}"));
            return;
        }
        let is_shape = |n: &Node| n.has_tag_name("visual") || n.has_tag_name("collision");
        let shapes = root.descendants().filter(is_shape).count();
        if shapes > MAX_SHAPES {
            self.fault(root, format!("at most {MAX_SHAPES} shapes, found {shapes}"));
            return;
        }
        let paints = Paints::read(root);
        self.loose_ends(root);
        let mut beside = Beside::default();
        draft.links = links.into_iter().map(|n| self.link(n, &paints, &mut beside)).collect();
        draft.joints = joints.into_iter().map(|n| self.sound_joint(n, &mut beside)).collect();
        beside.signs = signs(root);
        draft.beside = beside;
        self.check_names("link", draft.links.iter().map(|l| (l.name.as_str(), l.line)), false);
        self.check_names(
            "joint",
            draft.joints.iter().map(|j| (j.joint.name.as_str(), j.joint.line)),
            false,
        );
    }

    /// Notes materials that are defined nowhere, and joints of transmissions that are not there.
    fn loose_ends(&mut self, root: Node) {
        let of_kind = |tag: &'static str| root.descendants().filter(move |n| n.has_tag_name(tag));
        let name = |n: &Node<'_, '_>| n.attribute("name").map(|name| name.trim().to_owned());
        let says =
            |n: &Node| n.children().any(|c| c.has_tag_name("color") || c.has_tag_name("texture"));
        let defined: BTreeSet<String> =
            of_kind("material").filter(says).filter_map(|n| name(&n)).collect();
        let joints: BTreeSet<String> = of_kind("joint")
            .filter(|n| n.parent().is_some_and(|p| p == root))
            .filter_map(|n| name(&n))
            .collect();
        let mut loose = Vec::new();
        for node in of_kind("visual").flat_map(|v| v.children()) {
            let named = name(&node).filter(|n| !n.is_empty() && !defined.contains(n));
            if let Some(named) = named.filter(|_| node.has_tag_name("material") && !says(&node)) {
                let at = self.at(node);
                loose.push(format!("{at}: material `{}` is defined nowhere", shown(&named)));
            }
        }
        let drives = root.children().filter(|n| n.has_tag_name("transmission"));
        for node in drives.flat_map(|t| t.children()).filter(|n| n.has_tag_name("joint")) {
            if let Some(named) = name(&node).filter(|n| !joints.contains(n)) {
                let at = self.at(node);
                loose
                    .push(format!("{at}: a transmission's joint `{}` is not there", shown(&named)));
            }
        }
        self.faults.loose_flags.extend(loose);
    }

    fn find_macros(&mut self, root: Node) {
        let is_macro = |n: &Node| n.tag_name().namespace().is_some_and(|s| s.contains("xacro"));
        if let Some(node) = root.descendants().find(is_macro) {
            self.fault(node, "a macro of xacro; expand it first");
        }
    }

    fn link<'d>(&mut self, node: Node<'d, 'd>, paints: &Paints<'d>, beside: &mut Beside) -> Link {
        let shapes = |this: &mut Self, tag: &str| {
            let of_tag = node.children().filter(|n| n.has_tag_name(tag));
            let one = |n| {
                let known = this.faults.numbers.len();
                let shape = Shape { colour: paints.of(n), ..this.shape(n) };
                match this.faults.numbers.get(known).cloned() {
                    Some(reason) => Shape { geometry: Geometry::Unread { reason }, ..shape },
                    None => shape,
                }
            };
            of_tag.map(one).collect::<Vec<_>>()
        };
        Link {
            name: node.attribute("name").unwrap_or_default().to_owned(),
            inertial: self.weight(node, beside),
            visuals: shapes(self, "visual"),
            collisions: shapes(self, "collision"),
            between: false,
            line: self.line(node),
        }
    }

    /// Mass and inertia of a link; where they cannot be read they are unknown, not missing.
    fn weight(&mut self, node: Node, beside: &mut Beside) -> Option<Inertial> {
        let known = self.faults.numbers.len();
        let inertial = self.only(node, "inertial").map(|n| self.inertial(n));
        match self.faults.numbers.get(known) {
            Some(what) => {
                beside.unread.push(Unread { what: what.clone(), checks: WEIGHED });
                None
            }
            None => inertial,
        }
    }

    fn inertial(&mut self, node: Node) -> Inertial {
        let origin = self.origin(node);
        if let Some(mass) = self.required(node, "mass") {
            self.number(mass, "value");
        }
        if let Some(inertia) = self.required(node, "inertia") {
            for entry in ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"] {
                self.number(inertia, entry);
            }
        }
        Inertial { origin, mass: 0.0, inertia: DMat3::ZERO, line: self.line(node) }
    }

    fn shape(&mut self, node: Node) -> Shape {
        let origin = self.origin(node);
        let line = self.line(node);
        let mut shape = Shape {
            origin,
            geometry: Geometry::Unread { reason: format!("line {line}: no geometry") },
            scale: DVec3::ONE,
            source: String::new(),
            colour: None,
            mask: [1, 1],
            line,
        };
        let Some(geometry) = self.required(node, "geometry") else { return shape };
        let kinds: Vec<_> = geometry.children().filter(Node::is_element).collect();
        let Some(&kind) = kinds.first() else {
            self.flaw(geometry, "expected a shape, found none");
            return shape;
        };
        if kinds.len() > 1 {
            let words = format!("holds {} shapes, of which programs take the first", kinds.len());
            let at = self.at(geometry);
            self.faults.flags.push(format!("{at}: {words}"));
        }
        self.fill_geometry(kind, &mut shape);
        shape
    }

    fn fill_geometry(&mut self, kind: Node, shape: &mut Shape) {
        shape.source = kind.tag_name().name().to_owned();
        shape.geometry = match shape.source.as_str() {
            "box" => {
                self.vector(kind, "size", None);
                Geometry::Box { size: DVec3::ZERO }
            }
            "sphere" => {
                self.length(kind, "radius");
                Geometry::Sphere { radius: 0.0 }
            }
            "cylinder" => {
                self.radius_and_length(kind);
                Geometry::Cylinder { radius: 0.0, length: 0.0 }
            }
            "capsule" => {
                self.radius_and_length(kind);
                Geometry::Capsule { radius: 0.0, length: 0.0 }
            }
            "mesh" => {
                shape.scale = self.vector(kind, "scale", Some(DVec3::ONE));
                shape.source = kind.attribute("filename").unwrap_or_default().to_owned();
                self.mesh(kind, shape)
            }
            other => {
                let at = self.at(kind);
                let words =
                    format!("{at}: expected box, cylinder, sphere or mesh, found `{other}`");
                self.faults.flags.push(words);
                Geometry::Unread { reason: format!("geometry `{other}` is unknown") }
            }
        };
    }

    fn radius_and_length(&mut self, kind: Node) {
        self.length(kind, "radius");
        self.length(kind, "length");
    }

    fn mesh(&mut self, node: Node, shape: &Shape) -> Geometry {
        let mut faults = Vec::new();
        let geometry = self.shelf.geometry(&shape.source, shape.scale, &mut faults);
        let line = self.line(node);
        self.faults.files.extend(faults.into_iter().map(|f| format!("line {line}: {f}")));
        geometry
    }

    /// A joint; one whose numbers cannot be read is not moved, and where it stands is unknown.
    fn sound_joint(&mut self, node: Node, beside: &mut Beside) -> JointDraft {
        let known = self.faults.numbers.len();
        let mut drafted = self.joint(node);
        if drafted.joint.kind.has_axis() && !node.children().any(|n| n.has_tag_name("axis")) {
            let (at, name) = (self.at(node), shown(&drafted.joint.name));
            let words = format!("{at}: joint `{name}` names no axis, and programs take 1 0 0");
            beside.flags.push(("J1", words));
        }
        if let Some(why) = self.faults.numbers.get(known).cloned() {
            drafted.joint.held = Some(format!("cannot be moved: {why}"));
            beside.unread.push(Unread { what: why.clone(), checks: JOINTED });
            if why.contains("`origin`") {
                beside.unread.push(Unread { what: why, checks: PLACED });
            }
        }
        drafted
    }

    fn joint(&mut self, node: Node) -> JointDraft {
        if let Some(axis) = self.only(node, "axis") {
            self.vector(axis, "xyz", None);
        }
        let kind = self.motion(node);
        let joint = Joint {
            name: node.attribute("name").unwrap_or_default().to_owned(),
            kind,
            parent: usize::MAX,
            child: usize::MAX,
            origin: self.origin(node),
            axis: DVec3::ZERO,
            axis_as_written: DVec3::ZERO,
            limit: self.only(node, "limit").map(|n| self.limit(n)),
            dynamics: self.only(node, "dynamics").map(|n| self.dynamics(n)),
            mimic: None,
            rest: 0.0,
            spring: None,
            held: None,
            line: self.line(node),
        };
        let parent = self.link_name(node, "parent");
        let child = self.link_name(node, "child");
        let mimic = self.only(node, "mimic").map(|n| self.mimic(n));
        JointDraft { joint, parent, child, mimic }
    }

    fn motion(&mut self, node: Node) -> Motion {
        match node.attribute("type").unwrap_or_default() {
            "fixed" => Motion::Fixed,
            "revolute" => Motion::Revolute,
            "continuous" => Motion::Continuous,
            "prismatic" => Motion::Prismatic,
            "floating" => Motion::Floating,
            "planar" => Motion::Planar,
            other => {
                let at = self.at(node);
                self.faults.types.push(format!("{at}: joint type `{other}` is unknown"));
                Motion::Fixed
            }
        }
    }

    /// Whether an attribute is there at all: `urdf-rs` has no word for that.
    fn said(&mut self, node: Node, attribute: &str) -> Option<f64> {
        self.optional(node, attribute);
        node.has_attribute(attribute).then_some(0.0)
    }

    fn limit(&mut self, node: Node) -> Limit {
        self.optional(node, "lower");
        self.optional(node, "upper");
        let effort = self.said(node, "effort");
        Limit { effort, velocity: self.said(node, "velocity"), ..Limit::NONE }
    }

    fn dynamics(&mut self, node: Node) -> Dynamics {
        let damping = self.said(node, "damping");
        Dynamics { damping, friction: self.said(node, "friction") }
    }

    fn mimic(&mut self, node: Node) -> MimicDraft {
        self.optional(node, "multiplier");
        self.optional(node, "offset");
        let joint = node.attribute("joint").unwrap_or_default().to_owned();
        MimicDraft { joint, multiplier: 0.0, offset: 0.0 }
    }

    fn link_name(&mut self, node: Node, tag: &str) -> String {
        let name = self.only(node, tag).and_then(|n| n.attribute("link"));
        if name.is_none() {
            let at = self.at(node);
            self.faults.references.push(format!("{at}: names no {tag} link"));
        }
        name.unwrap_or_default().to_owned()
    }

    /// `<origin>`: only a turn told as a quaternion is read here, all else is checked.
    fn origin(&mut self, node: Node) -> DPose3 {
        let Some(origin) = self.only(node, "origin") else { return DPose3::identity() };
        self.vector(origin, "xyz", Some(DVec3::ZERO));
        self.vector(origin, "rpy", Some(DVec3::ZERO));
        let turn = origin.attribute("quat_xyzw").and_then(|text| self.quaternion(origin, text));
        DPose3::from_parts(DVec3::ZERO, turn.unwrap_or(DQuat::IDENTITY))
    }

    /// The turn that `quat_xyzw` tells. `urdf-rs` would make angles of it, and takes every pitch
    /// within 0.26° of a right angle for a right angle.
    fn quaternion(&mut self, node: Node, text: &str) -> Option<DQuat> {
        if !tells_quaternions(node) {
            let cure = "write `rpy`, or `version=\"1.1\"` in `robot`";
            self.flaw(node, format!("quat_xyzw is URDF 1.1, which the robot does not say: {cure}"));
            return None;
        }
        if node.has_attribute("rpy") {
            self.flaw(node, "tells its turn twice, as rpy and as quat_xyzw");
        }
        let words: Vec<_> = text.split_whitespace().collect();
        let &[x, y, z, w] = &words[..] else {
            let (text, found) = (shown(text), words.len());
            let rule = format!("quat_xyzw=\"{text}\" must be four numbers, found {found}");
            self.flaw(node, rule);
            return None;
        };
        let [x, y, z, w] = [x, y, z, w].map(|word| self.parse(node, "quat_xyzw", word));
        let told = DQuat::from_xyzw(x?, y?, z?, w?);
        let length = told.length();
        if !(length > 0.0 && length.is_finite()) {
            self.flaw(node, format!("quat_xyzw=\"{}\" is no turn", shown(text)));
            return None;
        }
        Some(told * (1.0 / length))
    }
}

/// What only robots' files have beside links and joints. A transmission is none: files of objects have them,
/// so that Drake finds their actuators.
fn signs(root: Node) -> Vec<String> {
    let has = |tag: &&str| root.children().any(|n| n.has_tag_name(*tag));
    let told = ["ros2_control"].into_iter().filter(has);
    told.map(|tag| format!("a `{tag}` element")).collect()
}

/// Whether the robot is of a version that has quaternions: 1.1 or later. Without a version, and
/// where it is not two numbers, it is 1.0.
fn tells_quaternions(node: Node) -> bool {
    let version = node.document().root_element().attribute("version").unwrap_or_default();
    let numbers = version.trim().split_once('.').map(|(a, b)| (a.parse::<u32>(), b.parse::<u32>()));
    matches!(numbers, Some((Ok(major), Ok(minor))) if (major, minor) >= (1, 1))
}
