//! Triangles sorted into boxes within boxes.

use glamx::DVec3;
use object::Mesh;
use object::mesh::Bounds;

use super::triangle::{Triangle, nearer_to_point};

/// Most triangles of a box that is not divided further.
const LEAF: usize = 4;

/// A surface made ready for questions of distance, in its own frame, metres.
#[derive(Clone, Debug)]
pub struct BoxTree {
    pub(super) triangles: Vec<Triangle>,
    /// Which of the triangles it was made of each is.
    origins: Vec<u32>,
    pub(super) nodes: Vec<Node>,
}

/// A box around some triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) centre: DVec3,
    pub(super) half: DVec3,
    first: u32,
    last: u32,
    /// The second of the two boxes within; the first one follows this box. 0 for none.
    second: u32,
}

impl Node {
    /// Its triangles.
    pub(super) fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..self.last as usize
    }

    /// The two boxes within, if it is divided; `index` is its own.
    pub(super) fn children(&self, index: usize) -> Option<[usize; 2]> {
        (self.second > 0).then_some([index + 1, self.second as usize])
    }

    fn distance_squared(&self, p: DVec3) -> f64 {
        ((p - self.centre).abs() - self.half).max(DVec3::ZERO).length_squared()
    }
}

impl BoxTree {
    /// Sorts the faces of a mesh; the same mesh gives the same tree.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        Self::new((0..mesh.faces().len()).map(|f| mesh.corners(f)).collect())
    }

    /// Sorts triangles; the same triangles give the same tree.
    pub fn new(triangles: Vec<Triangle>) -> Self {
        let middle = |(i, t): (usize, &Triangle)| (t[0] + t[1] + t[2], i as u32);
        let mut order: Vec<(DVec3, u32)> = triangles.iter().enumerate().map(middle).collect();
        let mut nodes = Vec::with_capacity(order.len());
        if !order.is_empty() {
            build(&mut nodes, &triangles, &mut order, 0);
        }
        let origins: Vec<u32> = order.into_iter().map(|(_, i)| i).collect();
        let triangles = origins.iter().map(|&i| triangles[i as usize]).collect();
        Self { triangles, origins, nodes }
    }

    /// Which of the triangles it was made of each of its triangles is.
    pub(super) fn origins(&self) -> &[u32] {
        &self.origins
    }

    /// Its triangles, those of a box side by side.
    pub(crate) fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The triangles of a box; box 0 has all of them.
    pub(crate) fn range(&self, index: usize) -> Option<std::ops::Range<usize>> {
        self.nodes.get(index).map(Node::range)
    }

    /// The two boxes within a box, if it is divided.
    pub(crate) fn children(&self, index: usize) -> Option<[usize; 2]> {
        self.nodes.get(index)?.children(index)
    }

    /// Whether it has no triangles.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Distance of a point to the surface, or `at_most` where that is less, metres; `at_most` for
    /// a surface without triangles.
    pub fn distance(&self, p: DVec3, at_most: f64) -> f64 {
        self.distance_beyond(p, 0.0, at_most)
    }

    /// The same where that is more than `enough`; where it is not, any figure up to that.
    pub fn distance_beyond(&self, p: DVec3, enough: f64, at_most: f64) -> f64 {
        let mut look = Look { p, enough: enough * enough, least: at_most * at_most };
        if let Some(root) = self.nodes.first() {
            self.look(0, root.distance_squared(p), &mut look);
        }
        look.least.sqrt()
    }

    fn look(&self, index: usize, apart: f64, look: &mut Look) {
        if apart >= look.least || look.least <= look.enough {
            return;
        }
        let node = &self.nodes[index];
        let Some(children) = node.children(index) else {
            for triangle in &self.triangles[node.range()] {
                look.least = nearer_to_point(triangle, look.p, look.least).unwrap_or(look.least);
            }
            return;
        };
        let mut within = children.map(|c| (c, self.nodes[c].distance_squared(look.p)));
        if within[1].1 < within[0].1 {
            within.swap(0, 1);
        }
        within.into_iter().for_each(|(child, apart)| self.look(child, apart, look));
    }
}

/// A search for the triangle nearest to a point.
struct Look {
    p: DVec3,
    /// Squared distance that need not be bettered.
    enough: f64,
    /// Least squared distance so far.
    least: f64,
}

/// Adds the box of some triangles, and of its halves along the longest side of their centres; the
/// first of them stands at `first` in the end.
fn build(nodes: &mut Vec<Node>, all: &[Triangle], order: &mut [(DVec3, u32)], first: usize) {
    let index = nodes.len();
    let (start, last) = (first as u32, (first + order.len()) as u32);
    let (centre, half) = (DVec3::ZERO, DVec3::ZERO);
    nodes.push(Node { centre, half, first: start, last, second: 0 });
    if order.len() <= LEAF {
        let corners = order.iter().flat_map(|&(_, i)| all[i as usize]);
        return enclose(&mut nodes[index], &Bounds::of(corners));
    }
    let axis = Bounds::of(order.iter().map(|o| o.0)).size().max_position();
    let middle = order.len() / 2;
    let by_centre =
        |a: &(DVec3, u32), b: &(DVec3, u32)| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1));
    order.select_nth_unstable_by(middle, by_centre);
    let (low, high) = order.split_at_mut(middle);
    build(nodes, all, low, first);
    let second = nodes.len();
    build(nodes, all, high, first + middle);
    nodes[index].second = second as u32;
    let ends = [index + 1, second]
        .map(|c| [nodes[c].centre - nodes[c].half, nodes[c].centre + nodes[c].half]);
    enclose(&mut nodes[index], &Bounds::of(ends.into_iter().flatten()));
}

/// Rounding may not let a corner stick out: the box is a trifle larger than what it holds.
fn enclose(node: &mut Node, bounds: &Bounds) {
    node.centre = bounds.centre();
    node.half = (bounds.size() / 2.0) * (1.0 + 1e-12) + node.centre.abs() * 1e-15;
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::geometry::near::triangle::to_point;

    fn soup(count: usize) -> Vec<Triangle> {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(3);
        let mut number =
            |size: f64| DVec3::from_array([(); 3].map(|_| rng.random_range(-size..size)));
        (0..count)
            .map(|_| {
                let at = number(1.0);
                [at, at + number(0.1), at + number(0.1)]
            })
            .collect()
    }

    #[test]
    fn the_tree_finds_what_looking_at_every_triangle_finds() {
        let triangles = soup(213);
        let tree = BoxTree::new(triangles.clone());
        for probe in soup(101) {
            let p = probe[0] * 1.5;
            let each =
                triangles.iter().map(|t| to_point(t, p).sqrt()).fold(f64::INFINITY, f64::min);
            assert_eq!(tree.distance(p, f64::INFINITY), each);
            assert_eq!(tree.distance(p, each / 2.0), each / 2.0, "no more than asked for");
            assert_eq!(tree.distance_beyond(p, each * 0.9, f64::INFINITY), each);
            let near = tree.distance_beyond(p, each * 1.5, f64::INFINITY);
            assert!((each..=each * 1.5).contains(&near), "{near} for {each}");
        }
    }

    #[test]
    fn without_triangles_everything_is_as_far_as_asked() {
        assert_eq!(BoxTree::new(vec![]).distance(DVec3::ONE, 7.0), 7.0);
        assert_eq!(BoxTree::new(soup(1)).distance(soup(1)[0][0], 7.0), 0.0);
    }
}
