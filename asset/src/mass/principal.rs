//! Principal axes of an inertia tensor, for formats that want moments and a turn.

use glamx::{DMat3, DQuat, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};

/// Most steps of the decomposition; ten suffice, and what is not finite never ends.
const MAX_STEPS: usize = 200;

/// Principal moments and the turn from the principal axes to the tensor's own axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Principal {
    /// Moments along the principal x, y and z.
    pub(crate) moments: DVec3,
    /// Unit quaternion: principal axes to the tensor's axes.
    pub(crate) axes: DQuat,
}

/// The principal moments and axes of a symmetric tensor: exact for one that is diagonal already,
/// and with each axis under the name of the one it is nearest to.
pub(crate) fn principal(tensor: DMat3) -> Principal {
    let own = Principal {
        moments: DVec3::new(tensor.x_axis.x, tensor.y_axis.y, tensor.z_axis.z),
        axes: DQuat::IDENTITY,
    };
    let beside = DVec3::new(tensor.x_axis.y, tensor.x_axis.z, tensor.y_axis.z);
    let symmetric = Matrix3::from(tensor.to_cols_array_2d());
    if beside == DVec3::ZERO {
        return own;
    }
    SymmetricEigen::try_new(symmetric, f64::EPSILON, MAX_STEPS).map_or(own, |found| {
        let axes: [[f64; 3]; 3] = found.eigenvectors.into();
        nearest(found.eigenvalues.into(), axes.map(DVec3::from_array))
    })
}

/// Moments and axes in the order and the sense in which the axes are nearest to x, y and z.
fn nearest(moments: [f64; 3], axes: [DVec3; 3]) -> Principal {
    const ORDERS: [[usize; 3]; 6] =
        [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let near = |order: &[usize; 3]| (0..3).map(|i| axes[order[i]][i].abs()).sum::<f64>();
    let [x, y, z] = ORDERS.into_iter().fold(ORDERS[0], |best, order| {
        if near(&order) > near(&best) + f64::EPSILON { order } else { best }
    });
    let first = axes[x] * axes[x].x.signum();
    let second = axes[y] * axes[y].y.signum();
    let turn = DMat3::from_cols(first, second, first.cross(second));
    let moments = DVec3::new(moments[x], moments[y], moments[z]);
    Principal { moments, axes: DQuat::from_mat3(&turn).normalize() }
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
