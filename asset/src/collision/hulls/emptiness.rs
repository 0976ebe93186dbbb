//! How deep in empty space the places around a surface lie, worked out once per grid cell.

use std::sync::atomic::{AtomicU8, AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use glamx::DVec3;
use object::mesh::Bounds;

use super::surface::Surface;

/// Most cells along the diagonal.
const FINEST: f64 = 256.0;
/// Where cells are larger than they should be for want of room, depths down to this share of the least
/// may be asked for just as well.
const LEAST: f64 = 0.1;
/// Cells along the side of a block, from large to a single cell.
const BLOCKS: [usize; 3] = [8, 3, 1];
/// Cells along the side of the blocks whose centre's distance says enough of most cells in them.
const AROUND: [usize; 2] = [9, 3];
/// Cells along the side of the cubes that are made at once.
const CUBE: usize = 8;
/// A block is on one side of the surface only if the winding number is this far from one half.
const CLEAR: f64 = 0.2;
/// A cell nobody has asked about: its centre is at most infinitely far from the surface.
const UNKNOWN: f32 = f32::NEG_INFINITY;

/// Distance from a surface where outside of what it encloses, by grid cell, filled as asked. What a
/// cell holds depends on nothing but its place, so threads may ask in any order.
#[derive(Debug)]
pub(crate) struct Emptiness {
    surface: Arc<Surface>,
    corner: DVec3,
    step: f64,
    counts: [usize; 3],
    /// The depths it was made for.
    made_for: (f64, f64),
    /// Depths below the first are not asked for, those beyond the second not told apart, metres.
    depths: (f64, f64),
    /// Distance of each cell's centre from the surface, or minus a bound on it: an f32 as bits; a cube
    /// of cells at a time, made when first asked for.
    known: Vec<OnceLock<Box<[AtomicU32]>>>,
    /// Distance of the centre of each block from the surface, by size; for those below the least
    /// depth, some bound below it.
    around: [Vec<AtomicU32>; AROUND.len()],
    /// Side of each block, by size.
    sides: [Vec<AtomicU8>; BLOCKS.len()],
}

/// Side of a cell, metres, that tells places as deep as `least` from others.
fn step(bounds: &Bounds, least: f64) -> f64 {
    (0.5 * least).max(bounds.diagonal() / FINEST)
}

/// On which side of the surface a block lies.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Outside = 1,
    Enclosed = 2,
    /// The surface runs through it, or is too open to tell.
    Both = 3,
}

impl Emptiness {
    /// Ready to be asked about places within `bounds` at depths between the first and the second of
    /// `depths`, metres.
    pub(crate) fn new(surface: Arc<Surface>, bounds: &Bounds, depths: (f64, f64)) -> Self {
        let step = step(bounds, depths.0);
        let made_for = depths;
        let depths = (LEAST * depths.0, depths.1);
        let counts = bounds.size().to_array().map(|s| (s / step).ceil().max(1.0) as usize);
        let unknown = |counts: [usize; 3]| {
            let count = counts.iter().product();
            (0..count).map(|_| AtomicU32::new(UNKNOWN.to_bits())).collect()
        };
        let around = AROUND.map(|cells| unknown(blocks(counts, cells)));
        let cubes: usize = blocks(counts, CUBE).iter().product();
        let known = (0..cubes).map(|_| OnceLock::new()).collect();
        let sides = BLOCKS.map(|cells| {
            let blocks: usize = blocks(counts, cells).iter().product();
            (0..blocks).map(|_| AtomicU8::new(0)).collect()
        });
        let corner = bounds.min;
        Self { surface, corner, step, counts, made_for, depths, known, around, sides }
    }

    /// The depths that it was made for; they and the surface say all about what it tells.
    pub(crate) fn made_for(&self) -> (f64, f64) {
        self.made_for
    }

    /// Whether one made for these depths would tell no more.
    pub(crate) fn serves(&self, bounds: &Bounds, depths: (f64, f64)) -> bool {
        let is_as_fine = step(bounds, depths.0) > 0.9 * self.step;
        is_as_fine && depths.0 >= self.depths.0 && depths.1 <= self.depths.1
    }

    /// Whether a place's cell is outside of what the surface encloses and at least `depth` metres from
    /// it; `depth` below the greatest that is told apart.
    pub(crate) fn is_empty(&self, p: DVec3, depth: f64) -> bool {
        let cell = ((p - self.corner) / self.step).max(DVec3::ZERO).to_array();
        let mut at = [0; 3];
        for axis in 0..3 {
            at[axis] = (cell[axis] as usize).min(self.counts[axis] - 1);
        }
        self.is_far(at, depth as f32) && !self.is_enclosed(at)
    }

    /// Whether a cell's centre is at least `depth` metres from the surface.
    fn is_far(&self, at: [usize; 3], depth: f32) -> bool {
        let known = self.known(at);
        let distance = f32::from_bits(known.load(Ordering::Relaxed));
        // Below 0 is minus a bound: the surface is no farther than that.
        if distance >= 0.0 || -distance < depth {
            return distance >= depth;
        }
        for size in 0..AROUND.len() {
            let (around, reach) = self.around(at, size);
            if (around - depth).abs() > reach {
                return around > depth;
            }
        }
        let (centre, enough) = (self.centre(at, 1), f64::from(depth));
        let found = self.surface.distance_between(centre, enough, self.depths.1) as f32;
        let is_far = found >= depth;
        known.store((if is_far { found } else { -found }).to_bits(), Ordering::Relaxed);
        is_far
    }

    /// What is kept of a cell.
    fn known(&self, at: [usize; 3]) -> &AtomicU32 {
        let unknown = || (0..CUBE.pow(3)).map(|_| AtomicU32::new(UNKNOWN.to_bits())).collect();
        let cube = &self.known[index(at.map(|i| i / CUBE), blocks(self.counts, CUBE))];
        &cube.get_or_init(unknown)[index(at.map(|i| i % CUBE), [CUBE; 3])]
    }

    /// Distance of the centre of a cell's block from the surface, and no less than how far the
    /// cell's own centre may be from it.
    fn around(&self, at: [usize; 3], size: usize) -> (f32, f32) {
        let cells = AROUND[size];
        let reach = 0.5 * (cells - 1) as f64 * 3f64.sqrt() * self.step;
        let block = at.map(|i| i / cells);
        let known = &self.around[size][index(block, blocks(self.counts, cells))];
        let mut distance = f32::from_bits(known.load(Ordering::Relaxed));
        if distance < 0.0 {
            let (centre, (least, most)) = (self.centre(block, cells), self.depths);
            distance = self.surface.distance_between(centre, least, most + 2.0 * reach) as f32;
            known.store(distance.to_bits(), Ordering::Relaxed);
        }
        (distance, 1.001 * reach as f32)
    }

    fn is_enclosed(&self, at: [usize; 3]) -> bool {
        let told = (0..BLOCKS.len()).map(|size| self.side(at, size)).find(|s| *s != Side::Both);
        told == Some(Side::Enclosed)
    }

    /// Side of the block of the given size around a cell.
    fn side(&self, at: [usize; 3], size: usize) -> Side {
        let cells = BLOCKS[size];
        let block = at.map(|i| i / cells);
        let known = &self.sides[size][index(block, blocks(self.counts, cells))];
        match known.load(Ordering::Relaxed) {
            1 => return Side::Outside,
            2 => return Side::Enclosed,
            3 => return Side::Both,
            _ => {}
        }
        let centre = self.centre(block, cells);
        let reach = 0.5 * 3f64.sqrt() * self.step * cells as f64;
        if cells == 1 {
            // The last resort tells in any case.
            let side =
                if self.surface.winding(centre) > 0.5 { Side::Enclosed } else { Side::Outside };
            known.store(side as u8, Ordering::Relaxed);
            return side;
        }
        let is_clear = self.surface.distance_between(centre, reach, reach) >= reach;
        let winding = if is_clear { self.surface.winding(centre) } else { 0.5 };
        let side = match winding - 0.5 {
            above if above > CLEAR => Side::Enclosed,
            above if above < -CLEAR => Side::Outside,
            _ => Side::Both,
        };
        known.store(side as u8, Ordering::Relaxed);
        side
    }

    /// Centre of a cube of `cells` cells' side.
    fn centre(&self, at: [usize; 3], cells: usize) -> DVec3 {
        let middle = at.map(|i| (i as f64 + 0.5) * cells as f64);
        DVec3::from_array(middle) * self.step + self.corner
    }
}

/// Blocks of so many cells' side along each axis.
fn blocks(counts: [usize; 3], cells: usize) -> [usize; 3] {
    counts.map(|c| c.div_ceil(cells))
}

fn index(at: [usize; 3], counts: [usize; 3]) -> usize {
    (at[2] * counts[1] + at[1]) * counts[0] + at[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::hulls::tests::add_box;
    use object::Mesh;

    #[test]
    fn a_box_is_empty_outside_by_the_distance_from_it_and_full_inside() {
        let mut soup = (Vec::new(), Vec::new());
        add_box(&mut soup, [0.0; 3], [1.0; 3]);
        add_box(&mut soup, [2.0; 3], [3.0; 3]);
        let mesh = Mesh::new(soup.0, soup.1).unwrap();
        let empty = Emptiness::new(Arc::new(Surface::new(&mesh)), &mesh.bounds(), (0.05, 0.3));
        let at = |x: f64| DVec3::new(x, 0.5, 0.5);
        assert!(!empty.is_empty(at(0.5), 0.05) && empty.is_empty(at(2.0), 0.29));
        assert!(empty.is_empty(at(1.2), 0.17) && !empty.is_empty(at(1.2), 0.23));
        assert!(!empty.is_empty(at(1.01), 0.05));
        let places: Vec<DVec3> = (0..300).map(|i| at(f64::from(i) * 0.01)).collect();
        let again = Emptiness::new(Arc::new(Surface::new(&mesh)), &mesh.bounds(), (0.05, 0.3));
        let backwards: Vec<bool> = places.iter().rev().map(|&p| empty.is_empty(p, 0.1)).collect();
        let forwards = places.iter().map(|&p| again.is_empty(p, 0.1));
        assert!(forwards.eq(backwards.into_iter().rev()));
    }
}
