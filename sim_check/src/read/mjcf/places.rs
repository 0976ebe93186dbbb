//! Where an MJCF element stands: a position, and a turn told in one of five ways.

use glamx::{DMat3, DPose3, DQuat, DVec3};

use super::attributes::Element;
use super::model::Model;

impl Model<'_, '_> {
    /// The element's frame in the one around it; a direction that is none is a fault.
    pub(super) fn place(&mut self, element: &Element) -> DPose3 {
        let at = self.vector(element, "pos").unwrap_or(DVec3::ZERO);
        DPose3::from_parts(at, self.turn(element))
    }

    pub(super) fn turn(&mut self, element: &Element) -> DQuat {
        let given = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];
        let Some(way) = given.into_iter().find(|way| element.get(way).is_some()) else {
            return DQuat::IDENTITY;
        };
        let count = [4, 4, 3, 6, 3][given.iter().position(|w| *w == way).unwrap_or(0)];
        let Some(n) = self.numbers(element, way, count) else { return DQuat::IDENTITY };
        let first = DVec3::new(n[0], n[1], n[2]);
        let turn = match way {
            "quat" => unit(DQuat::from_xyzw(n[1], n[2], n[3], n[0])),
            "axisangle" => {
                let axis = first.try_normalize();
                axis.map(|a| DQuat::from_axis_angle(a, n[3] * self.compiler.angle))
            }
            "euler" => Some(self.euler(first)),
            "xyaxes" => from_axes(first, DVec3::new(n[3], n[4], n[5])),
            _ => first.try_normalize().map(|z| DQuat::from_rotation_arc(DVec3::Z, z)),
        };
        turn.unwrap_or_else(|| {
            self.reader.fault(element.node, format!("{way}: has no direction"));
            DQuat::IDENTITY
        })
    }

    fn euler(&self, angles: DVec3) -> DQuat {
        let angles = angles * self.compiler.angle;
        let each = self.compiler.euler.chars().zip(angles.to_array());
        each.fold(DQuat::IDENTITY, |turn, (axis, angle)| {
            let about = match axis.to_ascii_lowercase() {
                'x' => DQuat::from_rotation_x(angle),
                'y' => DQuat::from_rotation_y(angle),
                _ => DQuat::from_rotation_z(angle),
            };
            if axis.is_lowercase() { turn * about } else { about * turn }
        })
    }
}

fn unit(turn: DQuat) -> Option<DQuat> {
    let length = turn.length();
    (length > 1e-9 && length.is_finite()).then(|| turn.normalize())
}

/// The turn whose x axis is the first direction and whose y axis lies nearest the second.
fn from_axes(x: DVec3, y: DVec3) -> Option<DQuat> {
    let x = x.try_normalize()?;
    let y = y.reject_from_normalized(x).try_normalize()?;
    Some(DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))))
}
