//! What stands in an MJCF body, elements of frames and of replicas in it included.

use glamx::{DPose3, DQuat, DVec3};
use roxmltree::Node;

use super::attributes::{DEEPEST, Element};
use super::model::Model;
use crate::read::draft::MAX_SHAPES;

/// A body yet to be read: its element, the frame it is told in, and its class.
pub(super) type Below<'d> = (Node<'d, 'd>, DPose3, Option<String>);

/// What a body holds, each with the frame it is told in, in the body's.
#[derive(Default)]
pub(super) struct Inside<'d> {
    pub geoms: Vec<(Element<'d>, DPose3)>,
    pub bodies: Vec<Below<'d>>,
    pub joints: Vec<(Element<'d>, DPose3)>,
    pub free: Vec<Node<'d, 'd>>,
    pub inertial: Option<Element<'d>>,
}

impl Model<'_, '_> {
    /// What stands in a body or a frame whose own frame is at `at`.
    pub(super) fn gather<'d>(
        &mut self,
        node: Node<'d, 'd>,
        at: DPose3,
        (class, depth): (Option<&str>, usize),
        inside: &mut Inside<'d>,
    ) {
        if depth > DEEPEST || inside.geoms.len() + inside.bodies.len() > MAX_SHAPES {
            let rule = format!("frames nest at most {DEEPEST} deep and hold {MAX_SHAPES} elements");
            return self.reader.fault(node, rule);
        }
        for child in node.children().filter(Node::is_element) {
            let element = self.defaults.element(child, class);
            match child.tag_name().name() {
                "geom" => inside.geoms.push((element, at)),
                "joint" | "freejoint" if is_free(&child) => inside.free.push(child),
                "joint" => inside.joints.push((element, at)),
                "inertial" => inside.inertial = Some(element),
                "body" => inside.bodies.push((child, at, class.map(str::to_owned))),
                "frame" => {
                    let class = child.attribute("childclass").or(class);
                    let there = at * self.place(&element);
                    self.gather(child, there, (class, depth + 1), inside);
                }
                "replicate" => self.replicate(&element, at, (class, depth + 1), inside),
                _ => {}
            }
        }
    }

    /// The same elements several times over: each copy is turned and moved from the one before.
    fn replicate<'d>(
        &mut self,
        element: &Element<'d>,
        at: DPose3,
        place: (Option<&str>, usize),
        inside: &mut Inside<'d>,
    ) {
        let count = self.number(element, "count").unwrap_or(0.0).clamp(0.0, MAX_SHAPES as f64);
        let offset = self.vector(element, "offset").unwrap_or(DVec3::ZERO);
        let turn = match element.get("euler") {
            Some(_) => self.turn(element),
            None => DQuat::IDENTITY,
        };
        // As its documents have it: the turn of the k-th copy is that many turns, its place the sum
        // of the offsets, each turned as the copy before it.
        let mut there = DPose3::identity();
        for _ in 0..count as usize {
            self.gather(element.node, at * there, place, inside);
            there = DPose3::from_parts(
                there.translation + there.rotation * offset,
                there.rotation * turn,
            );
        }
    }
}

/// Whether an element is a joint of six degrees of freedom.
pub(super) fn is_free(node: &Node) -> bool {
    node.has_tag_name("freejoint")
        || node.has_tag_name("joint") && node.attribute("type") == Some("free")
}
