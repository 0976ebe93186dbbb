//! Weight, mean and spread of a heap of points or triangles, and the axes of that spread.

use object::DVec3;

/// Zeroth to second moments; they add.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Total weight.
    pub weight: f64,
    /// Weighted sum of positions.
    pub first: DVec3,
    /// Weighted sums of xx, yy, zz, xy, yz, zx.
    pub second: [f64; 6],
}

impl Moments {
    /// A point.
    pub fn point(p: DVec3, weight: f64) -> Self {
        Self { weight, first: p * weight, second: products(p).map(|s| s * weight) }
    }

    /// A triangle, weighted by its area.
    pub fn triangle(corners: [DVec3; 3], area: f64) -> Self {
        let sum = corners[0] + corners[1] + corners[2];
        let mut second = products(sum);
        for corner in corners {
            second.iter_mut().zip(products(corner)).for_each(|(s, p)| *s += p);
        }
        Self { weight: area, first: sum * (area / 3.0), second: second.map(|s| s * area / 12.0) }
    }

    /// Adds `share` of another heap.
    pub fn add(&mut self, other: &Self, share: f64) {
        self.weight += other.weight * share;
        self.first += other.first * share;
        self.second.iter_mut().zip(other.second).for_each(|(s, o)| *s += o * share);
    }

    /// Weighted mean position; the origin for an empty heap.
    pub fn mean(&self) -> DVec3 {
        if self.weight > 0.0 { self.first / self.weight } else { DVec3::ZERO }
    }

    /// Standard deviations along the axes of the spread, largest first.
    pub fn deviations(&self) -> [f64; 3] {
        if self.weight <= 0.0 {
            return [0.0; 3];
        }
        let of_mean = products(self.mean());
        let mut covariance = self.second.map(|s| s / self.weight);
        covariance.iter_mut().zip(of_mean).for_each(|(c, m)| *c -= m);
        eigenvalues(covariance).map(|v| v.max(0.0).sqrt())
    }
}

fn products(p: DVec3) -> [f64; 6] {
    [p.x * p.x, p.y * p.y, p.z * p.z, p.x * p.y, p.y * p.z, p.z * p.x]
}

/// Eigenvalues of the symmetric matrix with diagonal xx, yy, zz and xy, yz, zx beside it, largest
/// first; in closed form, by the angle of its characteristic cubic.
pub fn eigenvalues([xx, yy, zz, xy, yz, zx]: [f64; 6]) -> [f64; 3] {
    let mean = (xx + yy + zz) / 3.0;
    let (a, b, c) = (xx - mean, yy - mean, zz - mean);
    let beside = xy * xy + yz * yz + zx * zx;
    let size = ((a * a + b * b + c * c + 2.0 * beside) / 6.0).sqrt();
    if size <= f64::MIN_POSITIVE {
        return [mean; 3];
    }
    let determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * zx) + zx * (xy * yz - b * zx);
    let angle = (determinant / (2.0 * size.powi(3))).clamp(-1.0, 1.0).acos() / 3.0;
    let third = std::f64::consts::TAU / 3.0;
    let largest = mean + 2.0 * size * angle.cos();
    let smallest = mean + 2.0 * size * (angle + third).cos();
    [largest, 3.0 * mean - largest - smallest, smallest]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_spreads_by_its_side_over_the_root_of_twelve() {
        let corner = |x: f64, y: f64| DVec3::new(3.0 + 2.0 * x, 5.0 + 2.0 * y, 7.0);
        let mut square = Moments::default();
        for third in [corner(1.0, 0.0), corner(0.0, 1.0)] {
            square.add(&Moments::triangle([corner(0.0, 0.0), corner(1.0, 1.0), third], 2.0), 1.0);
        }
        assert!((square.mean() - corner(0.5, 0.5)).length() < 1e-12);
        let side = 2.0 / 12f64.sqrt();
        let found = square.deviations();
        assert!((found[0] - side).abs() < 1e-7 && (found[1] - side).abs() < 1e-7);
        assert!(found[2] < 1e-6);
    }

    #[test]
    fn eigenvalues_of_a_turned_matrix_are_those_of_the_diagonal_one() {
        let (s, c) = 0.7f64.sin_cos();
        let [p, q, r] = [5.0, 2.0, 0.5];
        let found = eigenvalues([
            p * c * c + q * s * s,
            p * s * s + q * c * c,
            r,
            (p - q) * s * c,
            0.0,
            0.0,
        ]);
        assert!(found.iter().zip([p, q, r]).all(|(f, t)| (f - t).abs() < 1e-12), "{found:?}");
        assert_eq!(eigenvalues([2.0, 2.0, 2.0, 0.0, 0.0, 0.0]), [2.0; 3]);
    }
}
