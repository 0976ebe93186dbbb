//! How far boxes are apart.

use glamx::DVec3;
use object::mesh::Bounds;

/// Distance between two boxes; 0 if they touch.
pub fn box_distance(a: &Bounds, b: &Bounds) -> f64 {
    (a.min - b.max).max(b.min - a.max).max(DVec3::ZERO).length()
}

/// Whether two boxes may be within a distance of each other, metres: what is no number may.
pub fn may_be_within(a: &Bounds, b: &Bounds, distance: f64) -> bool {
    let apart = box_distance(a, b);
    apart <= distance || apart.is_nan()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_apart_by_their_nearest_corners_and_0_where_they_touch() {
        let at = |min: DVec3| Bounds { min, max: min + DVec3::ONE };
        let here = at(DVec3::ZERO);
        assert_eq!(box_distance(&here, &at(DVec3::new(4.0, 5.0, 0.5))), 5.0);
        assert_eq!(box_distance(&here, &at(DVec3::X)), 0.0);
        assert!(may_be_within(&here, &at(DVec3::X * 3.0), 2.0));
        assert!(!may_be_within(&here, &at(DVec3::X * 3.0), 1.999));
        assert!(may_be_within(&here, &at(DVec3::NAN), 0.0), "what is no number may");
    }
}
