//! The depth of two overlapping convex bodies, by a polytope inside their Minkowski difference that
//! grows where it is nearest to the origin (G. van den Bergen, "Proximity queries and penetration
//! depth computation on 3D game objects", 2001).
//!
//! The polytope is closed at every step, so its nearest face is a lower bound of the depth, and the
//! difference's reach along that face's normal an upper one: where both meet, the depth is proved.

use glamx::{DPose3, DVec3};
use parry3d_f64::shape::SupportMap;

use super::hull::{Gap, Hull};

/// Most steps: a guess; what takes more is measured the exact way.
const MOST_STEPS: usize = 400;
/// Share of the depth that upper and lower bound may differ by.
const SLACK: f64 = 1e-3;
/// Share of the size that a point must rise above a face to count as outside: rounding.
const RISES: f64 = 1e-13;

/// A triangle of the polytope, its corners counter-clockwise from outside.
#[derive(Clone, Copy)]
struct Face {
    corners: [usize; 3],
    /// Outward unit normal.
    normal: DVec3,
    /// Its plane's distance from the origin; negative where the origin lies outside.
    distance: f64,
}

struct Polytope {
    points: Vec<DVec3>,
    faces: Vec<Face>,
    size: f64,
}

/// The depth, with the way out; `None` where it could not be proved: the difference is too flat, or
/// the steps did not suffice. The second's frame stands at `pose` in the first's.
pub(super) fn depth(a: &Hull, b: &Hull, pose: &DPose3) -> Option<Gap> {
    let size = a.size() + b.size();
    let reach = |along: DVec3| {
        let there = b.local_support_point(pose.rotation.inverse() * -along);
        a.local_support_point(along) - pose.transform_point(there)
    };
    let mut polytope = Polytope::start(size, &reach)?;
    for _ in 0..MOST_STEPS {
        let nearest = polytope.nearest()?;
        let point = reach(nearest.normal);
        let upper = point.dot(nearest.normal);
        if upper - nearest.distance <= SLACK * nearest.distance.abs() + 1e-9 * size {
            return Some(Gap { distance: -upper, normal: nearest.normal });
        }
        polytope.grow(point)?;
    }
    None
}

impl Polytope {
    /// A tetrahedron of far points of the difference.
    fn start(size: f64, reach: &dyn Fn(DVec3) -> DVec3) -> Option<Self> {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE.normalize()];
        let mut far: Vec<DVec3> =
            axes.iter().flat_map(|&axis| [reach(axis), reach(-axis)]).collect();
        let a = *far.first()?;
        let b = farthest(&far, |p| p.distance(a))?;
        let along = (b - a).try_normalize()?;
        let c = farthest(&far, |p| (p - a).reject_from_normalized(along).length())?;
        let normal = along.cross(c - a).try_normalize()?;
        far.extend([reach(normal), reach(-normal)]);
        let d = farthest(&far, |p| (p - a).dot(normal).abs())?;
        let height = (d - a).dot(normal);
        if height.abs() <= 1e-9 * size {
            return None;
        }
        let mut whole = Self { points: vec![a, b, c, d], faces: Vec::new(), size };
        // Faces turn away from the corner that is not theirs.
        let faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        let is_below = height < 0.0;
        for [p, q, r] in faces {
            let corners = if is_below { [p, q, r] } else { [p, r, q] };
            let face = whole.face(corners)?;
            whole.faces.push(face);
        }
        Some(whole)
    }

    fn face(&self, corners: [usize; 3]) -> Option<Face> {
        let [p, q, r] = corners.map(|c| self.points[c]);
        let normal = (q - p).cross(r - p).try_normalize()?;
        Some(Face { corners, normal, distance: normal.dot(p) })
    }

    /// The face whose plane is nearest to the origin, or farthest on the wrong side of it.
    fn nearest(&self) -> Option<Face> {
        self.faces.iter().copied().reduce(|a, b| if b.distance < a.distance { b } else { a })
    }

    /// The hull of the polytope and a point; `None` if rounding would tear it.
    fn grow(&mut self, point: DVec3) -> Option<()> {
        let new = self.points.len();
        self.points.push(point);
        let rises = RISES * self.size;
        let mut rim: Vec<[usize; 2]> = Vec::new();
        self.faces.retain(|face| {
            let is_seen = face.normal.dot(point) - face.distance > rises;
            if is_seen {
                let [p, q, r] = face.corners;
                for [from, to] in [[p, q], [q, r], [r, p]] {
                    match rim.iter().position(|edge| *edge == [to, from]) {
                        Some(shared) => drop(rim.swap_remove(shared)),
                        None => rim.push([from, to]),
                    }
                }
            }
            !is_seen
        });
        if !is_loop(&rim) {
            return None;
        }
        for [from, to] in rim {
            let face = self.face([from, to, new])?;
            self.faces.push(face);
        }
        Some(())
    }
}

fn farthest(points: &[DVec3], score: impl Fn(DVec3) -> f64) -> Option<DVec3> {
    let better = |a: DVec3, b: DVec3| if score(b) > score(a) { b } else { a };
    points.iter().copied().reduce(better)
}

/// Whether directed edges are one closed way that passes no corner twice.
fn is_loop(edges: &[[usize; 2]]) -> bool {
    let Some(&[first, mut at]) = edges.first() else { return false };
    let mut passed = 1;
    while at != first {
        let mut from = edges.iter().filter(|edge| edge[0] == at);
        let (Some(next), None) = (from.next(), from.next()) else { return false };
        at = next[1];
        passed += 1;
        if passed > edges.len() {
            return false;
        }
    }
    passed == edges.len()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glamx::DQuat;
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::checks::sweep::sat::widest_gap;
    use crate::robot::Geometry;

    type Random = rand_pcg::Pcg64Mcg;

    fn direction(rng: &mut Random) -> DVec3 {
        loop {
            let mut side = || rng.random_range(-1.0..1.0);
            let v = DVec3::new(side(), side(), side());
            if v.length() > 0.1 && v.length() < 1.0 {
                return v.normalize();
            }
        }
    }

    fn turn(rng: &mut Random) -> DQuat {
        DQuat::from_axis_angle(direction(rng), rng.random_range(0.0..2.0 * PI))
    }

    /// A housing as a printer makes it: round, thin or long, with flat sides and chamfers.
    fn housing(rng: &mut Random) -> Hull {
        let sizes = DVec3::new(1.0, rng.random_range(0.2..1.0), rng.random_range(0.02..0.6));
        let sides = rng.random_range(5..40);
        let points = (0..sides).flat_map(|k| {
            let angle = 2.0 * PI * f64::from(k) / f64::from(sides);
            [-1.0, -0.8, 0.8, 1.0].map(|z: f64| {
                let wide = if z.abs() < 1.0 { 1.0 } else { 0.9 };
                DVec3::new(wide * angle.cos(), wide * angle.sin(), z) * sizes * 0.05
            })
        });
        Hull::of_points(points.collect()).unwrap()
    }

    #[test]
    fn a_depth_is_never_more_than_the_shortest_way_out() {
        let mut rng = Random::seed_from_u64(11);
        let (mut asked, mut unproved) = (0, 0);
        for _ in 0..300 {
            let (a, b) = (housing(&mut rng), housing(&mut rng));
            let apart = direction(&mut rng) * rng.random_range(0.0..0.05);
            let pose = DPose3::from_parts(apart, turn(&mut rng));
            let exact = widest_gap(&a, &b, &pose).distance;
            if exact > -1e-4 {
                continue;
            }
            asked += 1;
            match depth(&a, &b, &pose) {
                Some(gap) => {
                    let most = 2e-3 * exact.abs() + 1e-9;
                    assert!((gap.distance - exact).abs() <= most, "{gap:?}, exactly {exact}");
                    let along = a.gap_along(&b, &pose, gap.normal);
                    assert!((along.distance - gap.distance).abs() < 1e-12);
                }
                None => unproved += 1,
            }
        }
        assert!(asked > 150 && unproved * 50 < asked, "{unproved} of {asked}");
    }

    #[test]
    fn a_hull_without_faces_is_as_deep_as_the_same_hull_with_them() {
        let mut rng = Random::seed_from_u64(3);
        for _ in 0..40 {
            let (a, b) = (housing(&mut rng), housing(&mut rng));
            let pose = DPose3::from_parts(direction(&mut rng) * 0.02, turn(&mut rng));
            let exact = widest_gap(&a, &b, &pose).distance;
            let bare = b.without_faces();
            if exact < -1e-4 {
                let gap = a.gap(&bare, &pose, None);
                assert!((gap.distance / exact - 1.0).abs() < 2e-3, "{gap:?}, exactly {exact}");
            }
        }
    }

    #[test]
    fn an_ellipsoid_is_as_deep_in_a_wall_as_its_formula_says() {
        let half = DVec3::new(0.4, 0.3, 0.07);
        let ball = Hull::of(&Geometry::Ellipsoid { half }).unwrap();
        let wall = Hull::of(&Geometry::Box { size: DVec3::new(4.0, 4.0, 2.0) }).unwrap();
        let mut rng = Random::seed_from_u64(5);
        for _ in 0..50 {
            let turn = turn(&mut rng);
            let up = (half * (turn.inverse() * DVec3::Z)).length();
            let pose = DPose3::from_parts(DVec3::Z * (1.0 + 0.6 * up), turn);
            let gap = wall.gap(&ball, &pose, None);
            assert!((gap.distance + 0.4 * up).abs() < 1e-3 * 0.4 * up, "{gap:?} {up}");
        }
    }

    #[test]
    fn two_equal_boxes_in_one_place_are_as_deep_as_they_are_thin() {
        let plate = Hull::of_box(DVec3::new(1.0, 0.7, 0.02)).unwrap();
        let gap = depth(&plate, &plate, &DPose3::identity());
        assert!(gap.is_none_or(|gap| (gap.distance + 0.02).abs() < 1e-9), "{gap:?}");
    }
}
