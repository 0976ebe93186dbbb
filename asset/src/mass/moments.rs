//! Volume, centre and second moments of solids and shells, in closed form over triangles.
//!
//! ```
//! use asset::mass::moments::Moments;
//! use object::DVec3;
//! // The corner of a unit cube: a sixth of it, its centre a quarter along each side.
//! let corner = Moments::cone([DVec3::X, DVec3::Y, DVec3::Z]);
//! assert_eq!((corner.measure, corner.centre()), (1.0 / 6.0, DVec3::splat(0.25)));
//! ```

use std::ops::{Add, Mul, Sub};

use glamx::{DMat3, DSymmetricEigen3, DVec3};

/// Zeroth, first and second moment of some uniform stuff about the origin: the measure ∫1 (m³ of a
/// solid, m² of a shell), ∫x and ∫x·xᵀ. Moments of disjoint bodies add.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// ∫1: volume m³ or area m².
    pub measure: f64,
    /// ∫x.
    pub first: DVec3,
    /// ∫x·xᵀ, symmetric.
    pub second: DMat3,
}

/// The matrix a·bᵀ.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

impl Moments {
    /// Nothing at all.
    pub const ZERO: Self = Self { measure: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };

    /// The solid tetrahedron from the origin to a triangle; negative when the triangle, seen from
    /// the origin, is clockwise. Summed over a closed surface these give the solid inside.
    pub fn cone([a, b, c]: [DVec3; 3]) -> Self {
        let measure = a.dot(b.cross(c)) / 6.0;
        let sum = a + b + c;
        let squares = outer(a, a) + outer(b, b) + outer(c, c) + outer(sum, sum);
        Self { measure, first: sum * (measure / 4.0), second: squares * (measure / 20.0) }
    }

    /// A thin triangle, by area.
    pub fn sheet([a, b, c]: [DVec3; 3]) -> Self {
        let measure = (b - a).cross(c - a).length() / 2.0;
        let sum = a + b + c;
        let squares = outer(a, a) + outer(b, b) + outer(c, c) + outer(sum, sum);
        Self { measure, first: sum * (measure / 3.0), second: squares * (measure / 12.0) }
    }

    /// The same stuff moved by `offset`.
    #[must_use]
    pub fn moved(&self, offset: DVec3) -> Self {
        let cross = outer(self.first, offset);
        let second = self.second + cross + cross.transpose() + outer(offset, offset) * self.measure;
        Self { measure: self.measure, first: self.first + offset * self.measure, second }
    }

    /// Centre of mass; not finite when the measure is zero.
    pub fn centre(&self) -> DVec3 {
        self.first / self.measure
    }

    /// Covariance ⟨(x−c)(x−c)ᵀ⟩ about the centre, m²: inertia per kilogram in another guise.
    pub fn covariance(&self) -> DMat3 {
        let c = self.centre();
        let raw = self.second * (1.0 / self.measure) - outer(c, c);
        (raw + raw.transpose()) * 0.5
    }
}

impl Add for Moments {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let (first, second) = (self.first + o.first, self.second + o.second);
        Self { measure: self.measure + o.measure, first, second }
    }
}

impl Sub for Moments {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + o * -1.0
    }
}

impl Mul<f64> for Moments {
    type Output = Self;
    fn mul(self, k: f64) -> Self {
        Self { measure: self.measure * k, first: self.first * k, second: self.second * k }
    }
}

impl std::iter::Sum for Moments {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::ZERO, Add::add)
    }
}

/// Inertia tensor about the centre, kg·m², of `mass` kilograms spread with this covariance.
pub fn inertia_of(covariance: DMat3, mass: f64) -> DMat3 {
    let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
    (DMat3::from_diagonal(DVec3::splat(trace)) - covariance) * mass
}

/// A covariance whose smallest eigenvalue is at least `floor`: enough is added on every axis.
///
/// The triangle inequality of inertia, A + B ≥ C, says just that no eigenvalue of the covariance is
/// negative; a floor above zero keeps a margin for rounding and makes flat sheets acceptable.
pub fn floored(covariance: DMat3, floor: f64) -> DMat3 {
    let smallest = DSymmetricEigen3::eigenvalues(covariance).min_element();
    let lift = (floor - smallest).max(0.0);
    covariance + DMat3::from_diagonal(DVec3::splat(lift))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{block, cylinder};
    use object::Mesh;

    fn solid(mesh: &Mesh) -> Moments {
        (0..mesh.faces().len()).map(|f| Moments::cone(mesh.corners(f))).sum()
    }

    fn shell(mesh: &Mesh) -> Moments {
        (0..mesh.faces().len()).map(|f| Moments::sheet(mesh.corners(f))).sum()
    }

    fn diagonal(m: DMat3) -> DVec3 {
        DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z)
    }

    #[test]
    fn a_solid_block_has_its_textbook_inertia_wherever_it_stands() {
        let (size, centre) = (DVec3::new(0.3, 0.5, 0.7), DVec3::new(11.0, -3.0, 5.0));
        let m = solid(&block(size, centre)).moved(-centre).moved(centre);
        assert!((m.measure - 0.105).abs() < 1e-12);
        assert!((m.centre() - centre).length() < 1e-11);
        let inertia = inertia_of(m.covariance(), 12.0);
        let expected = DVec3::new(0.25 + 0.49, 0.09 + 0.49, 0.09 + 0.25);
        assert!((diagonal(inertia) - expected).length() < 1e-10, "{inertia}");
    }

    #[test]
    fn a_cubic_shell_has_five_thirds_of_the_solids_inertia() {
        let cube = block(DVec3::ONE, DVec3::ZERO);
        let inertia = diagonal(inertia_of(shell(&cube).covariance(), 6.0));
        assert!((shell(&cube).measure - 6.0).abs() < 1e-14);
        assert!((inertia - DVec3::splat(5.0 / 3.0)).length() < 1e-13, "{inertia}");
    }

    #[test]
    fn a_hollow_block_is_the_outer_less_the_inner() {
        let hollow =
            solid(&block(DVec3::ONE, DVec3::ZERO)) - solid(&block(DVec3::splat(0.5), DVec3::ZERO));
        assert!((hollow.measure - 0.875).abs() < 1e-14);
        let expected = (1.0 - 0.5_f64.powi(5)) / 12.0 * 2.0;
        assert!((inertia_of(hollow.second, 1.0).x_axis.x - expected).abs() < 1e-14);
    }

    #[test]
    fn a_fine_cylinder_tends_to_half_m_r_squared() {
        let c = solid(&cylinder(0.2, 0.6, 97));
        let inertia = inertia_of(c.covariance(), 3.0);
        assert!((inertia.z_axis.z / (1.5 * 0.04) - 1.0).abs() < 2e-3);
        assert!((inertia.x_axis.x / (3.0 * (3.0 * 0.04 + 0.36) / 12.0) - 1.0).abs() < 2e-3);
    }

    #[test]
    fn a_flat_sheet_gets_a_thickness() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let flat = Moments::sheet(corners).covariance();
        let inertia = diagonal(inertia_of(floored(flat, 1e-4), 1.0));
        assert!(inertia.x + inertia.y - inertia.z > 1e-4, "{inertia}");
    }
}
