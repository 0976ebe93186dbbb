//! How deep in empty space the places around a surface lie, worked out once per grid cell.

use std::cell::RefCell;

use glamx::DVec3;
use object::mesh::Bounds;

use super::surface::Surface;

/// Most cells along the diagonal.
const FINEST: f64 = 256.0;
/// A cell nobody has asked about.
const UNKNOWN: f32 = -1.0;

/// Distance from a surface where outside of what it encloses, by grid cell, filled as asked.
#[derive(Debug)]
pub(crate) struct Emptiness<'a> {
    surface: &'a Surface,
    corner: DVec3,
    step: f64,
    counts: [usize; 3],
    /// Depths are told apart between these two, metres.
    range: (f64, f64),
    known: RefCell<Vec<f32>>,
}

impl<'a> Emptiness<'a> {
    /// Ready to be asked about places within `bounds` at depths between `least` and `most` metres.
    pub(crate) fn new(surface: &'a Surface, bounds: &Bounds, range: (f64, f64)) -> Self {
        let step = (0.5 * range.0).max(bounds.diagonal() / FINEST);
        let counts = bounds.size().to_array().map(|s| (s / step).ceil().max(1.0) as usize);
        let known = RefCell::new(vec![UNKNOWN; counts.iter().product()]);
        Self { surface, corner: bounds.min, step, counts, range, known }
    }

    /// Distance of the centre of a place's cell from the surface, metres; 0 if enclosed, any value
    /// below the least depth if nearer than that, the greatest depth if farther.
    pub(crate) fn depth(&self, p: DVec3) -> f64 {
        let cell = ((p - self.corner) / self.step).max(DVec3::ZERO).to_array();
        let mut at = [0; 3];
        for axis in 0..3 {
            at[axis] = (cell[axis] as usize).min(self.counts[axis] - 1);
        }
        let index = (at[2] * self.counts[1] + at[1]) * self.counts[0] + at[0];
        let mut known = self.known.borrow_mut();
        if known[index] == UNKNOWN {
            let centre = DVec3::from_array(at.map(|i| i as f64 + 0.5)) * self.step + self.corner;
            known[index] = self.work_out(centre) as f32;
        }
        f64::from(known[index])
    }

    fn work_out(&self, centre: DVec3) -> f64 {
        let distance = self.surface.distance(centre, self.range.1);
        if distance >= self.range.0 && self.surface.encloses(centre) { 0.0 } else { distance }
    }
}
