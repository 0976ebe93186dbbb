//! How well two boxes agree: IoU and generalised IoU, side by side or each moved with its part.

use object::mesh::Bounds;
use object::{DPose3, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A side shorter than this is taken to be this long, so that sheets can be compared; unit cube.
pub const THINNEST: f64 = 1e-6;
/// Points drawn in each of two moved boxes.
pub const SAMPLES: usize = 2048;

/// The box with no side under [`THINNEST`], grown about its middle.
pub fn thickened(bounds: &Bounds) -> Bounds {
    let missing = (DVec3::splat(THINNEST) - bounds.size()).max(DVec3::ZERO) / 2.0;
    Bounds { min: bounds.min - missing, max: bounds.max + missing }
}

/// Volume of a box; 0 for an empty one.
pub fn volume(bounds: &Bounds) -> f64 {
    bounds.size().max(DVec3::ZERO).element_product()
}

/// The box around two boxes.
pub fn around(a: &Bounds, b: &Bounds) -> Bounds {
    Bounds { min: a.min.min(b.min), max: a.max.max(b.max) }
}

fn overlap(a: &Bounds, b: &Bounds) -> f64 {
    volume(&Bounds { min: a.min.max(b.min), max: a.max.min(b.max) })
}

/// Intersection over union; 0 where neither has volume.
pub fn iou(a: &Bounds, b: &Bounds) -> f64 {
    let both = overlap(a, b);
    ratio(both, volume(a) + volume(b) - both)
}

/// IoU less the share of the box around both that neither fills (Rezatofighi et al. 2019), −1 to
/// 1; NaN where the box around both has no volume.
pub fn giou(a: &Bounds, b: &Bounds) -> f64 {
    let either = volume(a) + volume(b) - overlap(a, b);
    let whole = volume(&around(a, b));
    iou(a, b) - (whole - either) / whole
}

fn ratio(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// A part's box at rest and the motion that takes it elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovedBox {
    /// The box at rest.
    pub rest: Bounds,
    /// From rest to where it is.
    pub pose: DPose3,
}

impl MovedBox {
    /// The axis-aligned box around it where it is.
    pub fn bounds(&self) -> Bounds {
        let corner = |i: u32| {
            let pick = |bit: u32, axis: usize| {
                if i >> bit & 1 == 1 { self.rest.max[axis] } else { self.rest.min[axis] }
            };
            self.pose * DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        };
        Bounds::of((0..8).map(corner))
    }

    /// How many of [`SAMPLES`] points drawn in it lie in the other.
    fn count_in(&self, other: &Self, rng: &mut Pcg64Mcg) -> f64 {
        let there = other.pose.inv_mul(&self.pose);
        let (low, size) = (self.rest.min, self.rest.size());
        let mut draw = || low + size * DVec3::new(rng.random(), rng.random(), rng.random());
        let holds = |p: DVec3| p.cmpge(other.rest.min).all() && p.cmple(other.rest.max).all();
        (0..SAMPLES).filter(|_| holds(there * draw())).count() as f64
    }
}

/// Generalised IoU of two boxes that stand askew, from points drawn in each; `whole` is the volume
/// of the box around both.
pub fn sampled_giou(a: &MovedBox, b: &MovedBox, whole: f64, seed: u64) -> f64 {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let (in_b, in_a) = (a.count_in(b, &mut rng), b.count_in(a, &mut rng));
    let (volume_a, volume_b) = (volume(&a.rest), volume(&b.rest));
    let both = (volume_a * in_b + volume_b * in_a) / 2.0 / SAMPLES as f64;
    let either = volume_a + volume_b - both;
    ratio(both, either) - ratio(whole - either, whole)
}
