//! The few axes a joint could have: box axes, contact directions, hinge lines, shafts.

use glamx::DSymmetricEigen3;
use object::{DMat3, DVec3};

use crate::classic::joints::contact::{Contact, Touch, covariance};
use crate::classic::joints::pins::pins;
use crate::classic::joints::scene::{Body, Scene};
use crate::classic::joints::sweep::Axis;

/// Directions closer than this are one: cos 6°.
const SAME_DIRECTION: f64 = 0.9945;
/// Axis lines closer than this share of the diagonal are one.
const SAME_LINE: f64 = 0.012;
/// A normal line passing a shaft's centre within this distance speaks for it.
pub const SHAFT_MISS: f64 = 0.004;
/// How far from a shaft's centre its surface may be.
pub const SHAFT_REACH: f64 = 0.12;

/// How many points of a part are looked at for pins beside its contact, at most.
const BESIDE: usize = 400;
/// How near its parent they are, a share of the diagonal; a handle's bar stands off farther.
const FROM_PARENT: f64 = 0.05;

/// Everything candidates are drawn from.
pub struct Sources<'a> {
    /// The whole object.
    pub scene: &'a Scene,
    /// The part that moves.
    pub body: &'a Body,
    /// Where it touches its parent.
    pub contact: &'a Contact,
    /// The part it hangs on.
    pub parent: &'a Body,
    /// The axis of the parent's own joint, if it has one.
    pub parent_axis: Option<DVec3>,
}

/// Candidate directions, the likeliest sources first, no two alike up to sign.
pub fn directions(from: &Sources) -> Vec<DVec3> {
    let mut found = vec![DVec3::X, DVec3::Y, DVec3::Z];
    found.extend(from.parent_axis);
    let body = from.body;
    let spots = body.samples.iter().map(|s| (s.position, 1.0));
    found.extend(principal(covariance(spots, body.centroid)));
    found.extend(principal(covariance(body.samples.iter().map(|s| (s.normal, 1.0)), DVec3::ZERO)));
    let centre = from.contact.centroid(body.centroid);
    let touch = |t: &Touch| (t.position, t.weight);
    found.extend(principal(covariance(from.contact.all().map(touch), centre)));
    let normal = |t: &Touch| (t.normal, t.weight);
    found.extend(principal(covariance(from.contact.child.iter().map(normal), DVec3::ZERO)));
    found.extend(principal(covariance(from.contact.parent.iter().map(normal), DVec3::ZERO)));
    for away in [body.centroid - centre, body.centroid - from.parent.centroid] {
        let level = DVec3::new(away.x, away.y, 0.0);
        found.extend([away, level, level.cross(DVec3::Z)].map(DVec3::normalize_or_zero));
    }
    distinct(found)
}

fn principal(spread: DMat3) -> [DVec3; 3] {
    let vectors = DSymmetricEigen3::new(spread).eigenvectors;
    [vectors.x_axis, vectors.y_axis, vectors.z_axis]
}

fn distinct(found: Vec<DVec3>) -> Vec<DVec3> {
    let mut kept: Vec<DVec3> = Vec::new();
    for d in found {
        let unit = d.is_finite() && (d.length() - 1.0).abs() < 1e-6;
        if unit && kept.iter().all(|k| k.dot(d).abs() < SAME_DIRECTION) {
            kept.push(d.normalize());
        }
    }
    kept
}

/// Candidate axes of a slide: one per direction, through the contact.
pub fn slides(from: &Sources, directions: &[DVec3]) -> Vec<Axis> {
    let pivot = from.contact.centroid(from.body.centroid);
    directions.iter().map(|&direction| Axis { direction, pivot, turns: false }).collect()
}

/// Candidate axes of a turn: for each direction, lines through the box, the contact, pins and shafts.
pub fn turns(from: &Sources, directions: &[DVec3]) -> Vec<Axis> {
    let beside = beside(from);
    directions.iter().flat_map(|&d| lines(from, &beside, directions, d)).collect()
}

/// Points of the part that are near what it hangs on: where labels give all knuckles of a hinge to the part,
/// they lie beside the contact.
fn beside(from: &Sources) -> Vec<Touch> {
    let samples = &from.body.samples;
    let few = samples.iter().step_by(samples.len() / BESIDE + 1);
    let near = few.filter(|s| from.parent.nearest(s.position, FROM_PARENT).is_some());
    near.map(|s| Touch { position: s.position, normal: s.normal, weight: 1.0 }).collect()
}

fn lines(from: &Sources, beside: &[Touch], directions: &[DVec3], d: DVec3) -> Vec<Axis> {
    let body = from.body;
    let touch = from.contact.centroid(body.centroid);
    let mut points = vec![body.centroid, touch];
    let (child, parent) = (&from.contact.child, &from.contact.parent);
    let pinned = [pins(from.scene, from.contact.all(), d), pins(from.scene, beside.iter(), d)];
    points.splice(0..0, pinned.concat());
    for side in [child, parent] {
        points.extend(shafts(side, d));
        points.extend(convergence(side.iter().copied(), d));
    }
    let whole = body.samples.iter();
    let whole = whole.map(|s| Touch { position: s.position, normal: s.normal, weight: 1.0 });
    points.extend(convergence(whole, d));
    for [u, v] in planes(directions, d) {
        points.extend(grid(body.probes.iter().copied(), [d, u, v]));
        let near = from.contact.all().filter(|t| t.weight > 0.3).map(|t| t.position);
        points.extend(grid(near, [d, u, v]));
    }
    let mut kept: Vec<Axis> = Vec::new();
    for p in points.into_iter().filter(|p| p.is_finite()) {
        let pivot = p + d * d.dot(body.bounds.centre() - p);
        if kept.iter().all(|k| k.radius(pivot) > SAME_LINE) {
            kept.push(Axis { direction: d, pivot, turns: true });
        }
    }
    kept
}

/// Up to two right-angled frames of the plane across `d`: along the world, along the part.
pub fn planes(directions: &[DVec3], d: DVec3) -> Vec<[DVec3; 2]> {
    let mut frames: Vec<[DVec3; 2]> = Vec::new();
    for &other in directions {
        let across = other.reject_from_normalized(d);
        if across.length() > 0.98 && frames.len() < 2 {
            let u = across.normalize();
            let turned = frames.iter().all(|[a, b]| a.dot(u).abs().max(b.dot(u).abs()) < 0.99);
            if turned {
                frames.push([u, d.cross(u)]);
            }
        }
    }
    if frames.is_empty() {
        let u = d.any_orthonormal_vector();
        frames.push([u, d.cross(u)]);
    }
    frames
}

/// The nine lines of the points' box across `d`: its middle, its faces' and its edges'.
fn grid(points: impl Iterator<Item = DVec3>, [d, u, v]: [DVec3; 3]) -> Vec<DVec3> {
    let empty = [f64::INFINITY, f64::NEG_INFINITY];
    let (mut a, mut b) = (empty, empty);
    for p in points {
        a = [a[0].min(p.dot(u)), a[1].max(p.dot(u))];
        b = [b[0].min(p.dot(v)), b[1].max(p.dot(v))];
    }
    let steps = |[low, high]: [f64; 2]| [(low + high) / 2.0, low, high];
    let at = |s: f64| steps(b).map(|t| u * s + v * t);
    debug_assert!(d.dot(u).abs() < 1e-6);
    steps(a).into_iter().flat_map(at).collect()
}

/// The point nearest to all normal lines, seen along `d`: the centre of a round part.
fn convergence(points: impl Iterator<Item = Touch>, d: DVec3) -> Option<DVec3> {
    let (mut matrix, mut right, mut weight) = (DMat3::ZERO, DVec3::ZERO, 0.0);
    for t in points {
        let across = t.normal.cross(d);
        let w = t.weight;
        matrix += DMat3::from_cols(across * across.x, across * across.y, across * across.z) * w;
        right += across * (across.dot(t.position) * w);
        weight += w;
    }
    let along = DMat3::from_cols(d * d.x, d * d.y, d * d.z) * weight;
    let full = matrix + along;
    let solvable = weight > 0.0 && full.determinant().abs() > 1e-4 * weight.powi(3);
    solvable.then(|| full.inverse() * right)
}

/// Up to three shafts along `d`: places where many normal lines of the contact meet.
fn shafts(points: &[Touch], d: DVec3) -> Vec<DVec3> {
    let side = |t: &&Touch| t.normal.dot(d).abs() < 0.3 && t.weight > 0.1;
    let round: Vec<&Touch> = points.iter().filter(side).collect();
    let stride = round.len() / 40 + 1;
    let few: Vec<&Touch> = round.iter().copied().step_by(stride).collect();
    let mut votes: Vec<(f64, DVec3)> = Vec::new();
    for (i, a) in few.iter().enumerate() {
        for b in few.iter().skip(i + 1) {
            if let Some(p) = meeting(a, b, d) {
                votes.push((shaft_support(&few, d, p), p));
            }
        }
    }
    votes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut kept: Vec<DVec3> = Vec::new();
    for (_, p) in votes {
        let away = |k: &DVec3| (*k - p).reject_from_normalized(d).length() > 2.0 * SHAFT_MISS;
        if kept.len() < 3 && kept.iter().all(away) {
            kept.push(p);
        }
    }
    kept
}

/// Where the normal lines of two points cross, seen along `d`, if that is near both and at a clear angle.
fn meeting(a: &Touch, b: &Touch, d: DVec3) -> Option<DVec3> {
    let [n, m] = [a, b].map(|t| t.normal.reject_from_normalized(d).normalize_or_zero());
    let sine = n.cross(m).dot(d);
    if sine.abs() < 0.3 {
        return None;
    }
    let along = (b.position - a.position).cross(m).dot(d) / sine;
    let p = a.position + n * along;
    let across = |t: &Touch| (t.position - p).reject_from_normalized(d).length();
    let even = (across(a) - across(b)).abs() < 0.25 * across(a).max(across(b));
    (across(a) < SHAFT_REACH && even).then_some(p)
}

/// Weight of the points whose normal line passes the line through `p` along `d` closely, spread
/// over many bearings: a flat wall beside the line is no shaft.
pub fn shaft_support(points: &[&Touch], d: DVec3, p: DVec3) -> f64 {
    let u = d.any_orthonormal_vector();
    let v = d.cross(u);
    let mut bearings = [0.0_f64; 12];
    for t in points {
        let n = t.normal.reject_from_normalized(d);
        let r = (t.position - p).reject_from_normalized(d);
        let side = n.length() > 0.95 && r.length() < SHAFT_REACH;
        if side && r.cross(n).dot(d).abs() < SHAFT_MISS.max(0.1 * r.length()) {
            let turn = (n.dot(v).atan2(n.dot(u)) / std::f64::consts::TAU + 0.5) * 12.0;
            bearings[(turn as usize).min(11)] += t.weight;
        }
    }
    bearings.iter().map(|b| b.min(3.0)).sum()
}
