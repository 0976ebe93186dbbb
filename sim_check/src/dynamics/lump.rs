//! Mass, centre of mass and inertia of links taken together, by the textbook: the closed form that
//! the physics engine is held against.

use glamx::{DMat3, DPose3, DVec3};

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
    pub fn of_links(
        robot: &Robot,
        links: impl Iterator<Item = usize>,
        poses: &[DPose3],
    ) -> Self {
        links.fold(Self::EMPTY, |sum, l| sum.with(Self::of_link(robot, l, &poses[l])))
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
