//! What is known of every segment by itself (size, shape, direction, prompt), and how two of them
//! lie to each other.

use std::collections::BTreeMap;

use object::mesh::Bounds;
use object::{Condition, DVec3, Mesh};

use crate::classic::lexicon::sizes::SizePrior;
use crate::classic::segment::grow::merge::Link;
use crate::classic::segment::oversegment::contact::Touch;
use crate::classic::segment::oversegment::segments::Cut;
use crate::classic::segment::oversegment::units::Mass;
use crate::classic::segment::prompts::seeds::Seed;
use crate::classic::segment::prompts::shape::Shape;

/// For each segment and part, how likely it is, 0 to 1.
pub type Probabilities = Vec<Vec<f32>>;

/// Planes and axes closer than this share of the diagonal are one.
pub(crate) const LEVEL: f64 = 0.003;

#[derive(Clone, Debug)]
pub(crate) struct SegmentFacts {
    pub mass: Mass,
    pub shape: Shape,
    pub normal: DVec3,
    pub round: f64,
    pub axis: DVec3,
    pub share: f64,
    pub seed: Option<u16>,
    /// The part that merging gives it.
    pub merged: Option<u16>,
    /// Segments of the same shape.
    pub copies: Vec<u32>,
    pub around: Vec<Beside>,
}

/// A neighbour of a segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beside {
    pub segment: u32,
    pub evidence: f64,
    /// How likely that makes both of one part, 0 to 1.
    pub odds: f64,
    /// Contact of both, as a share of the smaller one's area.
    pub contact: f64,
    /// Share of the segment that lies in the neighbour.
    pub inside: f64,
    /// Share of the neighbour that lies in the segment.
    pub holds: f64,
}

/// What a layout is made from.
pub(crate) struct Known<'a> {
    pub mesh: &'a Mesh,
    /// For each face how its area is spread.
    pub masses: &'a [Mass],
    pub condition: &'a Condition,
    pub cut: &'a Cut,
    pub links: &'a [Link],
    pub touches: &'a BTreeMap<(u32, u32), Touch>,
    pub seeds: &'a [Seed],
    pub merged: &'a [Option<u16>],
    pub priors: &'a [SizePrior],
}

/// How far two round things turn about one line, 0 to 1.
pub(crate) fn coaxial(a: &SegmentFacts, b: &SegmentFacts, diagonal: f64) -> f64 {
    let apart = b.mass.centre() - a.mass.centre();
    let off = (apart - a.axis * apart.dot(a.axis)).length() / diagonal;
    a.round * b.round * a.axis.dot(b.axis).abs() * (-off / LEVEL).exp()
}

/// How many of the six sides of two boxes lie in one plane, as a share.
pub(crate) fn flush(a: &SegmentFacts, b: &SegmentFacts, diagonal: f64) -> f64 {
    let (a, b) = (&a.mass.bounds, &b.mass.bounds);
    let level = |x: f64, y: f64| usize::from((x - y).abs() < LEVEL * diagonal);
    let of = |axis: usize| level(a.min[axis], b.min[axis]) + level(a.max[axis], b.max[axis]);
    (0..3).map(of).sum::<usize>() as f64 / 6.0
}

/// Distance between two boxes, metres; 0 where they meet.
pub(crate) fn gap(a: &Bounds, b: &Bounds) -> f64 {
    (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO).length()
}

/// How much of a box lies in another, axis by axis, as a product.
pub(crate) fn overlap(a: &Bounds, b: &Bounds) -> f64 {
    let common = (a.max.min(b.max) - a.min.max(b.min)).max(DVec3::ZERO);
    let size = a.size();
    let share = |axis: usize| {
        let meets = a.min[axis] <= b.max[axis] && b.min[axis] <= a.max[axis];
        if size[axis] > 1e-9 { common[axis] / size[axis] } else { f64::from(u8::from(meets)) }
    };
    (0..3).map(share).product()
}

/// How many of the three sides of two boxes are equally long, as a share.
pub(crate) fn alike_sides(a: &SegmentFacts, b: &SegmentFacts) -> f64 {
    let (a, b) = (a.mass.bounds.size(), b.mass.bounds.size());
    let is = |axis: usize| usize::from((a[axis] - b[axis]).abs() <= 0.01 * a[axis].max(b[axis]));
    (0..3).map(is).sum::<usize>() as f64 / 3.0
}
