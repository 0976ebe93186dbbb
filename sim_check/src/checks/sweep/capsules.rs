//! How far apart balls and capsules are: segments and radii, so that what two of them do has a closed
//! form and does not cost more the finer they are cut up.

use glamx::{DPose3, DVec3};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d_f64::shape::SupportMap;

use super::hull::{Gap, Hull};
use super::round::Round;

impl Round {
    /// The segment's ends where the frame stands at `pose`.
    fn ends(self, pose: &DPose3) -> [DVec3; 2] {
        [-self.half, self.half].map(|z| pose.transform_point(DVec3::Z * z))
    }

    /// Distance or depth between this and another whose frame stands at `pose` in this one's; exact.
    pub(super) fn gap(self, other: Self, pose: &DPose3) -> Gap {
        let (mine, theirs) = (self.ends(&DPose3::identity()), other.ends(pose));
        let [p, q] = nearest(mine, theirs);
        let apart = q - p;
        let length = apart.length();
        let radii = self.radius + other.radius;
        // Where the segments meet, the shortest way out is across both.
        let tiny = 1e-12 * (radii + self.half + other.half);
        let across = || {
            let [u, v] = [mine, theirs].map(|[a, b]| (b - a).normalize_or_zero());
            let along = if u == DVec3::ZERO { v } else { u };
            let crossed = u.cross(v).try_normalize();
            crossed.unwrap_or_else(|| along.try_normalize().map_or(DVec3::X, perpendicular))
        };
        let normal = if length > tiny { apart / length } else { across() };
        Gap { distance: length - radii, normal }
    }

    /// The same between this and any hull; `None` where that is no solid.
    pub(super) fn gap_with(self, hull: &Hull, pose: &DPose3) -> Option<Gap> {
        match hull.round() {
            Some(round) => Some(self.gap(round, pose)),
            None => self.gap_to(hull, pose),
        }
    }

    /// The same between this and a polyhedron; `None` where its faces are not known.
    pub(super) fn gap_to(self, hull: &Hull, pose: &DPose3) -> Option<Gap> {
        let core = Core(self.ends(&DPose3::identity()));
        let start = pose.translation.try_normalize().unwrap_or(DVec3::X);
        let mut simplex = VoronoiSimplex::new();
        simplex.reset(CsoPoint::from_shapes(pose, &core, hull, start));
        if let GJKResult::ClosestPoints(a, b, normal) =
            closest_points(pose, &core, hull, f64::MAX, true, &mut simplex)
        {
            let (distance, proved) = (a.distance(b), core.gap_along(hull, pose, normal));
            if distance > 0.0 && proved >= distance * (1.0 - 1e-3) - 1e-9 * hull.size() {
                return Some(Gap { distance: distance - self.radius, normal });
            }
        }
        let facets = hull.facets();
        if facets.normals.is_empty() {
            return None;
        }
        let faces = facets.normals.iter().map(|n| -(pose.rotation * *n));
        let edges = facets.edges.iter().filter_map(|e| {
            DVec3::Z.cross(pose.rotation * e.along).try_normalize().filter(|_| self.half > 0.0)
        });
        let ways = faces.chain(edges.flat_map(|n| [n, -n]));
        let gaps = ways.map(|normal| (core.gap_along(hull, pose, normal), normal));
        let (distance, normal) = gaps.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Gap { distance: distance - self.radius, normal })
    }
}

/// A segment as a convex shape.
struct Core([DVec3; 2]);

impl Core {
    /// How far a hull lies from it along a direction.
    fn gap_along(&self, hull: &Hull, pose: &DPose3, normal: DVec3) -> f64 {
        let there = hull.local_support_point(pose.rotation.inverse() * -normal);
        normal.dot(pose.transform_point(there)) - normal.dot(self.local_support_point(normal))
    }
}

impl SupportMap for Core {
    fn local_support_point(&self, direction: DVec3) -> DVec3 {
        let [a, b] = self.0;
        if direction.dot(a) > direction.dot(b) { a } else { b }
    }
}

fn perpendicular(unit: DVec3) -> DVec3 {
    unit.any_orthonormal_vector()
}

/// The points where two segments come nearest each other (C. Ericson, Real-Time Collision
/// Detection, 2005, 5.1.9).
fn nearest([p, q]: [DVec3; 2], [r, s]: [DVec3; 2]) -> [DVec3; 2] {
    let (d, e, between) = (q - p, s - r, p - r);
    let (a, b, f) = (d.length_squared(), e.length_squared(), e.dot(between));
    let share =
        |over: f64, under: f64| if under > 0.0 { (over / under).clamp(0.0, 1.0) } else { 0.0 };
    let c = d.dot(between);
    let crossed = d.dot(e);
    let squared = a * b - crossed * crossed;
    let parallel = squared <= 1e-14 * a * b;
    let first = if parallel { 0.0 } else { share(crossed * f - c * b, squared) };
    let second = if b > 0.0 { (crossed * first + f) / b } else { 0.0 };
    let second_kept = second.clamp(0.0, 1.0);
    let first = if second != second_kept || parallel || b == 0.0 {
        share(crossed * second_kept - c, a)
    } else {
        first
    };
    [p + d * first, r + e * second_kept]
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::robot::Geometry;

    fn capsule(radius: f64, length: f64) -> Hull {
        Hull::of(&Geometry::Capsule { radius, length }).unwrap()
    }

    #[test]
    fn coaxial_capsules_are_as_deep_as_both_radii() {
        let (rail, cart) = (capsule(0.02, 2.0), capsule(0.1, 0.2));
        for along in [-0.9, 0.0, 0.7] {
            let gap = rail.gap(&cart, &DPose3::translation(0.0, 0.0, along), None);
            assert!((gap.distance + 0.12).abs() < 1e-12, "{along}: {gap:?}");
            assert!(gap.normal.z.abs() < 1e-12 && (gap.normal.length() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn crossed_capsules_and_balls_read_their_closed_form() {
        let rod = capsule(0.05, 1.0);
        let over = DPose3::from_parts(
            DVec3::new(0.08, 0.0, 0.2),
            glamx::DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
        );
        let gap = rod.gap(&rod, &over, None);
        assert!((gap.distance + 0.02).abs() < 1e-12 && (gap.normal - DVec3::X).length() < 1e-9);
        let ball = Hull::of(&Geometry::Sphere { radius: 0.3 }).unwrap();
        let gap = ball.gap(&ball, &DPose3::translation(0.0, 1.0, 0.0), None);
        assert!((gap.distance - 0.4).abs() < 1e-12, "{gap:?}");
        let gap = ball.gap(&rod, &DPose3::translation(0.0, 0.0, 0.7), None);
        assert!((gap.distance - (0.7 - 0.5 - 0.35)).abs() < 1e-12, "{gap:?}");
    }

    #[test]
    fn a_capsule_in_a_box_is_as_deep_as_its_nearest_side_and_its_radius() {
        let cube = Hull::of_box(DVec3::splat(1.0)).unwrap();
        let rod = capsule(0.1, 0.4);
        let gap = rod.gap(&cube, &DPose3::translation(0.3, 0.0, 0.0), None);
        assert!((gap.distance + 0.3).abs() < 1e-9, "{gap:?}");
        let back = cube.gap(&rod, &DPose3::translation(-0.3, 0.0, 0.0), None);
        assert!((back.distance + 0.3).abs() < 1e-9, "{back:?}");
        assert!((back.normal + DVec3::X).length() < 1e-9, "{back:?}");
        let apart = cube.gap(&rod, &DPose3::translation(0.7, 0.0, 0.0), None);
        assert!((apart.distance - 0.1).abs() < 1e-9, "{apart:?}");
    }

    #[test]
    fn segments_come_nearest_where_no_pair_of_points_comes_nearer() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(3);
        let mut point = || DVec3::from_array([(); 3].map(|()| rng.random_range(-1.0..1.0)));
        for round in 0..200 {
            let mut ends = [(); 4].map(|()| point());
            if round % 4 == 0 {
                ends[3] = ends[2] + (ends[1] - ends[0]) * 0.7;
            }
            let [a, b, c, d] = ends;
            let [p, q] = nearest([a, b], [c, d]);
            let steps = || (0..=100).map(|k| f64::from(k) / 100.0);
            let least = steps()
                .flat_map(|s| steps().map(move |t| (a + (b - a) * s).distance(c + (d - c) * t)))
                .fold(f64::INFINITY, f64::min);
            assert!(p.distance(q) <= least + 1e-12, "{round}: {} {least}", p.distance(q));
        }
    }
}
