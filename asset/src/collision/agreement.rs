//! How well what is seen of a part and its collision pieces agree, both ways.

use glamx::DVec3;
use object::Mesh;
use object::sample::sample_surface;
use rayon::prelude::*;

use crate::collision::hulls::split::skin;
use crate::collision::hulls::surface::Surface;
use crate::collision::solid::Solid;

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
    gap_of(seen, &Surface::new(seen), pieces, tolerance)
}

/// The same of a surface that is at hand.
pub(crate) fn gap_of(seen: &Mesh, surface: &Surface, pieces: &[Solid], tolerance: f64) -> f64 {
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
fn overhang(surface: &Surface, pieces: &[Solid], tolerance: f64) -> f64 {
    let beside = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| a * tolerance);
    let is_solid = |p: DVec3| {
        let encloses = |p: DVec3| surface.winding(p) > 0.5;
        encloses(p) || beside.iter().any(|&a| encloses(p + a) || encloses(p - a))
    };
    let (enough, farthest) = (NEARLY * FITS * tolerance, FARTHEST * tolerance);
    let outside = |(at, piece): (usize, &Solid)| {
        let is_outer = |p: &DVec3| {
            let holds = |(k, other): (usize, &Solid)| k != at && other.holds(*p, DEPTH * tolerance);
            !pieces.iter().enumerate().any(holds)
        };
        let far = |p: DVec3| (surface.distance_between(p, enough, farthest), p);
        let area: f64 = piece.facets.iter().map(|f| piece.area(f)).sum();
        let (least, most) = POINTS;
        let points = (area / (ON_PIECE * tolerance).powi(2)).clamp(least, most) as usize;
        skin(piece, points).into_iter().filter(is_outer).map(far).collect::<Vec<_>>()
    };
    let places: Vec<Vec<(f64, DVec3)>> = pieces.par_iter().enumerate().map(outside).collect();
    let (mut far, near): (Vec<_>, Vec<_>) =
        places.into_iter().flatten().partition(|(distance, _)| *distance / tolerance > FITS);
    // Farthest first: the first that is not solid is what is asked for.
    far.sort_by(|a, b| b.0.total_cmp(&a.0));
    let is_empty = |&&(distance, p): &&(f64, DVec3)| match distance / tolerance {
        share if share > 1.0 => !is_solid(p),
        _ => surface.winding(p) <= 0.5,
    };
    match far.par_iter().find_first(is_empty) {
        Some((distance, _)) => *distance,
        None => near.iter().map(|(distance, _)| *distance).fold(0.0, f64::max),
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
        assert!(gap(&mesh, &[solid], 0.02) < FITS);
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
