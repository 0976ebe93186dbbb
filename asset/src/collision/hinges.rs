//! Moves the axis of a hinge onto the line where its two parts meet, if it is only a little off.

use glamx::{DPose3, DVec3};
use object::condition::GivenJoints;
use object::pose::joint_pose;
use object::{ArticulatedObject, JointMotion, Range};
use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry3d_f64::query::{self, PointQuery};
use parry3d_f64::shape::{ConvexPolyhedron, Shape};
use rayon::prelude::*;

use crate::change::Change;
use crate::collision::piece::ConvexPiece;

/// How far the gap at a hinge may open along its range, as a share of the asset's diagonal, and at
/// least in metres; half of what a checker of `simready-urdf 1.0` allows.
const GAP_SHARE: f64 = 0.0015;
const GAP_METRES: f64 = 0.0015;
/// An axis is moved by at most this share of the diagonal: further off it is another axis.
const REACH: f64 = 0.04;
/// Poses looked at on each side of rest.
const POSES: usize = 10;
/// Lines tried for one hinge, the nearest first.
const TRIES: usize = 60;

/// The same object, with the axes of its hinges moved sideways, where that is needed and enough, so
/// that each part stays at its parent over the whole range. Metres, asset frame.
pub(crate) fn settle(
    object: &ArticulatedObject,
    pieces: &[Vec<ConvexPiece>],
    given: &GivenJoints,
) -> (Vec<Vec<JointMotion>>, Vec<Change>) {
    let diagonal = object.mesh().bounds().diagonal();
    let bodies: Vec<Vec<Piece>> =
        pieces.par_iter().map(|p| p.iter().filter_map(Piece::new).collect()).collect();
    let tree = object.tree();
    let fit = |part: usize| {
        let mut motions = object.joints(part).to_vec();
        let Some(parent) = tree.parent(part) else { return (motions, None) };
        let pair = Pair { child: &bodies[part], parent: &bodies[parent], diagonal };
        let mut change = None;
        let hinges = motions.iter_mut().enumerate().filter(|(_, m)| m.kind.turns());
        for (_, motion) in hinges.filter(|(index, _)| !given.has_place(part, *index)) {
            let Some(pivot) = pair.better_pivot(motion) else { continue };
            let moved = (pivot - motion.pivot).length() * 1000.0;
            let name = &tree.parts()[part].name;
            let why = "the part left its parent along the range; the axis now runs where they meet";
            let (before, after) = ("as fitted".to_string(), format!("{moved:.1} mm aside"));
            change = Some(Change::new(name, "pivot", before, after, why));
            motion.pivot = pivot;
        }
        (motions, change)
    };
    let fitted: Vec<_> = (0..tree.len()).into_par_iter().map(fit).collect();
    let (motions, changes): (Vec<_>, Vec<_>) = fitted.into_iter().unzip();
    (motions, changes.into_iter().flatten().collect())
}

struct Piece {
    shape: ConvexPolyhedron,
    bounds: Aabb,
}

impl Piece {
    fn new(piece: &ConvexPiece) -> Option<Self> {
        let shape = ConvexPolyhedron::from_convex_hull(&piece.vertices)?;
        Some(Self { bounds: shape.compute_local_aabb(), shape })
    }
}

struct Pair<'a> {
    child: &'a [Piece],
    parent: &'a [Piece],
    diagonal: f64,
}

impl Pair<'_> {
    fn allowed(&self) -> f64 {
        (GAP_SHARE * self.diagonal).max(GAP_METRES)
    }

    /// A pivot with which the part stays at its parent; `None` if it does already, or never would.
    fn better_pivot(&self, motion: &JointMotion) -> Option<DVec3> {
        let allowed = self.gap(DPose3::identity())? + self.allowed();
        if self.holds(motion, allowed) {
            return None;
        }
        let tries = self.lines(motion, allowed).into_iter().take(TRIES);
        let moved = |pivot: DVec3| JointMotion { pivot, ..*motion };
        tries.into_iter().find(|&pivot| self.holds(&moved(pivot), allowed))
    }

    /// Pivots of parallel axes through points where the parts meet, the nearest first.
    fn lines(&self, motion: &JointMotion, allowed: f64) -> Vec<DVec3> {
        let aside = |p: DVec3| (p - motion.pivot).reject_from_normalized(motion.axis);
        let mut shifts: Vec<DVec3> = self.meeting_points(allowed).into_iter().map(aside).collect();
        shifts.retain(|s| s.length() <= REACH * self.diagonal);
        shifts.sort_by(|a, b| a.length().total_cmp(&b.length()));
        shifts.dedup_by(|a, b| a.distance(*b) < 1e-4 * self.diagonal);
        shifts.into_iter().map(|s| motion.pivot + s).collect()
    }

    /// Corners of either part that lie at the other, and nearest points between pieces.
    fn meeting_points(&self, allowed: f64) -> Vec<DVec3> {
        let mut found = Vec::new();
        for (a, b) in self.child.iter().flat_map(|a| self.parent.iter().map(move |b| (a, b))) {
            if !a.bounds.loosened(allowed).intersects(&b.bounds) {
                continue;
            }
            for (here, there) in [(a, b), (b, a)] {
                let near = there.bounds.loosened(allowed);
                let at = |p: &&DVec3| {
                    near.contains_local_point(**p)
                        && there.shape.distance_to_local_point(**p, true) <= allowed
                };
                found.extend(here.shape.points().iter().filter(at));
            }
            let rest = DPose3::identity();
            let nearest = query::closest_points(&rest, &a.shape, &rest, &b.shape, allowed);
            if let Ok(query::ClosestPoints::WithinMargin(p, q)) = nearest {
                found.push((p + q) / 2.0);
            }
        }
        found
    }

    /// Whether the gap to the parent stays within `allowed` metres along the range.
    fn holds(&self, motion: &JointMotion, allowed: f64) -> bool {
        let (lower, upper) = match motion.range {
            Range::Continuous => (0.0, std::f64::consts::TAU),
            Range::Limits { lower, upper } => (lower, upper),
        };
        let ends = [lower, upper].into_iter().filter(|e| *e != 0.0);
        let mut poses = ends.flat_map(|e| (1..=POSES).map(move |k| e * k as f64 / POSES as f64));
        poses.all(|q| self.is_near(joint_pose(motion, q), allowed))
    }

    fn is_near(&self, pose: DPose3, allowed: f64) -> bool {
        let rest = DPose3::identity();
        self.child.iter().any(|a| {
            let bounds = a.bounds.transform_by(&pose).loosened(allowed);
            self.parent.iter().any(|b| {
                bounds.intersects(&b.bounds)
                    && query::distance(&pose, &a.shape, &rest, &b.shape)
                        .is_ok_and(|d| d.distance <= allowed)
            })
        })
    }

    /// Distance between the parts, metres; `None` if either has no piece.
    fn gap(&self, pose: DPose3) -> Option<f64> {
        let rest = DPose3::identity();
        let pairs = self.child.iter().flat_map(|a| self.parent.iter().map(move |b| (a, b)));
        let distance = |(a, b): (&Piece, &Piece)| {
            query::distance(&pose, &a.shape, &rest, &b.shape).map_or(f64::INFINITY, |d| d.distance)
        };
        pairs.map(distance).min_by(f64::total_cmp)
    }
}
