//! A loop of points in space cut into triangles: ears clipped in the plane it lies nearest to.

use glamx::{DVec2, DVec3};

/// Longest loop that is clipped ear by ear; longer ones become a fan.
const LONGEST: usize = 3000;

/// Triangles over a loop of at least three points, as indices into it, walking it as it goes.
///
/// The ear with the widest smallest angle goes first. A loop that crosses itself when flattened
/// may run out of ears; then its roundest corner is cut off, so that there are always two
/// triangles fewer than points.
pub(crate) fn triangles(points: &[DVec3]) -> Vec<[usize; 3]> {
    let count = points.len();
    if count < 3 {
        return Vec::new();
    }
    if count > LONGEST {
        return (1..count - 1).map(|i| [0, i, i + 1]).collect();
    }
    let flat = flattened(points);
    let mut left: Vec<usize> = (0..count).collect();
    let mut grades: Vec<f64> = (0..count).map(|i| grade(&flat, &left, i)).collect();
    let mut found = Vec::with_capacity(count - 2);
    while left.len() > 3 {
        let n = left.len();
        let best = (0..n).max_by(|&a, &b| grades[a].total_cmp(&grades[b])).unwrap_or(0);
        found.push([left[(best + n - 1) % n], left[best], left[(best + 1) % n]]);
        left.remove(best);
        grades.remove(best);
        let n = n - 1;
        for touched in [(best + n - 1) % n, best % n] {
            grades[touched] = grade(&flat, &left, touched);
        }
    }
    found.push([left[0], left[1], left[2]]);
    found
}

/// The points in the plane of the loop, so that it goes round counter-clockwise.
fn flattened(points: &[DVec3]) -> Vec<DVec2> {
    let next = points.iter().cycle().skip(1);
    let normal = points.iter().zip(next).map(|(a, b)| a.cross(*b)).sum::<DVec3>();
    let normal = normal.try_normalize().unwrap_or(DVec3::Z);
    let (u, v) = normal.any_orthonormal_pair();
    let sense = if u.cross(v).dot(normal) < 0.0 { -v } else { v };
    points.iter().map(|p| DVec2::new(p.dot(u), p.dot(sense))).collect()
}

/// How good an ear the corner at `i` makes: the sine of its smallest angle; below 0 where it
/// turns the wrong way, and 2 less where another corner lies in it.
fn grade(flat: &[DVec2], left: &[usize], i: usize) -> f64 {
    let n = left.len();
    let [a, b, c] = [(i + n - 1) % n, i, (i + 1) % n].map(|k| flat[left[k]]);
    let twice = (b - a).perp_dot(c - b);
    let sides = [(b - a).length(), (c - b).length(), (a - c).length()];
    let longest = sides.into_iter().fold(0.0, f64::max);
    let product = sides.iter().product::<f64>() / longest.max(f64::MIN_POSITIVE);
    let shape = if product > 0.0 { twice / (product.max(longest * longest)) } else { -1.0 };
    let inside = |&p: &usize| {
        let p = flat[p];
        let apart = p != a && p != b && p != c;
        let sides = [(a, b), (b, c), (c, a)];
        apart && sides.iter().all(|(s, t)| (*t - *s).perp_dot(p - *s) >= 0.0)
    };
    if shape > 0.0 && left.iter().any(inside) { shape - 2.0 } else { shape }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[DVec3], faces: &[[usize; 3]]) -> f64 {
        let one = |[a, b, c]: &[usize; 3]| {
            (points[*b] - points[*a]).cross(points[*c] - points[*a]).z / 2.0
        };
        faces.iter().map(one).sum()
    }

    #[test]
    fn an_l_is_covered_once_and_nowhere_else() {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let points = corners.map(|[x, y]| DVec3::new(x, y, 0.0));
        let faces = triangles(&points);
        assert_eq!((faces.len(), area(&points, &faces)), (4, 4.0));
        let signed = |f: &[usize; 3]| area(&points, &[*f]);
        assert!(faces.iter().all(|f| signed(f) > 0.0), "{faces:?}");
    }

    #[test]
    fn every_loop_becomes_two_triangles_fewer_than_points() {
        let eight = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [-1.0, 1.0]];
        let points = eight.map(|[x, y]| DVec3::new(x, y, 0.1 * x));
        assert_eq!(triangles(&points).len(), 3);
        assert!(triangles(&points[..2]).is_empty());
        let line: Vec<_> = (0..5).map(|i| DVec3::X * f64::from(i)).collect();
        assert_eq!(triangles(&line).len(), 3);
    }
}
