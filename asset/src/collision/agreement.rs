//! How well what is seen of a part and its collision pieces agree, both ways.

use std::collections::HashMap;

use glamx::DVec3;
use object::Mesh;
use object::sample::sample_surface;
use rayon::prelude::*;

use crate::collision::hulls::split::skin;
use crate::collision::hulls::surface::Surface;
use crate::collision::solid::Solid;
use crate::surface::seal;

/// A part fits if its surface and pieces lie no farther apart than this, in tolerances.
pub(crate) const FITS: f64 = 0.95;
/// One point on the sides of a piece for a square of this side, in tolerances, but so many at least
/// and at most.
const ON_PIECE: f64 = 0.25;
const POINTS: (f64, f64) = (400.0, 30_000.0);
/// One sample of the surface for a square of this side, in tolerances, but so many at least and at
/// most; and the seed they are drawn with.
const GRAIN: f64 = 0.12;
const SAMPLES: (f64, f64) = (500.0, 30_000.0);
const SEED: u64 = 1;
/// A place is in a piece's inside from this share of the tolerance on.
const DEPTH: f64 = 1e-3;
/// Distances below this share of what fits need not be known: rounding makes none of them more.
const NEARLY: f64 = 1.0 - 1e-9;
/// Distances are told apart up to this many tolerances.
const FARTHEST: f64 = 4.0;

/// Largest distance between a part's surface and its pieces, in tolerances: of a seen place from
/// the nearest piece, or of a place on the pieces' outside from the solid that is seen. Above 1 a
/// checker would object; where it is below [`FITS`], some value below that.
pub(crate) fn gap(seen: &Mesh, pieces: &[Solid], tolerance: f64) -> f64 {
    gap_of(seen, (&Surface::new(seen), seal::is_closed(seen)), pieces, tolerance)
}

/// The same of a surface that is at hand, with whether it is closed.
pub(crate) fn gap_of(
    seen: &Mesh,
    surface: (&Surface, bool),
    pieces: &[Solid],
    tolerance: f64,
) -> f64 {
    bare(seen, pieces, tolerance).max(overhang(surface, pieces, tolerance)) / tolerance
}

/// Largest distance of the surface from the pieces, metres; where it is below [`FITS`] of the
/// tolerance, some value below that.
fn bare(seen: &Mesh, pieces: &[Solid], tolerance: f64) -> f64 {
    let area: f64 = (0..seen.faces().len()).map(|f| seen.area(f)).sum();
    let (least, most) = SAMPLES;
    let wanted = (area / (GRAIN * tolerance).powi(2)).clamp(least, most) as usize;
    let farthest = FARTHEST * tolerance;
    let near: Vec<_> = pieces.iter().map(|p| (p.bounds.grown(farthest), p)).collect();
    let distance = |p: DVec3| {
        let mut nearest = farthest;
        for (around, piece) in &near {
            if nearest > 0.5 * FITS * tolerance && around.holds(p) {
                nearest = nearest.min(piece.distance(p, nearest));
            }
        }
        nearest
    };
    let samples = sample_surface(seen, wanted, SEED);
    samples.par_iter().map(|s| distance(s.position)).reduce(|| 0.0, f64::max)
}

/// Largest distance of the pieces' outside from the solid, metres; where it is below [`FITS`] of the
/// tolerance, some value below that. What an open surface leaves half enclosed within a tolerance
/// counts as solid.
fn overhang((surface, is_closed): (&Surface, bool), pieces: &[Solid], tolerance: f64) -> f64 {
    let beside = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| a * tolerance);
    let encloses = |p: DVec3| surface.winding(p) > 0.5;
    let (enough, farthest) = (NEARLY * FITS * tolerance, FARTHEST * tolerance);
    let of_piece = |(at, piece): (usize, &Solid)| {
        let is_outer = |p: &DVec3| {
            let holds = |(k, other): (usize, &Solid)| k != at && other.holds(*p, DEPTH * tolerance);
            !pieces.iter().enumerate().any(holds)
        };
        let area: f64 = piece.facets.iter().map(|f| piece.area(f)).sum();
        let (least, most) = POINTS;
        let points = (area / (ON_PIECE * tolerance).powi(2)).clamp(least, most) as usize;
        let mut inner = Inner::new(farthest);
        let mut most = 0.0_f64;
        for p in skin(piece, points).into_iter().filter(is_outer) {
            if is_closed && inner.holds(p) {
                continue;
            }
            let distance = surface.distance_between(p, enough, farthest);
            // What is as near as this, or nearer than what hangs over already, changes nothing.
            if distance / tolerance <= FITS || distance <= most {
                continue;
            }
            if encloses(p) {
                inner.add(p, distance);
                continue;
            }
            let is_half = || beside.iter().any(|&a| encloses(p + a) || encloses(p - a));
            if distance / tolerance <= 1.0 || !is_half() {
                most = distance;
            }
        }
        most
    };
    pieces.par_iter().enumerate().map(of_piece).reduce(|| 0.0, f64::max)
}

/// Balls around places in a closed surface that it does not come into: all in them is enclosed.
struct Inner {
    /// The balls that reach into each cell of a grid: middle and square of the radius.
    cells: HashMap<[i64; 3], Vec<(DVec3, f64)>>,
    size: f64,
}

impl Inner {
    /// For balls no larger than this, metres.
    fn new(farthest: f64) -> Self {
        Self { cells: HashMap::new(), size: farthest }
    }

    fn cell(&self, p: DVec3) -> [i64; 3] {
        (p / self.size).floor().to_array().map(|c| c as i64)
    }

    fn holds(&self, p: DVec3) -> bool {
        let near = self.cells.get(&self.cell(p));
        near.is_some_and(|balls| balls.iter().any(|(middle, r)| middle.distance_squared(p) < *r))
    }

    fn add(&mut self, middle: DVec3, radius: f64) {
        let radius = NEARLY * radius;
        let [low, high] = [-radius, radius].map(|r| self.cell(middle + DVec3::splat(r)));
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    self.cells.entry([x, y, z]).or_default().push((middle, radius * radius));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::hulls::tests::add_box;
    use crate::collision::solid::MAX_CORNERS;

    fn block(min: [f64; 3], max: [f64; 3]) -> (Mesh, Solid) {
        let mut soup = (Vec::new(), Vec::new());
        add_box(&mut soup, min, max);
        let solid = Solid::of(&soup.0, MAX_CORNERS, 0.0).unwrap();
        (Mesh::new(soup.0, soup.1).unwrap(), solid)
    }

    #[test]
    fn a_box_and_its_own_hull_leave_no_gap() {
        let (mesh, solid) = block([0.0; 3], [1.0, 0.7, 0.3]);
        assert!(gap(&mesh, &[solid], 0.02) < 1e-9);
    }

    #[test]
    fn a_piece_too_short_leaves_surface_bare_and_one_too_long_hangs_over() {
        let (mesh, _) = block([0.0; 3], [1.0, 0.7, 0.3]);
        for (end, gap_there) in [(0.97, 1.5), (1.03, 1.5)] {
            let (_, solid) = block([0.0; 3], [end, 0.7, 0.3]);
            let found = gap(&mesh, &[solid], 0.02);
            assert!((found - gap_there).abs() < 0.01, "{end}: {found}");
        }
    }
}
