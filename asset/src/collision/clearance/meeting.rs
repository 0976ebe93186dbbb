//! Two convex bodies in motion: proof that a plane keeps them apart, or where they meet.

use glamx::{DPose3, DVec3};
use object::JointMotion;
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d_f64::shape::SupportMap;

use super::motion::Motion;
use crate::collision::solid::Solid;

/// Most intervals looked at for one pair of bodies.
const MOST_LOOKS: usize = 6_000;
/// Step, radians, in which a turning body is looked at where both move.
const FINEST_TURN: f64 = 0.2;

/// How two bodies a and b move in a common frame; each by one joint at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Meeting {
    /// Motion of a.
    pub(crate) a: Motion,
    /// Motion of b.
    pub(crate) b: Motion,
}

/// How close is too close, and how finely to look.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closeness {
    /// Bodies nearer than this are in conflict, metres.
    pub(crate) gap: f64,
    /// An interval of conflict is divided no further than into this share of the range.
    pub(crate) share: f64,
    /// Bodies apart in the middle of an interval of less travel than this are apart in all of it,
    /// metres.
    pub(crate) grain: f64,
}

impl Meeting {
    /// The same meeting with the bodies' names exchanged.
    pub(crate) fn flipped(&self) -> Self {
        Self { a: self.b, b: self.a }
    }

    /// Largest n · x, in b's own frame, that points of a reach; where both move and b turns, a
    /// little more.
    pub(crate) fn reach(&self, points: &[DVec3], n: DVec3) -> f64 {
        if self.a == Motion::Still {
            return self.b.reversed().support(points, n);
        }
        let Motion::Along(joint, low, high) = self.b else {
            return self.a.support(points, n);
        };
        let seen_at = |q: f64| {
            let pose = object::pose::joint_pose(&joint, q);
            let turned = pose.transform_vector(n);
            self.a.support(points, turned) - turned.dot(pose.translation)
        };
        if !joint.kind.turns() {
            return seen_at(low).max(seen_at(high));
        }
        // A point on an arm r rises at most r (1 - cos(step / 2)) above the poses looked at.
        let steps = ((high - low) / FINEST_TURN).ceil().max(1.0);
        let step = (high - low) / steps;
        let tried = (0..=steps as u32).map(|i| seen_at(low + step * f64::from(i)));
        tried.fold(f64::NEG_INFINITY, f64::max)
            + self.arm(points, &joint) * (1.0 - (step / 2.0).cos())
    }

    /// Largest distance of a's points from the axis b turns about.
    fn arm(&self, points: &[DVec3], joint: &JointMotion) -> f64 {
        let (u, v) = joint.axis.any_orthonormal_pair();
        let reach = |n: DVec3| self.a.support(points, n) - n.dot(joint.pivot);
        let farthest = [u, -u, v, -v].map(reach).into_iter().fold(0.0, f64::max);
        farthest * std::f64::consts::SQRT_2
    }

    /// Pose of a as b sees it in the middle of both intervals.
    pub(crate) fn middle(&self) -> DPose3 {
        self.b.middle().inverse() * self.a.middle()
    }

    /// The intervals in which the bodies come closer than `gap`; empty if planes keep them apart.
    pub(crate) fn conflicts(&self, a: &Solid, b: &Solid, close: &Closeness) -> Vec<Meeting> {
        let smallest = |m: &Motion| close.share * (m.ends().1 - m.ends().0);
        let leaf = [smallest(&self.a), smallest(&self.b)];
        let seeds = self.quadrants().into_iter().map(|m| (m, DVec3::ZERO));
        let (mut found, mut stack) = (Vec::new(), seeds.collect::<Vec<_>>());
        let mut looks = 0;
        while let Some((meeting, hint)) = stack.pop() {
            if hint != DVec3::ZERO && meeting.apart(a, b, hint, close.gap) {
                continue;
            }
            let apart = meeting.nearest(a, b);
            let (n, distance) = apart.unwrap_or((DVec3::ZERO, f64::NEG_INFINITY));
            if distance >= close.gap && meeting.apart(a, b, n, close.gap) {
                continue;
            }
            looks += 1;
            let travel = [meeting.a.travel(&a.vertices), meeting.b.travel(&b.vertices)];
            let done = if distance >= 0.6 * close.gap {
                travel[0] + travel[1] <= close.grain
            } else {
                let coarse = |m: &Motion, leaf: f64| m.ends().1 - m.ends().0 <= leaf * 1.001;
                coarse(&meeting.a, leaf[0]) && coarse(&meeting.b, leaf[1])
            };
            if done || looks > MOST_LOOKS {
                if distance < 0.6 * close.gap {
                    found.push(meeting);
                }
                continue;
            }
            stack.extend(meeting.parted(travel).into_iter().rev().map(|m| (m, n)));
        }
        found
    }

    /// The meeting divided where a joint is at rest, for that is where ranges are cut from.
    fn quadrants(&self) -> Vec<Self> {
        let sides = |m: &Motion| match m.ends() {
            (low, high) if low < 0.0 && high > 0.0 => vec![m.over(low, 0.0), m.over(0.0, high)],
            _ => vec![*m],
        };
        let of_b = |a: Motion| sides(&self.b).into_iter().map(move |b| Self { a, b });
        sides(&self.a).into_iter().flat_map(of_b).collect()
    }

    /// Halves of the interval with more travel.
    fn parted(&self, travel: [f64; 2]) -> [Self; 2] {
        if travel[0] >= travel[1] {
            self.a.halves().map(|a| Self { a, ..*self })
        } else {
            self.b.halves().map(|b| Self { b, ..*self })
        }
    }

    /// Whether the plane across n keeps the bodies `gap` apart over both intervals.
    fn apart(&self, a: &Solid, b: &Solid, n: DVec3, gap: f64) -> bool {
        self.a.support(&a.vertices, n) + self.b.support(&b.vertices, -n) <= -gap
    }

    /// The direction from a to b and their distance in the middle of the intervals, common frame;
    /// `None` if they overlap.
    fn nearest(&self, a: &Solid, b: &Solid) -> Option<(DVec3, f64)> {
        let (pa, pb) = (self.a.middle(), self.b.middle());
        let n = nearest_direction(&a.vertices, &b.vertices, &(pa.inverse() * pb))?;
        let n = pa.transform_vector(n).normalize_or(DVec3::Z);
        Some((n, clear(a, b, [&pa, &pb], n)))
    }

    /// The direction from a to b along which they are farthest apart in the middle of the
    /// intervals (or overlap least), common frame, and that distance, negative for overlap.
    /// Proved by projection; a direction with at least `enough` ends the search.
    pub(crate) fn separation(&self, a: &Solid, b: &Solid, enough: f64) -> (DVec3, f64) {
        let (pa, pb) = (self.a.middle(), self.b.middle());
        let mut best = self.nearest(a, b).unwrap_or((DVec3::Z, f64::NEG_INFINITY));
        let sides_a = a.facets.iter().map(|f| pa.transform_vector(f.normal));
        let sides_b = b.facets.iter().map(|f| -pb.transform_vector(f.normal));
        for n in sides_a.chain(sides_b) {
            if best.1 >= enough {
                break;
            }
            let distance = clear(a, b, [&pa, &pb], n);
            if distance > best.1 {
                best = (n, distance);
            }
        }
        best
    }
}

/// How far apart two bodies at these poses are along n, common frame; negative if they overlap.
fn clear(a: &Solid, b: &Solid, [pa, pb]: [&DPose3; 2], n: DVec3) -> f64 {
    let (na, nb) = (pa.inverse_transform_vector(n), pb.inverse_transform_vector(-n));
    n.dot(pb.translation) - n.dot(pa.translation) - a.support(na) - b.support(nb)
}

/// Corners of a convex body as parry wants to be asked for them.
struct Corners<'a>(&'a [DVec3]);

impl SupportMap for Corners<'_> {
    fn local_support_point(&self, direction: DVec3) -> DVec3 {
        let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
        for &v in self.0 {
            let height = v.dot(direction);
            if height > best.0 {
                best = (height, v);
            }
        }
        best.1
    }
}

/// Direction from the nearest point of a to that of b, a's frame; `None` if they overlap.
fn nearest_direction(a: &[DVec3], b: &[DVec3], b_in_a: &DPose3) -> Option<DVec3> {
    let (a, b) = (Corners(a), Corners(b));
    let mut simplex = VoronoiSimplex::new();
    let start = b_in_a.translation.try_normalize().unwrap_or(DVec3::X);
    simplex.reset(CsoPoint::from_shapes(b_in_a, &a, &b, start));
    match closest_points(b_in_a, &a, &b, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(_, _, n) | GJKResult::NoIntersection(n) => Some(n),
        GJKResult::Proximity(n) => Some(n),
        GJKResult::Intersection => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use object::{JointKind, Range};

    const CLOSE: Closeness = Closeness { gap: 1e-3, share: 1.0 / 64.0, grain: 2.5e-4 };

    fn block(min: [f64; 3], max: [f64; 3]) -> Solid {
        let mut soup = (Vec::new(), Vec::new());
        crate::collision::hulls::tests::add_box(&mut soup, min, max);
        Solid::of(&soup.0, 64, 0.0).unwrap()
    }

    fn joint(kind: JointKind, axis: DVec3) -> JointMotion {
        JointMotion {
            kind,
            axis,
            pivot: DVec3::ZERO,
            range: Range::Limits { lower: 0.0, upper: 1.0 },
        }
    }

    #[test]
    fn the_separation_of_two_boxes_is_their_gap_or_minus_their_overlap() {
        let still = Meeting { a: Motion::Still, b: Motion::Still };
        let a = block([0.0; 3], [1.0; 3]);
        let (n, d) = still.separation(&a, &block([1.25, 0.2, 0.3], [2.0, 0.9, 0.8]), 9.0);
        assert!((d - 0.25).abs() < 1e-9 && (n - DVec3::X).length() < 1e-6);
        let (n, d) = still.separation(&a, &block([0.3, 0.9, 0.3], [0.6, 2.0, 0.8]), 9.0);
        assert!((d + 0.1).abs() < 1e-9 && (n - DVec3::Y).length() < 1e-6);
    }

    #[test]
    fn a_drawer_gliding_past_a_wall_is_proved_free_in_one_look() {
        let slide = Motion::Along(joint(JointKind::Prismatic, DVec3::Y), -2.0, 0.0);
        let meeting = Meeting { a: slide, b: Motion::Still };
        let (drawer, wall) =
            (block([0.0; 3], [1.0; 3]), block([1.0011, -9.0, 0.0], [1.1, 9.0, 1.0]));
        assert!(meeting.conflicts(&drawer, &wall, &CLOSE).is_empty());
        let near = block([1.0005, -9.0, 0.0], [1.1, 9.0, 1.0]);
        assert!(!meeting.conflicts(&drawer, &near, &CLOSE).is_empty());
    }

    #[test]
    fn a_door_meets_a_wall_where_the_angle_says() {
        let turn = Motion::Along(joint(JointKind::Revolute, DVec3::Z), 0.0, 2.0);
        let meeting = Meeting { a: turn, b: Motion::Still };
        let (door, wall) =
            (block([0.0; 3], [1.0, 0.001, 1.0]), block([-1.0, 0.5, 0.0], [1.0, 0.6, 1.0]));
        let found = meeting.conflicts(&door, &wall, &CLOSE);
        let first = found.iter().map(|m| m.a.ends().0).fold(9.0, f64::min);
        let (angle, leaf) = (0.5f64.asin(), 2.0 / 64.0);
        assert!(first <= angle && first > angle - 2.0 * leaf, "found {first}, true {angle}");
    }

    #[test]
    fn seen_from_a_turning_body_a_point_reaches_as_far_as_it_sweeps() {
        let turn = Motion::Along(joint(JointKind::Revolute, DVec3::Z), -1.0, 1.0);
        let meeting = Meeting { a: Motion::Still, b: turn };
        let reach = meeting.reach(&[DVec3::X], DVec3::Y);
        assert!((reach - 1f64.sin()).abs() < 1e-12);
        let both = Meeting { a: turn, b: turn.reversed() }.reach(&[DVec3::X], DVec3::Y);
        assert!((1.0..1.01).contains(&both), "a quarter turn lies within two of one radian");
    }
}
