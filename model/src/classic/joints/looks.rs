//! A surface in a hierarchy of boxes: what a look along a line meets first, which point is nearest.
//!
//! The answers are those of the library that builds the hierarchy, to the last bit. Where several faces
//! are as near, the same one is told: boxes are visited in the same order and asked the same questions.
//! Both boxes of a pair are asked at once, which costs about half as much.

use object::DVec3;
use parry3d_f64::partitioning::{BvhNode, TraversalAction};
use parry3d_f64::query::{PointQueryWithLocation, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, Triangle, TrianglePointLocation};

/// How many pairs of boxes may wait without memory being asked for: a balanced hierarchy of four thousand
/// million faces needs no more than half of them.
const FEW: usize = 64;

/// A surface that looks meet.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The halves of the whole first.
    pairs: Vec<Pair>,
    /// By their place in the mesh.
    faces: Vec<Triangle>,
}

/// The two halves of a box.
#[derive(Clone, Copy, Debug)]
struct Pair {
    /// Their least coordinates, those of both halves side by side.
    low: [[f64; 2]; 3],
    /// Their greatest coordinates.
    high: [[f64; 2]; 3],
    /// What is in each.
    within: [Within; 2],
}

/// What is in a box.
#[derive(Clone, Copy, Debug)]
enum Within {
    /// A face.
    Face(u32),
    /// Two smaller boxes.
    Pair(u32),
}

/// A look from a point along a line.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    ray: Ray,
    /// Of each coordinate, how much farther one has to look to get on by 1; nothing where one never does.
    per_unit: [Option<f64>; 3],
}

impl Surface {
    /// A mesh's surface; nothing if it has no faces.
    pub fn new(vertices: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Option<Self> {
        let mesh = TriMesh::new(vertices, faces).ok()?;
        let faces = mesh.triangles().collect();
        let (mut pairs, mut half): (Vec<Pair>, Option<Pair>) = (Vec::new(), None);
        // The halves whose own halves are still to come, the next one last: the order of the traversal.
        let mut open: Vec<(usize, usize)> = Vec::new();
        mesh.bvh().traverse(|node: &BvhNode| {
            let Some(first) = half.take() else {
                half = Some(Pair::of(node));
                return TraversalAction::Continue;
            };
            let pair = first.with(node);
            let place = pairs.len();
            if let Some((of, side)) = open.pop() {
                let of: &mut Pair = &mut pairs[of];
                of.within[side] = Within::Pair(place as u32);
            }
            let is_open = |side: &usize| matches!(pair.within[*side], Within::Pair(_));
            open.extend([1, 0].into_iter().filter(is_open).map(|side| (place, side)));
            pairs.push(pair);
            TraversalAction::Continue
        });
        // One face alone is its own other half.
        pairs.extend(half);
        Some(Self { pairs, faces })
    }

    /// What costs least, if less than `most`; `of_boxes` says the least that anything in either half of a
    /// pair may cost, and the largest number where there is nothing; `of_face` what a face costs.
    fn best<T>(
        &self,
        most: f64,
        of_boxes: impl Fn(&Pair, f64) -> [f64; 2],
        of_face: impl Fn(&Triangle, f64) -> Option<(f64, T)>,
    ) -> Option<(u32, f64, T)> {
        let mut best: Option<(u32, f64, T)> = None;
        let mut least = most;
        let mut waiting = Waiting { few: [0; FEW], more: Vec::new(), count: 0 };
        let mut next = Some(0);
        while let Some(pair) = next.take().or_else(|| waiting.pop()) {
            let Some(pair) = self.pairs.get(pair as usize) else { break };
            let costs = of_boxes(pair, least);
            let nearer = usize::from(costs[0] > costs[1]);
            for side in [nearer, 1 - nearer] {
                if !(costs[side] < least && costs[side] != f64::MAX) {
                    continue;
                }
                match pair.within[side] {
                    Within::Pair(within) if next.is_none() => next = Some(within),
                    Within::Pair(within) => waiting.push(within),
                    Within::Face(face) => {
                        let found = self.faces.get(face as usize).and_then(|f| of_face(f, least));
                        if let Some((cost, told)) = found.filter(|(cost, _)| *cost < least) {
                            least = cost;
                            best = Some((face, cost, told));
                        }
                    }
                }
            }
        }
        best
    }

    /// The face whose point is nearest to another, if within `reach`; that point, and where on the face it
    /// is.
    pub fn nearest(&self, x: DVec3, reach: f64) -> Option<(u32, DVec3, TrianglePointLocation)> {
        let of_face = |face: &Triangle, _: f64| {
            let (found, place) = face.project_local_point_and_get_location(x, false);
            Some(((found.point - x).length(), (found.point, place)))
        };
        let found = self.best(reach, |pair, _| pair.far_from(x.to_array()), of_face);
        found.map(|(face, _, (point, place))| (face, point, place))
    }
}

impl Pair {
    /// A box as both halves.
    fn of(node: &BvhNode) -> Self {
        let (low, high) = (node.mins().to_array(), node.maxs().to_array());
        let within = node.leaf_data().map_or(Within::Pair(0), Within::Face);
        Self { low: low.map(|x| [x; 2]), high: high.map(|x| [x; 2]), within: [within; 2] }
    }

    /// The same with another box as its second half.
    fn with(mut self, node: &BvhNode) -> Self {
        let other = Self::of(node);
        self.within[1] = other.within[1];
        for axis in 0..3 {
            self.low[axis][1] = other.low[axis][1];
            self.high[axis][1] = other.high[axis][1];
        }
        self
    }

    /// How far each half is from a point, 0 from within.
    #[inline]
    fn far_from(&self, x: [f64; 3]) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (axis, &x) in x.iter().enumerate() {
            for (side, sum) in sum.iter_mut().enumerate() {
                let (under, over) = (self.low[axis][side] - x, x - self.high[axis][side]);
                let outside = if under > over { under } else { over };
                let outside = if outside > 0.0 { outside } else { 0.0 };
                *sum += outside * outside;
            }
        }
        sum.map(f64::sqrt)
    }
}

impl Look {
    /// From a point along `d`.
    pub fn new(from: DVec3, d: DVec3) -> Self {
        let per_unit = d.to_array().map(|way| (way != 0.0).then(|| 1.0 / way));
        Self { ray: Ray::new(from, d), per_unit }
    }

    /// The first face that is met within `reach`, how far it is and its unit normal, either way round.
    pub fn first(&self, surface: &Surface, reach: f64) -> Option<(u32, f64, DVec3)> {
        let of_face = |face: &Triangle, least: f64| {
            let hit = face.cast_local_ray_and_get_normal(&self.ray, least, false)?;
            Some((hit.time_of_impact, hit.normal))
        };
        surface.best(reach, |pair, least| self.until(pair, least), of_face)
    }

    /// Whether any face is met before `reach`: the search is over with the first that is found.
    pub fn meets(&self, surface: &Surface, reach: f64) -> bool {
        // A face that is met costs less than any box, so that no other is looked into.
        let of_boxes = |pair: &Pair, least: f64| {
            if least < 0.0 { [f64::MAX; 2] } else { self.until(pair, least) }
        };
        let of_face = |face: &Triangle, least: f64| {
            let far = face.cast_local_ray(&self.ray, least, false)?;
            (far < reach).then_some((-1.0, ()))
        };
        surface.best(reach, of_boxes, of_face).is_some()
    }

    /// How far each half is, 0 from within; the largest number if it is not met within `reach`.
    #[inline]
    fn until(&self, pair: &Pair, reach: f64) -> [f64; 2] {
        let (mut first, mut last) = ([0.0; 2], [reach; 2]);
        let from = self.ray.origin.to_array();
        for (axis, &from) in from.iter().enumerate() {
            let (low, high) = (pair.low[axis], pair.high[axis]);
            let Some(per_unit) = self.per_unit[axis] else {
                for side in 0..2 {
                    let is_beside = from < low[side] || from > high[side];
                    last[side] = if is_beside { -1.0 } else { last[side] };
                }
                continue;
            };
            for side in 0..2 {
                let one = (low[side] - from) * per_unit;
                let other = (high[side] - from) * per_unit;
                let (near, far) = if one > other { (other, one) } else { (one, other) };
                first[side] = if near > first[side] { near } else { first[side] };
                last[side] = if far < last[side] { far } else { last[side] };
            }
        }
        std::array::from_fn(|side| if first[side] > last[side] { f64::MAX } else { first[side] })
    }
}

/// Pairs that are looked into later, the next one last.
struct Waiting {
    few: [u32; FEW],
    more: Vec<u32>,
    count: usize,
}

impl Waiting {
    fn push(&mut self, pair: u32) {
        match self.few.get_mut(self.count) {
            Some(place) => *place = pair,
            None => self.more.push(pair),
        }
        self.count += 1;
    }

    fn pop(&mut self) -> Option<u32> {
        self.count = self.count.checked_sub(1)?;
        self.few.get(self.count).copied().or_else(|| self.more.pop())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that look random and are the same on every run, 0 to 1, few of them: many coordinates are
    /// alike, and many faces as near.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 7_u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 28) / 16.0
        }
    }

    fn meshes() -> Vec<(Vec<DVec3>, Vec<[u32; 3]>)> {
        let mut next = numbers();
        let mut mesh = |count: u32| {
            let mut point = || DVec3::new(next(), next(), next());
            let points: Vec<DVec3> = (0..count + 2).map(|_| point()).collect();
            (points, (0..count).map(|i| [i, i + 1, i + 2]).collect())
        };
        [1, 2, 3, 5, 40, 700].map(&mut mesh).into()
    }

    #[test]
    fn the_nearest_point_is_the_librarys_on_the_same_face() {
        let mut next = numbers();
        for (points, faces) in meshes() {
            let library = TriMesh::new(points.clone(), faces.clone()).unwrap();
            let surface = Surface::new(points, faces).unwrap();
            for _ in 0..300 {
                let (x, reach) = (DVec3::new(next(), next(), next()) * 1.5, 0.05 + next());
                let there =
                    library.project_local_point_and_get_location_with_max_dist(x, false, reach);
                let there = there.map(|(found, (face, place))| (face, found.point, place));
                // Places on faces can be written, not compared.
                assert_eq!(format!("{:?}", surface.nearest(x, reach)), format!("{there:?}"));
            }
        }
    }

    #[test]
    fn a_look_meets_what_the_library_says() {
        let mut next = numbers();
        for (points, faces) in meshes() {
            let library = TriMesh::new(points.clone(), faces.clone()).unwrap();
            let surface = Surface::new(points, faces).unwrap();
            for i in 0..300 {
                let way = DVec3::new(next() - 0.5, next() - 0.5, next() - 0.5);
                let way = if i % 3 == 0 { DVec3::AXES[i % 9 / 3] } else { way };
                let Some(way) = way.try_normalize() else { continue };
                let (from, reach) = (DVec3::new(next(), next(), next()) - way * 0.5, 0.3 + next());
                let (look, ray) = (Look::new(from, way), Ray::new(from, way));
                let there = library.cast_local_ray_and_get_normal(&ray, reach, false);
                let there = there.map(|hit| (hit.subshape, hit.time_of_impact, hit.normal));
                assert_eq!(look.first(&surface, reach), there);
                let is_met = library.cast_local_ray(&ray, reach, false).is_some();
                assert_eq!(look.meets(&surface, reach), is_met);
            }
        }
    }

    #[test]
    fn pairs_wait_in_order_however_many() {
        let mut waiting = Waiting { few: [0; FEW], more: Vec::new(), count: 0 };
        (0..100).for_each(|pair| waiting.push(pair));
        let back: Vec<u32> = std::iter::from_fn(|| waiting.pop()).collect();
        assert_eq!(back, (0..100).rev().collect::<Vec<u32>>());
    }
}
