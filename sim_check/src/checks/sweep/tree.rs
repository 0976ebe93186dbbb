//! All pieces in boxes within boxes, at rest: most pairs of pieces never come near each other, and
//! whole branches of a robot are passed over at once.
//!
//! The tree only leaves out pairs that cannot matter; what it lets through is measured as if there
//! were no tree.

use glamx::{DPose3, DVec3};
use object::mesh::Bounds;

use super::bodies::{Piece, Rest};
use crate::robot::Robot;

/// Pieces in the order of the links, depth first, halved again and again.
#[derive(Clone, Debug)]
pub struct PieceTree {
    /// The root last.
    nodes: Vec<Node>,
    /// Largest coordinate of any piece at rest, metres.
    far: f64,
}

/// Neighbours in the tree of links.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Box of all pieces, root frame.
    pub bounds: Bounds,
    /// A cube about the middle that holds the boxes of all pieces however they are turned together.
    pub cube: Cube,
    /// Smallest number of a link in it (see [`Robot::span`]), and the end of its numbers.
    links: [usize; 2],
    inside: Inside,
}

/// Middle and half side of a cube, metres.
#[derive(Clone, Copy, Debug)]
pub struct Cube {
    /// Its middle, root frame.
    pub centre: DVec3,
    /// Half its side.
    pub half: f64,
}

#[derive(Clone, Copy, Debug)]
enum Inside {
    Piece(usize),
    Nodes([usize; 2]),
}

impl Cube {
    /// The same cube after a motion, still along the axes: see [`Node::cube`].
    pub fn moved(&self, motion: &DPose3) -> Bounds {
        Self { centre: motion.transform_point(self.centre), half: self.half }.bounds()
    }

    /// The cube as a box.
    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.centre, max: self.centre }.grown(self.half)
    }
}

impl Node {
    /// Whether some of it hangs below a joint, given the span of the joint's child (see
    /// `Robot::span`).
    pub fn touches(&self, [first, end]: [usize; 2]) -> bool {
        self.links[0] < end && self.links[1] > first
    }

    /// Whether all of it does.
    pub fn is_within(&self, [first, end]: [usize; 2]) -> bool {
        self.links[0] >= first && self.links[1] <= end
    }
}

impl PieceTree {
    pub(super) fn new(robot: &Robot, pieces: &[Piece], rest: &Rest) -> Self {
        let number = |&p: &usize| (robot.span(pieces[p].link)[0], p);
        let mut order: Vec<usize> = (0..pieces.len()).collect();
        order.sort_by_key(number);
        let leaf = |&p: &usize| {
            let (centre, half) = pieces[p].hull.ball_at(&rest.poses[p]);
            let first = robot.span(pieces[p].link)[0];
            let cube = Cube { centre, half };
            let (bounds, links) = (rest.boxes[p], [first, first + 1]);
            Node { bounds, cube, links, inside: Inside::Piece(p) }
        };
        let mut tree = Self { nodes: order.iter().map(leaf).collect(), far: 0.0 };
        let corners = rest.boxes.iter().flat_map(|b| [b.min, b.max]);
        tree.far = corners.map(|c| c.abs().max_element()).fold(0.0, f64::max);
        let mut layer: Vec<usize> = (0..order.len()).collect();
        while layer.len() > 1 {
            let mut above = Vec::with_capacity(layer.len().div_ceil(2));
            for pair in layer.chunks(2) {
                match *pair {
                    [a, b] => {
                        tree.nodes.push(joined(&tree.nodes, [a, b]));
                        above.push(tree.nodes.len() - 1);
                    }
                    ref one => above.extend(one),
                }
            }
            layer = above;
        }
        tree
    }

    /// What rounding may make of a place in a scene of this diagonal and of another point, metres: far less than
    /// anything that is looked for, far more than doubles lose.
    pub fn slack(&self, diagonal: f64, other: DVec3) -> f64 {
        1e-6 * diagonal + 1e-9 * self.far.max(other.abs().max_element())
    }

    /// Pairs of pieces, the first of one group and the second of another, that may matter: `group`
    /// says whether any of a node is in either, `look` whether anything of the second may matter to
    /// anything of the first. `None` once that was asked more than `most` times.
    pub fn pairs(
        &self,
        group: impl Fn(&Node) -> [bool; 2],
        mut look: impl FnMut(&Node, &Node) -> bool,
        most: usize,
    ) -> Option<Vec<[usize; 2]>> {
        let (mut found, mut asked) = (Vec::new(), 0);
        let root = self.nodes.len().checked_sub(1);
        let mut open: Vec<[usize; 2]> = root.map(|r| [r, r]).into_iter().collect();
        while let Some([a, b]) = open.pop() {
            let [first, second] = [&self.nodes[a], &self.nodes[b]];
            if !(group(first)[0] && group(second)[1]) {
                continue;
            }
            asked += 1;
            if asked > most {
                return None;
            }
            if !look(first, second) {
                continue;
            }
            match (first.inside, second.inside) {
                (Inside::Piece(p), Inside::Piece(q)) => found.push([p, q]),
                (Inside::Nodes(below), Inside::Nodes(_)) if first.cube.half >= second.cube.half => {
                    open.extend(below.map(|n| [n, b]));
                }
                (_, Inside::Nodes(below)) => open.extend(below.map(|n| [a, n])),
                (Inside::Nodes(below), Inside::Piece(_)) => open.extend(below.map(|n| [n, b])),
            }
        }
        found.sort_unstable();
        Some(found)
    }
}

/// Two nodes as one.
fn joined(nodes: &[Node], pair: [usize; 2]) -> Node {
    let [a, b] = pair.map(|n| &nodes[n]);
    let bounds = Bounds::of([a.bounds.min, a.bounds.max, b.bounds.min, b.bounds.max]);
    let centre = bounds.centre();
    let half = [a, b].map(|n| n.cube.centre.distance(centre) + n.cube.half);
    let cube = Cube { centre, half: half[0].max(half[1]) };
    let links = [a.links[0].min(b.links[0]), a.links[1].max(b.links[1])];
    Node { bounds, cube, links, inside: Inside::Nodes(pair) }
}
