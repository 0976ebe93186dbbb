//! The least distance between two surfaces, by walking both trees at once.

use glamx::{DMat3, DPose3, DVec3};

use super::tree::{BoxTree, Node};
use super::triangle::{Triangle, to_triangle};

/// How near two surfaces come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Metres; 0 where they touch or pierce each other, infinite if one has no triangles.
    pub distance: f64,
    /// A triangle of each that is so near, as a start for the next question.
    pub triangles: [u32; 2],
}

/// The nearest triangles of two surfaces, the second one's frame standing at `pose` in the first
/// one's. The search starts from a pair known to be near (any pair will do) and ends at the first
/// pair at most `enough` metres apart.
pub fn nearest(
    one: &BoxTree,
    two: &BoxTree,
    pose: &DPose3,
    start: [u32; 2],
    enough: f64,
) -> Nearest {
    let (place, enough) = (Place::new(pose), enough * enough);
    let mut walk = Walk { one, two, place, enough, least: f64::INFINITY, triangles: start };
    walk.compare([start[0] as usize, start[1] as usize]);
    if let (Some(a), Some(b)) = (one.nodes.first(), two.nodes.first()) {
        walk.visit([0, 0], walk.place.apart(a, b));
    }
    Nearest { distance: walk.least.sqrt(), triangles: walk.triangles }
}

/// Where the second surface's frame stands in the first one's.
pub(super) struct Place {
    turn: DMat3,
    /// The turn with all signs dropped: what becomes of a box's half sides.
    swept: DMat3,
    shift: DVec3,
}

impl Place {
    pub(super) fn new(pose: &DPose3) -> Self {
        let turn = DMat3::from_quat(pose.rotation);
        let swept = DMat3::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs());
        Self { turn, swept, shift: pose.translation }
    }

    /// At most the squared distance of what two boxes hold, the second one's in its own frame.
    pub(super) fn apart(&self, a: &Node, b: &Node) -> f64 {
        let between = self.turn * b.centre + self.shift - a.centre;
        (between.abs() - a.half - self.swept * b.half).max(DVec3::ZERO).length_squared()
    }

    /// A triangle of the second surface in the first one's frame.
    pub(super) fn of(&self, triangle: &Triangle) -> Triangle {
        let place = |p: DVec3| self.turn * p + self.shift;
        [place(triangle[0]), place(triangle[1]), place(triangle[2])]
    }
}

/// Squared distance of two triangles if that is less than `least`.
pub(super) fn nearer(one: &Triangle, two: &Triangle, least: f64) -> Option<f64> {
    let far = boxes_apart(one, two) >= least
        || planes_part(one, two, least)
        || planes_part(two, one, least);
    (!far).then(|| to_triangle(one, two)).filter(|squared| *squared < least)
}

struct Walk<'a> {
    one: &'a BoxTree,
    two: &'a BoxTree,
    place: Place,
    enough: f64,
    least: f64,
    triangles: [u32; 2],
}

impl Walk<'_> {
    fn visit(&mut self, [i, j]: [usize; 2], apart: f64) {
        if apart >= self.least || self.least <= self.enough {
            return;
        }
        let (a, b) = (&self.one.nodes[i], &self.two.nodes[j]);
        let larger = a.half.length_squared() >= b.half.length_squared();
        let mine = a.children(i).filter(|_| larger || b.children(j).is_none());
        let within = match (mine, b.children(j)) {
            (Some(halves), _) => halves.map(|c| [c, j]),
            (None, Some(halves)) => halves.map(|c| [i, c]),
            (None, None) => return self.leaves(i, j),
        };
        let look =
            |p: [usize; 2]| (p, self.place.apart(&self.one.nodes[p[0]], &self.two.nodes[p[1]]));
        let mut within = within.map(look);
        if within[1].1 < within[0].1 {
            within.swap(0, 1);
        }
        within.into_iter().for_each(|(pair, apart)| self.visit(pair, apart));
    }

    fn leaves(&mut self, i: usize, j: usize) {
        let (mine, theirs) = (self.one.nodes[i].range(), self.two.nodes[j].range());
        for b in theirs {
            mine.clone().for_each(|a| self.compare([a, b]));
        }
    }

    fn compare(&mut self, [a, b]: [usize; 2]) {
        let (Some(mine), Some(other)) = (self.one.triangles.get(a), self.two.triangles.get(b))
        else {
            return;
        };
        if let Some(squared) = nearer(mine, &self.place.of(other), self.least) {
            self.least = squared;
            self.triangles = [a as u32, b as u32];
        }
    }
}

/// Whether a triangle lies on one side of another's plane, at least that squared distance away.
fn planes_part([a, b, c]: &Triangle, other: &Triangle, squared: f64) -> bool {
    let normal = (*b - *a).cross(*c - *a);
    let [p, q, r] = other.map(|corner| normal.dot(corner - *a));
    let (low, high) = (p.min(q).min(r), p.max(q).max(r));
    let height = low.max(-high);
    height > 0.0 && height * height >= squared * normal.length_squared()
}

/// Squared distance of the boxes around two triangles.
fn boxes_apart(a: &Triangle, b: &Triangle) -> f64 {
    let low = |t: &Triangle| t[0].min(t[1]).min(t[2]);
    let high = |t: &Triangle| t[0].max(t[1]).max(t[2]);
    (low(b) - high(a)).max(low(a) - high(b)).max(DVec3::ZERO).length_squared()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    fn soup(seed: u64, count: usize) -> Vec<Triangle> {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
        let mut number =
            |size: f64| DVec3::from_array([(); 3].map(|_| rng.random_range(-size..size)));
        let triangle = |_| {
            let at = number(1.0);
            [at, at + number(0.1), at + number(0.1)]
        };
        (0..count).map(triangle).collect()
    }

    #[test]
    fn both_trees_find_what_comparing_all_pairs_finds_wherever_they_start() {
        let (one, two) = (soup(1, 101), soup(2, 67));
        let trees = [&one, &two].map(|t| BoxTree::new(t.clone()));
        for k in 0..7 {
            let away = DVec3::new(0.4, -0.2, 0.1) * f64::from(k);
            let pose = DPose3::new(away, DVec3::new(0.3, -0.9, 0.2) * f64::from(k));
            let turned: Vec<Triangle> =
                two.iter().map(|t| t.map(|p| pose.transform_point(p))).collect();
            let each = one.iter().flat_map(|a| turned.iter().map(|b| to_triangle(a, b)));
            let expected = each.fold(f64::INFINITY, f64::min).sqrt();
            for start in [[0, 0], [100, 66], [7, 500]] {
                let found = nearest(&trees[0], &trees[1], &pose, start, 0.0);
                assert!((found.distance - expected).abs() < 1e-12, "{found:?} {expected}");
                let again = nearest(&trees[0], &trees[1], &pose, found.triangles, 1e9);
                assert_eq!(again.triangles, found.triangles, "near enough from the start");
            }
        }
    }

    #[test]
    fn a_surface_without_triangles_is_infinitely_far() {
        let (some, none) = (BoxTree::new(soup(1, 5)), BoxTree::new(vec![]));
        let found = nearest(&some, &none, &DPose3::identity(), [0, 0], 0.0);
        assert_eq!(found.distance, f64::INFINITY);
    }
}
