//! Which islands of surfaces come near each other: both trees walked at once, past everything that
//! is one cluster already.

use std::sync::Arc;

use glamx::{DPose3, DVec3};
use object::mesh::Bounds;
use object::weld::DisjointSets;

use super::pair::{Place, nearer};
use super::tree::{BoxTree, Node};

/// A surface whose triangles belong to islands, numbered across all surfaces.
pub(crate) struct Islands {
    tree: Arc<BoxTree>,
    /// The island of each triangle of the tree.
    of_triangle: Vec<u32>,
    /// The island of each box whose triangles are all of one.
    of_box: Vec<Option<u32>>,
}

impl Islands {
    /// A surface and the island of each of its triangles, in the order the tree was made of.
    pub(crate) fn new(tree: Arc<BoxTree>, islands: &[u32]) -> Self {
        let island = |t: &u32| islands.get(*t as usize).copied().unwrap_or_default();
        let of_triangle: Vec<u32> = tree.origins().iter().map(island).collect();
        let of_box = vec![None; tree.nodes.len()];
        let mut made = Self { tree, of_triangle, of_box };
        made.look_at_boxes();
        made
    }

    fn look_at_boxes(&mut self) {
        // Boxes within come after the box they are in.
        for k in (0..self.of_box.len()).rev() {
            self.of_box[k] = self.island_in(k, &self.of_box, |i| i);
        }
    }

    /// The one island that all triangles of a box are of, by the names the islands go by; `of_box`
    /// has it for the boxes within.
    fn island_in(
        &self,
        index: usize,
        of_box: &[Option<u32>],
        mut name: impl FnMut(u32) -> u32,
    ) -> Option<u32> {
        let node = &self.tree.nodes[index];
        match node.children(index) {
            Some([a, b]) => of_box[a].filter(|&i| of_box[b].is_some_and(|j| name(i) == name(j))),
            None => {
                let mine = &self.of_triangle[node.range()];
                let first = mine.first().copied()?;
                mine.iter().all(|&m| m == first || name(m) == name(first)).then_some(first)
            }
        }
    }

    /// A box around it where its frame stands at `pose`; empty without triangles.
    pub(crate) fn bounds(&self, pose: &DPose3) -> Bounds {
        let corner = |node: &Node, i: u32| {
            let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let arm = node.half * DVec3::new(sign(0), sign(1), sign(2));
            pose.transform_point(node.centre + arm)
        };
        let root = self.tree.nodes.first();
        Bounds::of(root.into_iter().flat_map(|root| (0..8).map(move |i| corner(root, i))))
    }

    /// Joins its islands that come within `near` metres of each other, and takes each cluster for
    /// one island from now on.
    pub(crate) fn join_own(&mut self, near: f64, sets: &mut DisjointSets) {
        if self.of_box.first().is_none_or(Option::is_some) {
            return;
        }
        join_near(self, self, &DPose3::identity(), near, sets);
        self.of_triangle.iter_mut().for_each(|i| *i = sets.root(*i));
        self.look_at_boxes();
    }
}

/// Joins the islands of two surfaces (or of one with itself) that come within `near` metres of each
/// other, the second one's frame standing at `pose` in the first one's.
pub(crate) fn join_near(
    one: &Islands,
    two: &Islands,
    pose: &DPose3,
    near: f64,
    sets: &mut DisjointSets,
) {
    let own = if std::ptr::eq(one, two) { one.of_box.clone() } else { vec![] };
    let (place, least) = (Place::new(pose), (near * near).next_up());
    let mut walk = Walk { one, two, place, own, least, sets };
    if !one.of_box.is_empty() && !two.of_box.is_empty() {
        walk.visit([0, 0]);
    }
}

struct Walk<'a> {
    one: &'a Islands,
    two: &'a Islands,
    place: Place,
    /// Where a surface is compared with itself, the cluster each of its boxes is of by now.
    own: Vec<Option<u32>>,
    /// Squared distance of what is no longer near.
    least: f64,
    sets: &'a mut DisjointSets,
}

impl Walk<'_> {
    fn visit(&mut self, [i, j]: [usize; 2]) {
        let same = !self.own.is_empty();
        let [of_mine, of_theirs] =
            if same { [&self.own; 2] } else { [&self.one.of_box, &self.two.of_box] };
        if let (Some(a), Some(b)) = (of_mine[i], of_theirs[j])
            && self.sets.root(a) == self.sets.root(b)
        {
            return;
        }
        let (a, b) = (&self.one.tree.nodes[i], &self.two.tree.nodes[j]);
        if self.place.apart(a, b) >= self.least {
            return;
        }
        match (a.children(i), b.children(j)) {
            (within, _) if same && i == j => {
                match within {
                    Some([low, high]) => {
                        [[low; 2], [high; 2], [low, high]].into_iter().for_each(|p| self.visit(p));
                    }
                    None => self.leaves(a.range(), b.range()),
                }
                let sets = &mut *self.sets;
                self.own[i] = self.one.island_in(i, &self.own, |island| sets.root(island));
            }
            (None, None) => self.leaves(a.range(), b.range()),
            (Some(halves), other)
                if other.is_none() || a.half.length_squared() >= b.half.length_squared() =>
            {
                halves.into_iter().for_each(|c| self.visit([c, j]));
            }
            (_, Some(halves)) => halves.into_iter().for_each(|c| self.visit([i, c])),
            (Some(halves), None) => halves.into_iter().for_each(|c| self.visit([c, j])),
        }
    }

    fn leaves(&mut self, mine: std::ops::Range<usize>, theirs: std::ops::Range<usize>) {
        for t in theirs {
            let other = self.place.of(&self.two.tree.triangles[t]);
            let mut its = self.sets.root(self.two.of_triangle[t]);
            for m in mine.clone() {
                let island = self.one.of_triangle[m];
                if island == its || self.sets.root(island) == its {
                    continue;
                }
                if nearer(&self.one.tree.triangles[m], &other, self.least).is_some() {
                    self.sets.join(island, its);
                    its = self.sets.root(its);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::near::triangle::Triangle;

    fn at(x: f64) -> Triangle {
        [DVec3::ZERO, DVec3::Y, DVec3::Z].map(|p| p + DVec3::X * x)
    }

    fn islands(triangles: &[Triangle], numbers: &[u32]) -> Islands {
        Islands::new(Arc::new(BoxTree::new(triangles.to_vec())), numbers)
    }

    fn roots(mut sets: DisjointSets, count: u32) -> Vec<u32> {
        (0..count).map(|i| sets.root(i)).collect()
    }

    #[test]
    fn islands_of_one_surface_join_through_a_third_between_them() {
        let mut all = islands(&[0.0, 1.8, 0.9, 4.0].map(at), &[0, 1, 2, 3]);
        let mut sets = DisjointSets::new(4);
        all.join_own(1.0, &mut sets);
        assert_eq!(roots(sets, 4), [0, 0, 0, 3]);
    }

    #[test]
    fn islands_of_two_surfaces_join_where_they_stand() {
        let (one, two) = (islands(&[0.0, 3.0].map(at), &[0, 1]), islands(&[at(0.0)], &[2]));
        for (shift, expected) in [(1.0, [0, 1, 0]), (1.5, [0, 1, 2]), (2.5, [0, 1, 1])] {
            let mut sets = DisjointSets::new(3);
            let pose = DPose3::translation(shift, 0.0, 0.0);
            join_near(&one, &two, &pose, 1.0, &mut sets);
            assert_eq!(roots(sets, 3), expected, "{shift}");
        }
    }

    #[test]
    fn many_triangles_of_a_few_islands_join_as_comparing_all_pairs_does() {
        let count = 200u32;
        let triangles: Vec<_> = (0..count)
            .map(|k| {
                let k = f64::from(k);
                at((k * 0.77).sin() * 9.0)
                    .map(|p| p + DVec3::new(0.0, (k * 1.3).cos() * 9.0, k % 7.0))
            })
            .collect();
        for near in [0.05, 0.2, 0.5] {
            let mut all = islands(&triangles, &(0..count).collect::<Vec<_>>());
            let (mut sets, mut expected) = (DisjointSets::new(200), DisjointSets::new(200));
            all.join_own(near, &mut sets);
            for (i, a) in (0u32..).zip(&triangles) {
                for (j, b) in (0u32..).zip(&triangles) {
                    if crate::geometry::near::triangle::to_triangle(a, b) <= near * near {
                        expected.join(i, j);
                    }
                }
            }
            assert_eq!(roots(sets, count), roots(expected, count), "{near}");
        }
    }
}
