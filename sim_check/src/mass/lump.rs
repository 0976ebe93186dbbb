//! Mass, centre of mass and inertia of links taken together, by the textbook: the closed form that
//! the physics engine is held against.
//!
//! ```
//! use object::{DMat3, DVec3};
//! use sim_check::mass::lump::Lump;
//! let at = |x| Lump { mass: 1.0, com: DVec3::X * x, inertia: DMat3::ZERO };
//! let both = at(0.0).with(at(2.0));
//! assert_eq!((both.mass, both.com.x, both.about(both.com, DVec3::Z)), (2.0, 1.0, 2.0));
//! ```

use glamx::{DMat3, DPose3, DQuat, DVec3};

use crate::mass::inertia::principal_axes;
use crate::robot::Robot;

/// Links taken as one rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lump {
    /// kg.
    pub mass: f64,
    /// Centre of mass, metres.
    pub com: DVec3,
    /// Inertia about the centre of mass, kg·m², in the axes of the frame it is expressed in.
    pub inertia: DMat3,
}

impl Lump {
    /// Nothing at all.
    pub const EMPTY: Self = Self { mass: 0.0, com: DVec3::ZERO, inertia: DMat3::ZERO };

    /// Mass and inertia of one link whose frame stands at `pose`; empty if it has none.
    pub fn of_link(robot: &Robot, link: usize, pose: &DPose3) -> Self {
        let Some(inertial) = robot.links[link].inertial else { return Self::EMPTY };
        let at = *pose * inertial.origin;
        let turn = DMat3::from_quat(at.rotation);
        let inertia = turn * inertial.inertia * turn.transpose();
        Self { mass: inertial.mass, com: at.translation, inertia }
    }

    /// Both together.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let mass = self.mass + other.mass;
        if mass <= 0.0 {
            return Self { mass, ..self };
        }
        let com = (self.com * self.mass + other.com * other.mass) / mass;
        let shifted = |l: &Self| l.inertia + steiner(l.mass, l.com - com);
        Self { mass, com, inertia: shifted(&self) + shifted(&other) }
    }

    /// Several links at their poses as one body.
    pub fn of_links(robot: &Robot, links: impl Iterator<Item = usize>, poses: &[DPose3]) -> Self {
        links.fold(Self::EMPTY, |sum, l| sum.with(Self::of_link(robot, l, &poses[l])))
    }

    /// Principal moments, kg·m², and the turn that takes their axes to the lump's.
    ///
    /// By `nalgebra`, for any size and for equal moments. The engine's own decomposition (glamx 0.3.1,
    /// behind `MassProperties::with_inertia_matrix`) takes x for an axis when moments are small or
    /// the two smallest are equal: a wheel on x gets the inertia of a wheel on z.
    pub fn principal(&self) -> (DVec3, DQuat) {
        let Some((moments, axes)) = principal_axes(self.inertia) else {
            let m = self.inertia;
            return (DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z), DQuat::IDENTITY);
        };
        (moments, DQuat::from_mat3(&axes).normalize())
    }

    /// Moment of inertia about a line through `pivot` along a unit `axis`, kg·m².
    pub fn about(&self, pivot: DVec3, axis: DVec3) -> f64 {
        let arm = (self.com - pivot).reject_from_normalized(axis);
        axis.dot(self.inertia * axis) + self.mass * arm.length_squared()
    }

    /// Whether a body of this mass can be simulated.
    pub fn is_sound(&self) -> bool {
        let smallest = self.inertia.to_cols_array_2d();
        let diagonal = [smallest[0][0], smallest[1][1], smallest[2][2]];
        let positive = diagonal.iter().all(|d| *d > 0.0) && self.mass > 0.0;
        positive && self.com.is_finite() && self.inertia.is_finite() && self.mass.is_finite()
    }
}

/// What moving a point mass off the centre adds to the inertia.
fn steiner(mass: f64, by: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(by * by.x, by * by.y, by * by.z);
    (DMat3::from_diagonal(DVec3::splat(by.length_squared())) - outer) * mass
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rebuilt(lump: &Lump) -> DMat3 {
        let (moments, turn) = lump.principal();
        let axes = DMat3::from_quat(turn);
        axes * DMat3::from_diagonal(moments) * axes.transpose()
    }

    #[test]
    fn principal_moments_are_right_however_small_or_equal() {
        let tilt = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.1));
        let wheel = DVec3::new(5.0, 1.0, 1.0);
        for (size, moments, turn) in [
            (1.0, wheel, DMat3::IDENTITY),
            (1e-7, wheel, tilt),
            (1e-6, DVec3::new(1.0, 2.0, 2.5), tilt),
            (1e4, DVec3::new(3.0, 3.0, 3.0), tilt),
            (1e-4, DVec3::new(2.417, 4.167, 2.417), DMat3::from_rotation_z(1.57)),
        ] {
            let inertia = turn * DMat3::from_diagonal(moments * size) * turn.transpose();
            let lump = Lump { mass: 1.0, com: DVec3::ZERO, inertia };
            assert!((rebuilt(&lump) - inertia).abs_diff_eq(DMat3::ZERO, 1e-12 * size), "{moments}");
        }
    }

    #[test]
    fn two_half_rods_are_one_rod() {
        let half = |x: f64| Lump {
            mass: 0.5,
            com: DVec3::new(x, 0.0, 0.0),
            inertia: DMat3::from_diagonal(DVec3::new(0.0, 1.0, 1.0) * 0.5 * 0.25 / 12.0),
        };
        let rod = half(0.25).with(half(0.75));
        assert!((rod.com - DVec3::new(0.5, 0.0, 0.0)).length() < 1e-15);
        assert!((rod.about(DVec3::ZERO, DVec3::Y) - 1.0 / 3.0).abs() < 1e-15);
        assert!((rod.inertia.y_axis.y - 1.0 / 12.0).abs() < 1e-15);
    }
}
