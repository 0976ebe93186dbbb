//! Bodies of an MJCF model → links, and their joints.

use glamx::{DPose3, DVec3};
use roxmltree::Node;

use super::attributes::{DEEPEST, Element};
use super::geoms::Shapes;
use super::model::Model;
use crate::read::draft::JointDraft;
use crate::robot::{Dynamics, Joint, Limit, Link, Motion};

/// Name of the link that stands for the world.
const WORLD: &str = "world";

/// The link a body hangs on.
struct Parent<'p> {
    name: &'p str,
    /// The parent body's frame in its link's frame, and those of frames in between.
    frame: DPose3,
    class: Option<&'p str>,
    depth: usize,
}

/// What a body holds, elements of frames in it included.
#[derive(Default)]
struct Inside<'d> {
    geoms: Vec<(Element<'d>, DPose3)>,
    bodies: Vec<(Node<'d, 'd>, DPose3, Option<String>)>,
    joints: Vec<Element<'d>>,
    free: Vec<Node<'d, 'd>>,
    inertial: Option<Element<'d>>,
}

impl Model<'_, '_> {
    pub(super) fn worldbody(&mut self, root: Node) {
        let mut world = Inside::default();
        for node in root.children().filter(|n| n.has_tag_name("worldbody")) {
            let class = node.attribute("childclass");
            self.gather(node, DPose3::identity(), (class, 0), &mut world);
        }
        let mut shapes = Shapes::default();
        for (geom, at) in std::mem::take(&mut world.geoms) {
            self.geom(&geom, at, &mut shapes);
        }
        let is_bare = shapes.seen.is_empty() && shapes.touched.is_empty();
        if let [(node, at, class)] = &world.bodies[..]
            && is_bare
            && self.floats(*node)
        {
            return self.free_root(*node, *at, class.as_deref());
        }
        let (visuals, collisions) = shapes.split();
        let line = self.reader.line(root);
        let world_link = Link { name: WORLD.into(), inertial: None, visuals, collisions, line };
        self.draft.links.push(world_link);
        self.hang(world.bodies, WORLD, DPose3::identity(), 0);
    }

    fn floats(&self, node: Node) -> bool {
        let is_free = |n: &Node| {
            n.has_tag_name("freejoint")
                || n.has_tag_name("joint") && n.attribute("type") == Some("free")
        };
        node.children().any(|n| is_free(&n))
    }

    /// The root link is the body itself, in the frame of the world.
    fn free_root(&mut self, node: Node, at: DPose3, class: Option<&str>) {
        let class = node.attribute("childclass").or(class);
        let element = self.defaults.element(node, class);
        let own = at * self.place(&element);
        let mut inside = Inside::default();
        self.gather(node, own, (class, 0), &mut inside);
        let name = self.body_name(node);
        for joint in std::mem::take(&mut inside.joints) {
            if joint.get("type") != Some("free") {
                self.foreign(joint.node, "a joint of a body that floats");
            }
        }
        let bodies = std::mem::take(&mut inside.bodies);
        self.link(node, &name, own, inside);
        self.hang(bodies, &name, DPose3::identity(), 0);
    }

    /// The bodies below a link; their frames are already in that link's.
    fn hang(
        &mut self,
        bodies: Vec<(Node, DPose3, Option<String>)>,
        name: &str,
        frame: DPose3,
        depth: usize,
    ) {
        for (node, at, class) in bodies {
            let class = class.as_deref();
            self.body(node, &Parent { name, frame: frame * at, class, depth });
        }
    }

    fn body_name(&self, node: Node) -> String {
        let unnamed = || format!("body_{}", self.draft.links.len());
        node.attribute("name").map_or_else(unnamed, str::to_owned)
    }

    fn body(&mut self, node: Node, parent: &Parent) {
        if parent.depth > DEEPEST {
            return self.reader.fault(node, format!("bodies nest at most {DEEPEST} deep"));
        }
        let class = node.attribute("childclass").or(parent.class).map(str::to_owned);
        let element = self.defaults.element(node, class.as_deref());
        let placed = parent.frame * self.place(&element);
        let name = self.body_name(node);
        let mut inside = Inside::default();
        let joints: Vec<_> = node.children().filter(|n| n.has_tag_name("joint")).collect();
        let joint = joints.first().map(|n| self.defaults.element(*n, class.as_deref()));
        let anchor = joint.as_ref().and_then(|j| self.vector(j, "pos")).unwrap_or(DVec3::ZERO);
        let own = DPose3::from_translation(-anchor);
        self.gather(node, own, (class.as_deref(), parent.depth), &mut inside);
        if inside.joints.len() > 1 || inside.joints.len() != joints.len() {
            self.foreign(node, "a body with several joints, or with one in a frame");
        }
        if let Some(free) = inside.free.first() {
            self.foreign(*free, "a body that floats beside others");
        }
        let frame = placed * DPose3::from_translation(anchor);
        let drafted = match joint {
            Some(joint) => self.moving(&joint, &name, frame),
            None => fixed(&name, frame, self.reader.line(node)),
        };
        let (parent_name, child) = (parent.name.to_owned(), name.clone());
        self.draft.joints.push(JointDraft {
            joint: drafted,
            parent: parent_name,
            child,
            mimic: None,
        });
        let bodies = std::mem::take(&mut inside.bodies);
        self.link(node, &name, own, inside);
        self.hang(bodies, &name, DPose3::identity(), parent.depth + 1);
    }

    fn link(&mut self, node: Node, name: &str, own: DPose3, inside: Inside) {
        let line = self.reader.line(node);
        let mut shapes = Shapes::default();
        for (geom, at) in &inside.geoms {
            self.geom(geom, *at, &mut shapes);
        }
        let weights = std::mem::take(&mut shapes.weights);
        let inertial = self.inertial(inside.inertial.as_ref(), own, &weights, line);
        let (visuals, collisions) = shapes.split();
        self.draft.links.push(Link { name: name.to_owned(), inertial, visuals, collisions, line });
    }

    /// What stands in a body or a frame whose own frame is at `at`.
    fn gather<'d>(
        &mut self,
        node: Node<'d, 'd>,
        at: DPose3,
        (class, depth): (Option<&str>, usize),
        inside: &mut Inside<'d>,
    ) {
        if depth > DEEPEST {
            return self.reader.fault(node, format!("frames nest at most {DEEPEST} deep"));
        }
        for child in node.children().filter(Node::is_element) {
            let element = self.defaults.element(child, class);
            match child.tag_name().name() {
                "geom" => inside.geoms.push((element, at)),
                "joint" => inside.joints.push(element),
                "freejoint" => inside.free.push(child),
                "inertial" => inside.inertial = Some(element),
                "body" => inside.bodies.push((child, at, class.map(str::to_owned))),
                "frame" => {
                    let class = child.attribute("childclass").or(class);
                    let there = at * self.place(&element);
                    self.gather(child, there, (class, depth + 1), inside);
                }
                _ => {}
            }
        }
    }

    fn moving(&mut self, element: &Element, link: &str, frame: DPose3) -> Joint {
        let line = self.reader.line(element.node);
        let limits = self.range(element);
        let kind = match (element.get("type").unwrap_or("hinge"), limits) {
            ("hinge", Some(_)) => Motion::Revolute,
            ("hinge", None) => Motion::Continuous,
            ("slide", _) => Motion::Prismatic,
            (other, _) => {
                self.foreign(element.node, &format!("a joint of type `{other}`"));
                Motion::Floating
            }
        };
        let axis = self.vector(element, "axis").unwrap_or(DVec3::Z).normalize_or_zero();
        let effort = self.numbers(element, "actuatorfrcrange", 2);
        let effort = effort.map(|r| r[0].abs().max(r[1].abs()));
        let mut limit =
            limits.map_or(Limit::NONE, |[lower, upper]| Limit { lower, upper, ..Limit::NONE });
        limit.effort = effort;
        let has_limit = limits.is_some() || kind != Motion::Prismatic;
        let given = |n: Option<f64>| Some(n.unwrap_or(0.0));
        let damping = given(self.number(element, "damping"));
        let friction = given(self.number(element, "frictionloss"));
        Joint {
            name: element.get("name").map_or_else(|| format!("{link}_joint"), str::to_owned),
            kind,
            axis,
            axis_as_written: axis,
            limit: has_limit.then_some(limit),
            dynamics: Some(Dynamics { damping, friction }),
            ..fixed(link, frame, line)
        }
    }

    /// Lower and upper end from rest, radians or metres; `None` without limits.
    fn range(&mut self, element: &Element) -> Option<[f64; 2]> {
        let limited = match element.get("limited") {
            Some("true") => true,
            Some("false") => false,
            _ => self.compiler.autolimits && element.get("range").is_some(),
        };
        let turns = element.get("type").is_none_or(|t| t == "hinge");
        let unit = if turns { self.compiler.angle } else { 1.0 };
        let rest = self.number(element, "ref").unwrap_or(0.0);
        let range = self.numbers(element, "range", 2).filter(|_| limited)?;
        Some([range[0], range[1]].map(|end| (end - rest) * unit))
    }
}

/// A joint that does not move, between links yet to be looked up.
fn fixed(link: &str, origin: DPose3, line: u32) -> Joint {
    Joint {
        name: format!("{link}_fixed"),
        kind: Motion::Fixed,
        parent: usize::MAX,
        child: usize::MAX,
        origin,
        axis: DVec3::X,
        axis_as_written: DVec3::X,
        limit: None,
        dynamics: None,
        mimic: None,
        line,
    }
}
