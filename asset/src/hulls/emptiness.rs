//! How deep in empty space the places around a surface lie, worked out once per grid cell.

use std::cell::RefCell;

use glamx::DVec3;
use object::mesh::Bounds;

use super::surface::Surface;

/// Most cells along the diagonal.
const FINEST: f64 = 256.0;
/// Most cells from one whose side was worked out to others that take it over.
const WIDEST: f64 = 4.0;
/// A side is taken over only where the winding number is this far from one half.
const CLEAR: f64 = 0.2;
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
    sides: RefCell<Vec<Side>>,
}

/// On which side of the surface a cell lies.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Unknown,
    Outside,
    Enclosed,
}

impl<'a> Emptiness<'a> {
    /// Ready to be asked about places within `bounds` at depths between `least` and `most` metres.
    pub(crate) fn new(surface: &'a Surface, bounds: &Bounds, range: (f64, f64)) -> Self {
        let step = (0.5 * range.0).max(bounds.diagonal() / FINEST);
        let counts = bounds.size().to_array().map(|s| (s / step).ceil().max(1.0) as usize);
        let cells = counts.iter().product();
        let known = RefCell::new(vec![UNKNOWN; cells]);
        let sides = RefCell::new(vec![Side::Unknown; cells]);
        Self { surface, corner: bounds.min, step, counts, range, known, sides }
    }

    /// Distance of the centre of a place's cell from the surface, metres; 0 if enclosed, any value
    /// below the least depth if nearer than that, the greatest depth if farther.
    pub(crate) fn depth(&self, p: DVec3) -> f64 {
        let cell = ((p - self.corner) / self.step).max(DVec3::ZERO).to_array();
        let mut at = [0; 3];
        for axis in 0..3 {
            at[axis] = (cell[axis] as usize).min(self.counts[axis] - 1);
        }
        let index = self.index(at);
        let mut known = self.known.borrow_mut();
        if known[index] == UNKNOWN {
            known[index] = self.work_out(at) as f32;
        }
        f64::from(known[index])
    }

    fn index(&self, at: [usize; 3]) -> usize {
        (at[2] * self.counts[1] + at[1]) * self.counts[0] + at[0]
    }

    fn work_out(&self, at: [usize; 3]) -> f64 {
        let centre = DVec3::from_array(at.map(|i| i as f64 + 0.5)) * self.step + self.corner;
        let distance = self.surface.distance(centre, self.range.1);
        if distance < self.range.0 {
            return distance;
        }
        let mut side = self.sides.borrow()[self.index(at)];
        if side == Side::Unknown {
            let winding = self.surface.winding(centre);
            side = if winding > 0.5 { Side::Enclosed } else { Side::Outside };
            let radius = if (winding - 0.5).abs() > CLEAR { distance } else { 0.0 };
            self.mark(at, side, radius);
        }
        if side == Side::Enclosed { 0.0 } else { distance }
    }

    /// Nothing of the surface lies within `radius` of a cell's centre: all centres there are on
    /// its side.
    fn mark(&self, at: [usize; 3], side: Side, radius: f64) {
        let reach = (radius / self.step).min(WIDEST);
        let span = |axis: usize| {
            let (low, high) = (at[axis] as f64 - reach, at[axis] as f64 + reach);
            (low.ceil().max(0.0) as usize)..=(high as usize).min(self.counts[axis] - 1)
        };
        let place = |at: [usize; 3]| DVec3::from_array(at.map(|i| i as f64));
        let mut sides = self.sides.borrow_mut();
        for z in span(2) {
            for y in span(1) {
                for x in span(0) {
                    let off = place([x, y, z]) - place(at);
                    if off.length_squared() <= reach * reach {
                        sides[self.index([x, y, z])] = side;
                    }
                }
            }
        }
    }
}
