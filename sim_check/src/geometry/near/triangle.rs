//! Squared distances of points, segments and triangles. A triangle without area counts as its
//! edges, one without extent as its corner.

use glamx::DVec3;

/// Three corners, in order.
pub type Triangle = [DVec3; 3];

/// Squared distance of a point and a triangle.
pub fn to_point(triangle: &Triangle, p: DVec3) -> f64 {
    nearer_to_point(triangle, p, f64::INFINITY).unwrap_or(f64::INFINITY)
}

/// The same if that is less than `least`.
pub fn nearer_to_point(triangle: &Triangle, p: DVec3, least: f64) -> Option<f64> {
    let [a, b, c] = *triangle;
    let squared = match over(triangle, p) {
        Over::Beside { plane } if plane >= least => return None,
        Over::Beside { .. } => {
            let edges = [[a, b], [b, c], [c, a]].into_iter().map(|s| to_segment(s, p));
            edges.fold(f64::INFINITY, f64::min)
        }
        Over::Above(squared) => squared,
    };
    (squared < least).then_some(squared)
}

/// Squared distance of two triangles; 0 where they touch or pierce each other.
pub fn to_triangle(one: &Triangle, two: &Triangle) -> f64 {
    let edges = |t: &Triangle| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let mut least = f64::INFINITY;
    for s in edges(one) {
        for t in edges(two) {
            least = least.min(between_segments(s, t));
        }
    }
    for (points, face) in [(one, two), (two, one)] {
        for p in points {
            if let Over::Above(squared) = over(face, *p) {
                least = least.min(squared);
            }
        }
        if least > 0.0 && edges(points).into_iter().any(|s| pierces(s, face)) {
            return 0.0;
        }
    }
    least
}

/// How a point lies to a triangle; squared distances to its plane.
enum Over {
    /// Straight above or below it.
    Above(f64),
    /// Not so; 0 if the triangle has no plane.
    Beside { plane: f64 },
}

fn over([a, b, c]: &Triangle, p: DVec3) -> Over {
    let (ab, ac, ap) = (*b - *a, *c - *a, p - *a);
    let normal = ab.cross(ac);
    let squared = normal.length_squared();
    if squared <= 0.0 {
        return Over::Beside { plane: 0.0 };
    }
    let (v, w) = (normal.dot(ap.cross(ac)), normal.dot(ab.cross(ap)));
    let height = ap.dot(normal);
    let plane = height * height / squared;
    let is_above = v >= 0.0 && w >= 0.0 && v + w <= squared;
    if is_above { Over::Above(plane) } else { Over::Beside { plane } }
}

fn to_segment([a, b]: [DVec3; 2], p: DVec3) -> f64 {
    let along = b - a;
    let share = (p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
    (a + along * share.clamp(0.0, 1.0)).distance_squared(p)
}

/// The nearest points of two lines, each kept on its segment in turn.
fn between_segments([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, vv, uv) = (u.length_squared(), v.length_squared(), u.dot(v));
    let (uw, vw) = (u.dot(w), v.dot(w));
    let cross = uu * vv - uv * uv;
    let free = if cross > 0.0 { ((uv * vw - uw * vv) / cross).clamp(0.0, 1.0) } else { 0.0 };
    let on = |share: f64, length: f64| (share / length.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let t = on(uv * free + vw, vv);
    let s = on(uv * t - uw, uu);
    (w + u * s - v * t).length_squared()
}

/// Whether a segment goes through a triangle from one side to the other.
fn pierces([p, q]: [DVec3; 2], [a, b, c]: &Triangle) -> bool {
    let normal = (*b - *a).cross(*c - *a);
    let (from, to) = (normal.dot(p - *a), normal.dot(q - *a));
    if from * to >= 0.0 {
        return false;
    }
    let through = p + (q - p) * (from / (from - to));
    let inside = |u: DVec3, v: DVec3| normal.dot((v - u).cross(through - u)) >= 0.0;
    inside(*a, *b) && inside(*b, *c) && inside(*c, *a)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];

    fn moved(by: DVec3) -> Triangle {
        UNIT.map(|p| p + by)
    }

    #[test]
    fn a_point_is_as_far_as_the_face_the_edge_or_the_corner_it_is_nearest_to() {
        for (p, expected) in [
            (DVec3::new(0.2, 0.3, -0.7), 0.7),
            (DVec3::new(0.4, -3.0, 4.0), 5.0),
            (DVec3::new(4.0, 0.0, 4.0), 5.0),
            (DVec3::new(1.0, 1.0, 0.0), 0.5_f64.sqrt()),
            (DVec3::new(0.2, 0.2, 0.0), 0.0),
        ] {
            assert!((to_point(&UNIT, p).sqrt() - expected).abs() < 1e-15, "{p}");
        }
    }

    #[test]
    fn triangles_above_beside_and_through_each_other() {
        let distance = |t: Triangle| to_triangle(&UNIT, &t).sqrt();
        assert!((distance(moved(DVec3::Z * 0.3)) - 0.3).abs() < 1e-15);
        assert!((distance(moved(DVec3::new(4.0, 0.0, 4.0))) - 5.0).abs() < 1e-15);
        let upright =
            [DVec3::new(0.2, 0.2, -1.0), DVec3::new(0.2, 0.2, 1.0), DVec3::new(5.0, 5.0, 0.0)];
        assert_eq!(distance(upright), 0.0);
        let crossing =
            [DVec3::new(0.5, -1.0, 0.25), DVec3::new(0.5, 1.0, 0.25), DVec3::new(0.5, 0.0, 9.0)];
        assert!((distance(crossing) - 0.25).abs() < 1e-15, "edge over edge");
    }

    #[test]
    fn parallel_and_vanishing_edges_keep_their_distance() {
        let between = |s, t| between_segments(s, t).sqrt();
        let long = [DVec3::ZERO, DVec3::X * 10.0];
        assert_eq!(between(long, [DVec3::new(12.0, 3.0, 0.0), DVec3::new(4.0, 3.0, 0.0)]), 3.0);
        assert_eq!(between(long, [DVec3::new(13.0, 4.0, 0.0), DVec3::new(17.0, 4.0, 0.0)]), 5.0);
        assert_eq!(between(long, [DVec3::Y * 2.0, DVec3::Y * 2.0]), 2.0);
        let point = [DVec3::Z; 3];
        assert_eq!(to_triangle(&UNIT, &point), 1.0);
        assert_eq!(to_point(&point, DVec3::ZERO), 1.0);
    }
}
