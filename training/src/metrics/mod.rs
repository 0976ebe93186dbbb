//! How good a prediction is: the measures of the paper, read strictly or as the public code of its
//! predecessor computes them.
//!
//! All lengths are those of the unit cube: an object's box is centred on the origin and its longest
//! side is 1. Objects are compared as clouds of 100,000 points. Every measure of parts is half the
//! mean over predicted parts plus half the mean over true ones. A part without a counterpart counts
//! as the worst there is: gIoU −1, IoU 0, Chamfer half the diagonal.

pub mod assign;
pub mod body;
pub mod boxes;
pub mod calibration;
pub mod cloud;
pub mod compare;
pub mod joints;
pub mod moved;
pub mod opening;
pub mod scores;

pub use body::{Body, BodyError, Link, Motion};
pub use compare::{Closeness, Comparer, Comparison, Matched};
pub use joints::{JointComparison, JointScores, compare_joints};
pub use moved::moved_points_giou;
pub use opening::{Opening, OpeningShares};
pub use scores::{Scores, point_ious};

use serde::Serialize;

/// Whose reading of the measures counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rules {
    /// Strict: what the paper's text says. "Fully articulated" is every joint at its upper end.
    /// Boxes move with their own joints, and the box around both is taken after the motion. The
    /// root stands still. A box flatter than [`boxes::THINNEST`] is taken to be that thick.
    #[default]
    Paper,
    /// Lenient: what the predecessor's public code does. The two kinds of figures cannot be
    /// compared.
    ///
    /// - Moved figures are means over five poses.
    /// - Boxes are moved from rest, in one of the two directions by the other object's joints.
    /// - The box around both is the one at rest, so identical boxes moved apart score +1.
    /// - The root moves too.
    /// - A box without volume voids the object's rest gIoU.
    RefCompat,
}

impl Rules {
    /// The poses after rest: shares of each joint's own range.
    pub fn shares(self) -> &'static [f64] {
        match self {
            Self::Paper => &[1.0],
            Self::RefCompat => &[0.0, 0.25, 0.5, 0.75, 1.0],
        }
    }
}

/// Mean of some values; none of none.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0_u32);
    for value in values {
        sum += value;
        count += 1;
    }
    (count > 0).then(|| sum / f64::from(count))
}

#[cfg(test)]
mod tests;
