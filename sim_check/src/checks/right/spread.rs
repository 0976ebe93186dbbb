//! Points spread over triangles.

use glamx::DVec3;

/// The steps of the sequence that spreads points over a triangle: the reciprocals of the plastic number and of
/// its square (Roberts 2018).
const STEPS: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

/// A triangle by its corners, metres.
pub(super) type Triangle = [DVec3; 3];

/// The area of a triangle, square metres.
pub(super) fn area(triangle: &Triangle) -> f64 {
    let [a, b, c] = *triangle;
    (b - a).cross(c - a).length() / 2.0
}

/// A point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    /// Where it is, metres.
    pub(super) at: DVec3,
    /// The unit normal of its triangle.
    pub(super) normal: DVec3,
}

/// So many points, each standing for the same area; none where there is no area. The same triangles give the
/// same points.
pub(super) fn spread(triangles: &[Triangle], count: usize) -> Vec<Spot> {
    let total: f64 = triangles.iter().map(area).sum();
    let (mut points, mut passed, mut left) = (Vec::new(), 0.0, triangles.iter());
    let Some(mut at) = left.next().filter(|_| total > 0.0) else { return points };
    for k in 0..count {
        let wanted = total * (k as f64 + 0.5) / count as f64;
        while passed + area(at) < wanted {
            let Some(next) = left.next() else { break };
            passed += area(at);
            at = next;
        }
        let [mut u, mut v] = STEPS.map(|step| (k as f64 * step).fract());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let [a, b, c] = *at;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        points.push(Spot { at: a + (b - a) * u + (c - a) * v, normal });
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_spread_by_area_and_lie_on_their_triangles() {
        let [x, y] = [DVec3::X, DVec3::Y];
        let triangles = [[DVec3::ZERO, x, y], [x * 5.0, x * 8.0, x * 5.0 + y]];
        let points = spread(&triangles, 400);
        let first = points.iter().filter(|p| p.at.x < 2.0).count();
        assert_eq!((points.len(), first), (400, 100));
        assert!(points.iter().all(|p| p.at.z == 0.0 && p.at.y >= 0.0 && p.normal == DVec3::Z));
        assert!(spread(&[], 10).is_empty());
    }
}
