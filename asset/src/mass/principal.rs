//! Principal axes of an inertia tensor, for formats that want moments and a turn.

use glamx::{DMat3, DQuat, DVec3};

/// Sweeps after which a 3 × 3 matrix is diagonal to the last bit; six suffice.
const SWEEPS: usize = 12;

/// Principal moments and the turn from the principal axes to the tensor's own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Principal {
    /// Moments along the principal x, y and z.
    pub(crate) moments: DVec3,
    /// Unit quaternion: principal axes to the tensor's axes.
    pub(crate) axes: DQuat,
}

/// The principal moments and axes of a symmetric tensor, by Jacobi's turns: exact for one that is
/// diagonal already, and steady where moments are equal.
pub(crate) fn principal(tensor: DMat3) -> Principal {
    let (mut m, mut axes) = (tensor, DMat3::IDENTITY);
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let turn = annihilating(&m, p, q);
            m = turn.transpose() * m * turn;
            axes *= turn;
        }
    }
    let moments = DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
    Principal { moments, axes: DQuat::from_mat3(&axes).normalize() }
}

/// The turn in the plane of axes p and q that makes the entry (p, q) vanish.
fn annihilating(m: &DMat3, p: usize, q: usize) -> DMat3 {
    let off = m.col(q)[p];
    if off == 0.0 {
        return DMat3::IDENTITY;
    }
    let theta = (m.col(q)[q] - m.col(p)[p]) / (2.0 * off);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let mut columns = DMat3::IDENTITY.to_cols_array_2d();
    (columns[p][p], columns[q][q]) = (c, c);
    (columns[p][q], columns[q][p]) = (-t * c, t * c);
    DMat3::from_cols_array_2d(&columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn back(p: Principal) -> DMat3 {
        let axes = DMat3::from_quat(p.axes);
        axes * DMat3::from_diagonal(p.moments) * axes.transpose()
    }

    fn differ(a: DMat3, b: DMat3) -> f64 {
        let d = a - b;
        d.to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max)
    }

    #[test]
    fn moments_and_axes_make_up_the_tensor_again() {
        let axes = DMat3::from_quat(DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(2.0));
        for moments in [[1.0, 2.0, 2.5], [3e-7, 4e-7, 6e-7], [2.0, 2.0, 3.0], [1.0, 1.0, 1.0]] {
            let moments = DVec3::from_array(moments);
            let tensor = axes * DMat3::from_diagonal(moments) * axes.transpose();
            let tensor = (tensor + tensor.transpose()) * 0.5;
            let found = principal(tensor);
            assert!(differ(back(found), tensor) <= 1e-14 * moments.max_element(), "{found:?}");
            assert!((found.moments.element_sum() - moments.element_sum()).abs() < 1e-14);
        }
    }

    #[test]
    fn a_diagonal_tensor_keeps_its_axes() {
        let found = principal(DMat3::from_diagonal(DVec3::new(3.0, 1.0, 2.0)));
        assert_eq!(found, Principal { moments: DVec3::new(3.0, 1.0, 2.0), axes: DQuat::IDENTITY });
    }
}
