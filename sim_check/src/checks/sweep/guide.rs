//! Whether a moving part stays with what it is hinged to or slides in.

use glamx::{DPose3, DQuat, DVec3};

use super::overlap::body_distance;
use super::round::Round;
use super::scene::Scene;
use super::seen::{SeenGap, Skins};
use super::stance::Stance;
use crate::profile::bounds::{HINGE_GAP, SLIDE_KEEPS};

/// Poses looked at on each side of rest.
const SAMPLES: usize = 24;

/// The worst a joint does to the attachment of its part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    /// A hinge: how much the gap to its parent grows, metres, and where.
    GapGrowth {
        /// Metres; 0 if the gap never exceeds the one at rest.
        metres: f64,
        /// How much of that any part so thick does that hangs on this axis, metres.
        due: f64,
        /// Joint value, radians.
        at: f64,
    },
    /// A slide: the smallest share of its extent it keeps inside its guide, and where.
    Overlap {
        /// From 0 to 1.
        share: f64,
        /// Joint value, metres.
        at: f64,
    },
}

/// Largest growth of a hinge's gap: 3 mm, or 0.3 % of the diagonal where that is more.
pub fn gap_bound(scene: &Scene) -> f64 {
    HINGE_GAP.of(scene.diagonal)
}

/// How well the part of a drive stays with its guide: the nearest body above it that has pieces.
///
/// A hinge is judged by the gap to its parent, a slide by the share of its extent along the axis
/// that it keeps inside its parent's. A slide that never was inside (a button on a face) is judged
/// by the gap, like a hinge. `None` if either has no pieces.
pub fn hold(scene: &Scene, skins: &Skins, drive: usize) -> Option<Hold> {
    let guide = scene.guide_body(drive)?;
    let carried = scene.carried_bodies(drive);
    if carried.is_empty() {
        return None;
    }
    let share = |q: f64| overlap_share(scene, drive, (guide, &carried), q);
    if scene.turns(drive) || share(0.0) < SLIDE_KEEPS {
        return Some(gap_growth(scene, skins, drive, (guide, &carried)));
    }
    let least = |worst: (f64, f64), q: f64| if share(q) < worst.0 { (share(q), q) } else { worst };
    let (share, at) = samples(scene, drive).fold((f64::INFINITY, 0.0), least);
    Some(Hold::Overlap { share, at })
}

fn samples(scene: &Scene, drive: usize) -> impl Iterator<Item = f64> {
    let of = &scene.drives[drive];
    let ends = [of.lower, of.upper].into_iter().filter(|e| *e != 0.0);
    ends.flat_map(|end| (1..=SAMPLES).map(move |k| end * k as f64 / SAMPLES as f64))
}

/// How much the gap grows, seen where both have skins, else between collision pieces.
///
/// Only what beats the worst so far is measured to the end.
fn gap_growth<'a>(
    scene: &'a Scene<'a>,
    skins: &'a Skins,
    drive: usize,
    (guide, carried): (usize, &[usize]),
) -> Hold {
    let mut seen = SeenGap::new(scene, skins, guide, carried);
    let mut stance = Stance::new(scene);
    let mut gap = |q: f64, enough: f64| {
        stance.take(&[(drive, q)]);
        if let Some(seen) = &mut seen {
            return seen.at(&mut stance, enough);
        }
        let to_guide = |&b: &usize| body_distance(scene, &mut stance, [guide, b]);
        carried.iter().map(to_guide).fold(f64::INFINITY, f64::min)
    };
    let rest = gap(0.0, 0.0);
    let mut worst = (0.0, 0.0);
    for q in samples(scene, drive) {
        let growth = gap(q, rest + worst.0) - rest;
        worst = if growth > worst.0 { (growth, q) } else { worst };
    }
    let due = if scene.turns(drive) { due(scene, drive, (guide, carried)) } else { 0.0 };
    Hold::GapGrowth { metres: worst.0, due, at: worst.1 }
}

/// How much a gap grows because the axis lies within the part's thickness, metres: a door that
/// turns about its middle opens a gap of half its thickness. Nothing where the axis leaves the
/// part: then nothing holds it.
fn due(scene: &Scene, drive: usize, (guide, carried): (usize, &[usize])) -> f64 {
    let joint = &scene.robot.joints[scene.drives[drive].joint];
    let frame = scene.at_rest.links[joint.parent] * joint.origin;
    let (pivot, axis) = (frame.translation, frame.rotation * joint.axis);
    let to_parent = axis_distance(scene, (pivot, axis), &[guide]);
    if axis_distance(scene, (pivot, axis), carried) > gap_bound(scene) {
        return 0.0;
    }
    to_parent.min(thickness(scene, axis, carried))
}

/// Distance of some bodies at rest from an axis, metres.
fn axis_distance(scene: &Scene, (pivot, axis): (DVec3, DVec3), bodies: &[usize]) -> f64 {
    let reach = 2.0 * (scene.diagonal + pivot.length());
    let line = Round { half: reach, radius: 0.0 };
    let along = DQuat::from_rotation_arc(DVec3::Z, axis);
    let place = DPose3::from_parts(pivot, along);
    let pieces = bodies.iter().flat_map(|&b| &scene.bodies[b].pieces);
    let distance = |&p: &usize| {
        let pose = place.inv_mul(&scene.at_rest.poses[p]);
        line.gap_with(&scene.pieces[p].hull, &pose).map_or(f64::INFINITY, |gap| gap.distance)
    };
    pieces.map(distance).fold(f64::INFINITY, f64::min).max(0.0)
}

/// Smallest extent of some bodies at rest across an axis, metres.
fn thickness(scene: &Scene, axis: DVec3, bodies: &[usize]) -> f64 {
    let (u, v) = axis.any_orthonormal_pair();
    let extent = |k: usize| {
        let (s, c) = (std::f64::consts::PI * k as f64 / DIRECTIONS as f64).sin_cos();
        let direction = u * c + v * s;
        let pieces = bodies.iter().flat_map(|&b| &scene.bodies[b].pieces);
        let reach =
            |&p: &usize| scene.pieces[p].hull.extent_along(&scene.at_rest.poses[p], direction);
        let (low, high) = pieces
            .map(reach)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r.0), h.max(r.1)));
        high - low
    };
    (0..DIRECTIONS).map(extent).fold(f64::INFINITY, f64::min).max(0.0)
}

/// Directions across an axis in which a part's thickness is looked for: one every 2.5 degrees.
const DIRECTIONS: usize = 72;

fn overlap_share(scene: &Scene, drive: usize, (guide, carried): (usize, &[usize]), q: f64) -> f64 {
    let mut stance = Stance::of(scene, &[(drive, q)]);
    let joint = &scene.robot.joints[scene.drives[drive].joint];
    let axis = (stance.link(joint.parent) * joint.origin).rotation * joint.axis;
    let mut extent = |bodies: &[usize]| {
        let pieces = bodies.iter().flat_map(|&b| &scene.bodies[b].pieces);
        pieces
            .map(|&p| scene.pieces[p].hull.extent_along(&stance.piece(p), axis))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), e| (lo.min(e.0), hi.max(e.1)))
    };
    let ((lower, upper), (from, to)) = (extent(carried), extent(&[guide]));
    debug_assert!(axis != DVec3::ZERO);
    (upper.min(to) - lower.max(from)).max(0.0) / (upper - lower)
}
