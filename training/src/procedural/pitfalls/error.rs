//! Why an object of a kind cannot be made.

use object::posed::PoseError;

use super::super::error::FamilyError;
use crate::fuse::FuseError;

/// Why an object of a kind cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PitfallError {
    /// Its parts make no object.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// It cannot be shown open.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// It makes no skin.
    #[error(transparent)]
    Fuse(#[from] FuseError),
    /// What is to be opened has no joint.
    #[error("part {0} has no joint, so it cannot be shown open")]
    NoJoint(usize),
    /// Parts no face of the skin belongs to.
    #[error("only {left} of {parts} parts can be seen from outside")]
    Hidden {
        /// Parts that are left.
        left: usize,
        /// Parts there were.
        parts: usize,
    },
}
