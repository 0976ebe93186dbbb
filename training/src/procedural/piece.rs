//! A part of an object that always looks the same.

use object::{DVec3, JointMotion, Part, Range};

use super::shapes::Shape;

/// One part of an object in the making.
pub(super) struct Piece {
    pub name: &'static str,
    pub text: &'static str,
    pub material: &'static str,
    pub parent: Option<usize>,
    pub motions: Vec<JointMotion>,
    /// Where a person would point: a point on the surface.
    pub point: DVec3,
    pub shape: Shape,
}

impl Piece {
    /// The part of the tree.
    pub(super) fn part(&self) -> Part {
        Part {
            name: self.name.into(),
            text: self.text.into(),
            parent: self.parent,
            joints: self.motions.iter().map(|m| m.kind).collect(),
        }
    }
}

/// A range with two ends, radians or metres.
pub(super) fn limits(lower: f64, upper: f64) -> Range {
    Range::Limits { lower, upper }
}
