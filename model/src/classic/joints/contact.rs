//! Where a part touches the part it hangs on.

use object::sample::SurfacePoint;
use object::{DMat3, DVec3};

use crate::classic::joints::scene::Scene;

/// Points sampled on each side of a contact.
const SAMPLES: usize = 700;
/// The zone around the parent in which a part counts as touching, beyond its nearest point.
const ZONE: f64 = 0.012;
/// A parent farther than this does not guide its child.
const REACH: f64 = 0.1;

/// A point near the other part.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Where.
    pub position: DVec3,
    /// Outward unit normal of its own surface.
    pub normal: DVec3,
    /// 1 at the nearest point, falling to 0 away from it.
    pub weight: f64,
}

/// Both sides of a contact.
#[derive(Clone, Debug, Default)]
pub struct Contact {
    /// Points of the child.
    pub child: Vec<Touch>,
    /// Points of the parent (or of whatever stays behind, if the parent is far).
    pub parent: Vec<Touch>,
    /// Smallest distance found.
    pub gap: f64,
}

impl Contact {
    /// Finds where `child` touches `parent`; if that is far, where it touches any of `still`.
    pub fn new(scene: &Scene, [child, parent]: [usize; 2], still: &[usize], seed: u64) -> Self {
        let own = Self::between(scene, child, &[parent], seed);
        if own.gap < REACH / 4.0 { own } else { Self::between(scene, child, still, seed) }
    }

    fn between(scene: &Scene, child: usize, others: &[usize], seed: u64) -> Self {
        let (mut near, mut far) = (Vec::new(), Vec::new());
        let body = &scene.bodies[child];
        let bounds = others.iter().map(|&o| scene.bodies[o].bounds);
        for around in bounds {
            near.extend(body.samples_near(around, ZONE, SAMPLES, seed));
        }
        near.extend(&body.samples);
        for &o in others {
            far.extend(scene.bodies[o].samples_near(body.bounds, ZONE, SAMPLES, seed));
        }
        let near = distances(scene, &near, others);
        let far = distances(scene, &far, &[child]);
        let gap = near.iter().chain(&far).map(|n| n.1).fold(REACH, f64::min);
        Self { child: touches(&near, gap), parent: touches(&far, gap), gap }
    }

    /// Points of both sides.
    pub fn all(&self) -> impl Iterator<Item = &Touch> {
        self.child.iter().chain(&self.parent)
    }

    /// Weighted mean of the child's side, or `otherwise` if nothing touches.
    pub fn centroid(&self, otherwise: DVec3) -> DVec3 {
        let (sum, weight) = self
            .all()
            .fold((DVec3::ZERO, 0.0), |(s, w), t| (s + t.position * t.weight, w + t.weight));
        if weight > 0.0 { sum / weight } else { otherwise }
    }
}

fn distances<'a>(
    scene: &Scene,
    points: &'a [SurfacePoint],
    others: &[usize],
) -> Vec<(&'a SurfacePoint, f64)> {
    let far = |s: &'a SurfacePoint| {
        (s, scene.nearest(others, s.position, REACH).map_or(REACH, |n| n.distance))
    };
    points.iter().map(far).collect()
}

fn touches(points: &[(&SurfacePoint, f64)], gap: f64) -> Vec<Touch> {
    let touch = |&(s, d): &(&SurfacePoint, f64)| Touch {
        position: s.position,
        normal: s.normal,
        weight: (-((d - gap) / ZONE).powi(2) * 4.0).exp(),
    };
    let touching = |t: &Touch| gap < REACH && t.weight > 0.02;
    points.iter().map(touch).filter(touching).collect()
}

/// Weighted covariance of vectors about their mean (positions) or about zero (normals).
pub fn covariance(vectors: impl Iterator<Item = (DVec3, f64)>, centre: DVec3) -> DMat3 {
    let mut sum = DMat3::ZERO;
    let mut weight = 0.0;
    for (v, w) in vectors {
        let r = v - centre;
        sum += DMat3::from_cols(r * r.x, r * r.y, r * r.z) * w;
        weight += w;
    }
    if weight > 0.0 { sum * (1.0 / weight) } else { sum }
}
