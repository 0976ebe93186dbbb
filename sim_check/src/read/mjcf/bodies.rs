//! Bodies of an MJCF model → links, and their joints.

use glamx::{DPose3, DVec3};
use roxmltree::Node;

use super::attributes::DEEPEST;
use super::geoms::Shapes;
use super::inside::{Below, Inside, is_free};
use super::model::Model;
use crate::read::depends::WEIGHED;
use crate::read::draft::{JointDraft, MAX_LINKS};
use crate::robot::{Joint, Link, Motion};

/// Name of the link that stands for the world.
pub(super) const WORLD: &str = "world";

/// The link a body hangs on.
struct Parent<'p> {
    name: &'p str,
    /// The parent body's frame in its link's frame, and those of frames in between.
    frame: DPose3,
    class: Option<&'p str>,
    depth: usize,
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
        self.note_masks(0, &shapes);
        let is_bare = shapes.seen.is_empty() && shapes.touched.is_empty();
        self.draft.beside.floats = Some(world.bodies.iter().any(|(node, ..)| floats(*node)));
        if let [(node, at, class)] = &world.bodies[..]
            && is_bare
            && floats(*node)
        {
            return self.free_root(*node, *at, class.as_deref());
        }
        let (visuals, collisions) = shapes.split();
        let line = self.reader.line(root);
        let name = WORLD.into();
        self.draft.links.push(Link {
            name,
            inertial: None,
            visuals,
            collisions,
            between: false,
            line,
        });
        self.hang(world.bodies, WORLD, DPose3::identity(), 0);
    }

    /// The root link is the body itself, in the frame of the world.
    fn free_root(&mut self, node: Node, at: DPose3, class: Option<&str>) {
        let class = node.attribute("childclass").or(class);
        let element = self.defaults.element(node, class);
        let own = at * self.place(&element);
        let mut inside = Inside::default();
        self.gather(node, DPose3::identity(), (class, 0), &mut inside);
        let name = self.body_name(node);
        let free = std::mem::take(&mut inside.free);
        self.coordinates.extend(free.iter().map(|_| (None, 7, 0.0)));
        for (joint, _) in std::mem::take(&mut inside.joints) {
            self.foreign(joint.node, "a joint of a body that floats");
        }
        let bodies = std::mem::take(&mut inside.bodies);
        self.link(node, &name, own, inside);
        self.hang(bodies, &name, own, 0);
    }

    /// The bodies below a link, told in its body's frame.
    fn hang(&mut self, bodies: Vec<Below>, name: &str, frame: DPose3, depth: usize) {
        for (node, at, class) in bodies {
            let class = class.as_deref();
            self.body(node, &Parent { name, frame: frame * at, class, depth });
        }
    }

    fn body_name(&mut self, node: Node) -> String {
        let unnamed = || format!("body_{}", self.draft.links.len());
        let name = node.attribute("name").map_or_else(unnamed, str::to_owned);
        self.unique(name)
    }

    fn body(&mut self, node: Node, parent: &Parent) {
        if parent.depth > DEEPEST {
            return self.reader.fault(node, format!("bodies nest at most {DEEPEST} deep"));
        }
        if self.draft.links.len() >= MAX_LINKS {
            return self.reader.fault(node, format!("at most {MAX_LINKS} links"));
        }
        let class = node.attribute("childclass").or(parent.class).map(str::to_owned);
        let element = self.defaults.element(node, class.as_deref());
        let placed = parent.frame * self.place(&element);
        let name = self.body_name(node);
        let mut inside = Inside::default();
        self.gather(node, DPose3::identity(), (class.as_deref(), parent.depth), &mut inside);
        if element.get("mocap") == Some("true") {
            self.mocaps.push(name.clone());
        }
        let own = self.joints(node, &name, (parent.name, placed), &mut inside);
        let bodies = std::mem::take(&mut inside.bodies);
        self.link(node, &name, own, inside);
        self.hang(bodies, &name, own, parent.depth + 1);
    }

    /// The joints of a body, each of several on a link of its own; the body's frame in its link's.
    fn joints(
        &mut self,
        node: Node,
        name: &str,
        (parent, placed): (&str, DPose3),
        inside: &mut Inside,
    ) -> DPose3 {
        let line = self.reader.line(node);
        let joints = std::mem::take(&mut inside.joints);
        if let Some(free) = inside.free.first() {
            let named = free.attribute("name").map(str::to_owned);
            let drafted = Joint {
                name: named.unwrap_or_else(|| format!("{name}_free")),
                kind: Motion::Floating,
                ..fixed(name, placed, line)
            };
            self.coordinates.push((None, 7, 0.0));
            self.draft_joint(drafted, parent, name);
            return DPose3::identity();
        }
        if joints.is_empty() {
            self.draft_joint(fixed(name, placed, line), parent, name);
            return DPose3::identity();
        }
        let (mut above, mut frame, count) = (parent.to_owned(), placed, joints.len());
        for (k, (element, at)) in joints.into_iter().enumerate() {
            let is_last = k + 1 == count;
            let link = if is_last { name.to_owned() } else { self.unique(format!("{name}__{k}")) };
            let told = self.vector(&element, "pos").unwrap_or(DVec3::ZERO);
            let anchor = at.transform_point(told);
            let stands = frame * DPose3::from_translation(anchor);
            let mut joint = self.moving(&element, &link, stands);
            joint.axis = at.rotation * joint.axis;
            joint.axis_as_written = at.rotation * joint.axis_as_written;
            self.draft_joint(joint, &above, &link);
            if !is_last {
                let (visuals, collisions) = (vec![], vec![]);
                let name = link.clone();
                let between =
                    Link { name, inertial: None, visuals, collisions, between: true, line };
                self.draft.links.push(between);
            }
            (above, frame) = (link, DPose3::from_translation(-anchor));
        }
        frame
    }

    fn draft_joint(&mut self, joint: Joint, parent: &str, child: &str) {
        let (parent, child) = (parent.to_owned(), child.to_owned());
        self.draft.joints.push(JointDraft { joint, parent, child, mimic: None });
    }

    fn link(&mut self, node: Node, name: &str, own: DPose3, inside: Inside) {
        let line = self.reader.line(node);
        let mut shapes = Shapes::default();
        for (geom, at) in &inside.geoms {
            self.geom(geom, own * *at, &mut shapes);
        }
        self.note_masks(self.draft.links.len(), &shapes);
        self.note_looks(name, &shapes);
        if shapes.lacks && inside.inertial.is_none() {
            self.unread(node, &format!("what all of `{name}` weighs"), WEIGHED);
        }
        let weights = std::mem::take(&mut shapes.weights);
        let inertial = self.inertial(inside.inertial.as_ref(), own, &weights, line);
        let (visuals, collisions) = shapes.split();
        let name = name.to_owned();
        self.draft.links.push(Link { name, inertial, visuals, collisions, between: false, line });
    }
}

/// Whether a body floats freely.
fn floats(node: Node) -> bool {
    node.children().any(|n| is_free(&n))
}

/// A joint that does not move, between links yet to be looked up.
pub(super) fn fixed(link: &str, origin: DPose3, line: u32) -> Joint {
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
        rest: 0.0,
        spring: None,
        held: None,
        line,
    }
}
