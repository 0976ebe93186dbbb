//! Volume, centre and inertia of surfaces, as solids and as shells, and principal moments.

use glamx::{DMat3, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};
use object::Mesh;

/// Most steps of a decomposition; ten suffice, and what is not finite never ends.
const MAX_STEPS: usize = 200;

/// Zeroth, first and second moments of a body of density (or area density) 1.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    /// m³ or m².
    pub measure: f64,
    /// Integral of position.
    first: DVec3,
    /// Integral of x·xᵀ.
    second: DMat3,
}

impl Moments {
    /// Of the solid a closed surface encloses (sum of signed tetrahedra).
    pub(crate) fn solid(mesh: &Mesh) -> Self {
        let origin = mesh.corners(0)[0];
        let mut sum = Self::none();
        for face in 0..mesh.faces().len() {
            let [a, b, c] = mesh.corners(face).map(|p| p - origin);
            let volume = a.dot(b.cross(c)) / 6.0;
            let total = a + b + c;
            let squares = outer(a) + outer(b) + outer(c) + outer(total);
            sum.add(volume, total / 4.0 * volume, squares * (volume / 20.0));
        }
        sum.moved(origin)
    }

    /// Of the tetrahedra of a point with every face, none of them negative.
    pub(crate) fn unsigned(mesh: &Mesh, point: DVec3) -> Self {
        let mut sum = Self::none();
        for face in 0..mesh.faces().len() {
            let [a, b, c] = mesh.corners(face).map(|p| p - point);
            let volume = (a.dot(b.cross(c)) / 6.0).abs();
            let total = a + b + c;
            let squares = outer(a) + outer(b) + outer(c) + outer(total);
            sum.add(volume, total / 4.0 * volume, squares * (volume / 20.0));
        }
        sum.moved(point)
    }

    /// Of the surface itself as a thin shell.
    pub(crate) fn shell(mesh: &Mesh) -> Self {
        let origin = mesh.corners(0)[0];
        let mut sum = Self::none();
        for face in 0..mesh.faces().len() {
            let [a, b, c] = mesh.corners(face).map(|p| p - origin);
            let area = mesh.area(face);
            let total = a + b + c;
            let squares = outer(a) + outer(b) + outer(c) + outer(total);
            sum.add(area, total / 3.0 * area, squares * (area / 12.0));
        }
        sum.moved(origin)
    }

    /// Nothing.
    pub(crate) fn none() -> Self {
        Self { measure: 0.0, first: DVec3::ZERO, second: DMat3::ZERO }
    }

    /// Both bodies together.
    pub(crate) fn plus(mut self, other: &Self) -> Self {
        self.add(other.measure, other.first, other.second);
        self
    }

    fn add(&mut self, measure: f64, first: DVec3, second: DMat3) {
        self.measure += measure;
        self.first += first;
        self.second += second;
    }

    fn moved(self, by: DVec3) -> Self {
        let cross = outer_of(self.first, by) + outer_of(by, self.first);
        let second = self.second + cross + outer(by) * self.measure;
        Self { first: self.first + by * self.measure, second, ..self }
    }

    /// Centre, m, and inertia about it for a mass of 1 kg, m².
    pub(crate) fn per_kilogram(&self) -> Option<(DVec3, DMat3)> {
        if self.measure <= 0.0 {
            return None;
        }
        let centre = self.first / self.measure;
        let spread = self.second * (1.0 / self.measure) + outer(centre) * -1.0;
        let trace = spread.col(0).x + spread.col(1).y + spread.col(2).z;
        Some((centre, DMat3::IDENTITY * trace + spread * -1.0))
    }

    /// Inertia about a point for a mass of 1 kg, m².
    pub(crate) fn per_kilogram_about(&self, point: DVec3) -> Option<DMat3> {
        if self.measure <= 0.0 {
            return None;
        }
        let spread = self.moved(-point).second * (1.0 / self.measure);
        let trace = spread.col(0).x + spread.col(1).y + spread.col(2).z;
        Some(DMat3::IDENTITY * trace + spread * -1.0)
    }

    /// Principal moments of inertia about the body's own centre for a mass of 1 kg, ascending, m².
    pub(crate) fn principal_per_kilogram(&self) -> Option<DVec3> {
        self.per_kilogram().map(|(_, inertia)| principal(inertia))
    }
}

fn outer(a: DVec3) -> DMat3 {
    outer_of(a, a)
}

fn outer_of(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Eigenvalues of a symmetric matrix, ascending; of a diagonal matrix exactly its entries.
pub(crate) fn principal(matrix: DMat3) -> DVec3 {
    let [[a, b, c], [_, d, e], [_, _, f]] = matrix.to_cols_array_2d();
    let on_axes = [b, c, e] == [0.0; 3];
    let found = if on_axes { None } else { principal_axes(matrix) };
    let mut values = found.map_or([a, d, f], |(moments, _)| moments.to_array());
    values.sort_by(f64::total_cmp);
    DVec3::from_array(values)
}

/// Eigenvalues of a symmetric matrix and the turn whose columns are their axes. `None` if it has an
/// entry that is not finite or so large that its square is not.
pub(crate) fn principal_axes(matrix: DMat3) -> Option<(DVec3, DMat3)> {
    let symmetric = Matrix3::from(matrix.to_cols_array_2d());
    let found = SymmetricEigen::try_new(symmetric, f64::EPSILON, MAX_STEPS)?;
    let values = DVec3::from_array(found.eigenvalues.into());
    let axes = DMat3::from_cols_array_2d(&found.eigenvectors.into());
    let turn = if axes.determinant() < 0.0 { axes * -1.0 } else { axes };
    (values.is_finite() && turn.is_finite()).then_some((values, turn))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tessellate::tessellated;
    use crate::robot::Geometry;

    fn cuboid() -> Mesh {
        tessellated(&Geometry::Box { size: DVec3::new(1.0, 2.0, 3.0) })
            .unwrap()
            .map_vertices(|v| v + DVec3::new(5.0, -7.0, 11.0))
            .unwrap()
    }

    #[test]
    fn a_solid_box_has_the_textbook_moments_wherever_it_stands() {
        let m = Moments::solid(&cuboid());
        assert!((m.measure - 6.0).abs() < 1e-12);
        let expected = DVec3::new(1.0 + 4.0, 1.0 + 9.0, 4.0 + 9.0) / 12.0;
        assert!((m.principal_per_kilogram().unwrap() - expected).length() < 1e-11);
    }

    #[test]
    fn a_spherical_shell_has_two_thirds_and_a_ball_two_fifths_of_m_r_squared() {
        let ball = tessellated(&Geometry::Sphere { radius: 1.0 }).unwrap();
        let shell = Moments::shell(&ball).principal_per_kilogram().unwrap();
        let solid = Moments::solid(&ball).principal_per_kilogram().unwrap();
        assert!((shell / (2.0 / 3.0) - DVec3::ONE).length() < 0.03, "{shell}");
        assert!((solid / 0.4 - DVec3::ONE).length() < 0.03, "{solid}");
    }

    #[test]
    fn eigenvalues_of_a_turned_matrix_are_those_of_the_diagonal_one() {
        let turn = DMat3::from_euler(glamx::EulerRot::XYZ, 0.3, 0.7, -1.1);
        let turned = turn * DMat3::from_diagonal(DVec3::new(3.0, 1.0, 2.0)) * turn.transpose();
        assert!((principal(turned) - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-14);
        let edge = DMat3::from_diagonal(DVec3::new(0.087, 0.06, 0.027));
        assert_eq!(principal(edge), DVec3::new(0.027, 0.06, 0.087));
    }
}
