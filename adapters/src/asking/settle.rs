//! One point from several views: where their rays pass each other, seen again from each of them.
//!
//! A model's pixels are off by some; the rays through them miss each other by little, and the place
//! nearest to all of them is off by less. Looking there again from each view gives surface that the
//! views agree on. A view whose pixel means another place is left out.

use object::{DMat3, DVec3};
use view::Camera;

use super::scene::Scene;

/// A view agrees with a place seen within this share of the picture's side from its own pixel.
const AGREES: f64 = 0.06;

/// A pixel that means a part, in one view.
#[derive(Clone, Copy, Debug)]
pub struct Sighting<'a> {
    /// The view.
    pub camera: &'a Camera,
    /// Pixels from the upper left corner.
    pub pixel: [f64; 2],
}

/// The place on the surface that some sightings of one part mean; none if none of them shows surface.
pub fn settled(scene: &Scene<'_>, sightings: &[Sighting<'_>]) -> Option<DVec3> {
    let own = || {
        let hits: Vec<_> =
            sightings.iter().filter_map(|s| scene.surface(s.camera, s.pixel)).collect();
        middle_of(&hits)
    };
    let Some((place, agreeing)) = agreed(sightings) else { return own() };
    // Rays that meet on the surface mean that very place, even at the edge of a part.
    if scene.is_on_surface(place) {
        return Some(place);
    }
    let seen_again = |s: &Sighting<'_>| scene.surface(s.camera, s.camera.project(place)?.pixel);
    let hits = agreeing.iter().filter_map(seen_again);
    let nearest =
        hits.min_by(|a, b| a.distance_squared(place).total_cmp(&b.distance_squared(place)));
    nearest.or_else(own)
}

/// The place nearest to the rays of all views that agree on it: the view that is furthest off is
/// left out until all do. None where no two agree.
fn agreed<'a>(sightings: &[Sighting<'a>]) -> Option<(DVec3, Vec<Sighting<'a>>)> {
    let mut left = sightings.to_vec();
    while left.len() > 1 {
        let place = meeting(&left)?;
        let off: Vec<_> = left.iter().map(|s| off_by(s, place)).collect();
        let worst = (0..left.len()).max_by(|&a, &b| off[a].total_cmp(&off[b]))?;
        if off[worst] <= AGREES {
            return Some((place, left));
        }
        left.remove(worst);
    }
    None
}

/// The point with the least sum of squared distances to the rays; none where they are nearly
/// parallel.
fn meeting(sightings: &[Sighting<'_>]) -> Option<DVec3> {
    let (mut matrix, mut sum) = (DMat3::ZERO, DVec3::ZERO);
    for s in sightings {
        let (origin, d) = s.camera.ray(s.pixel);
        let across = DMat3::IDENTITY - DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        matrix += across;
        sum += across * origin;
    }
    let steady = matrix.determinant() > 1e-3;
    Some(matrix.inverse() * sum).filter(|p| steady && p.is_finite())
}

/// How far from its pixel a view sees a place, as a share of the picture's side.
fn off_by(sighting: &Sighting<'_>, place: DVec3) -> f64 {
    let Some(seen) = sighting.camera.project(place) else { return f64::INFINITY };
    let [x, y] = [0, 1].map(|i| seen.pixel[i] - sighting.pixel[i]);
    x.hypot(y) / f64::from(sighting.camera.size[0].max(1))
}

/// Of some points the one with the least sum of distances to the others.
fn middle_of(points: &[DVec3]) -> Option<DVec3> {
    let far = |x: &DVec3| points.iter().map(|y| x.distance(*y)).sum::<f64>();
    points.iter().min_by(|a, b| far(a).total_cmp(&far(b))).copied()
}
