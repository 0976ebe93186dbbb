//! Labels the parts of a mesh and finds their joints without a neural network over the whole
//! object.
//!
//! The surface is cut into segments, each segment is given to a part, and each joint is chosen
//! among a few candidate axes. What is learned (boosted trees, tables, one small network for axes)
//! ships inside the program as packs. Lengths inside are shares of the object's diagonal.

pub mod confidence;
pub mod joints;
mod kept;
pub mod learned;
pub mod lexicon;
mod packs;
pub mod prepared;
pub mod segment;

use object::{Condition, Mesh};

use crate::articulate::{Articulate, ArticulateError, Articulation};
#[cfg(test)]
use crate::classic::kept::{Kept, keep};
use crate::classic::packs::learned;
pub use crate::classic::packs::{check, digests};
#[cfg(test)]
use crate::classic::prepared::HYPOTHESES;
use crate::classic::prepared::Prepared;
use crate::classic::segment::Way;
use crate::classic::segment::classify;

/// Labels by merging along evidence, joints by candidate axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Geometric;

impl Articulate for Geometric {
    fn identity(&self) -> String {
        format!("geometric/19 {}", learned(|pack| !of_labels_alone(pack)))
    }

    fn articulate(
        &self,
        mesh: &Mesh,
        condition: &Condition,
        seed: u64,
    ) -> Result<Articulation, ArticulateError> {
        condition.check_points(mesh)?;
        Ok(Prepared::new(mesh)?.articulated(condition, seed, Way::Merging)?.articulation)
    }
}

/// Whether labels by merging follow from nothing in this pack.
fn of_labels_alone(pack: &str) -> bool {
    pack.starts_with(classify::KIND) || pack == confidence::KIND
}

/// Labels by trees that ask every segment about every part, joints by candidate axes: what is used where
/// nobody chooses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hybrid;

impl Articulate for Hybrid {
    fn identity(&self) -> String {
        format!("hybrid/24 {}", learned(|_| true))
    }

    fn articulate(
        &self,
        mesh: &Mesh,
        condition: &Condition,
        seed: u64,
    ) -> Result<Articulation, ArticulateError> {
        condition.check_points(mesh)?;
        Ok(Prepared::new(mesh)?.articulate(condition, seed)?.0)
    }
}

#[cfg(test)]
mod identity {
    use super::*;

    /// The tables of roles, contacts and sizes stood in the source, whose digest is part of every key.
    #[test]
    fn every_pack_that_labels_and_joints_follow_from_is_in_the_identity() {
        let all: Vec<&str> = digests().into_keys().collect();
        let packs =
            "axes confidence contacts fused_unary ranges roles segments segments_fused sizes";
        assert_eq!(all.join(" "), packs);
        assert_eq!(Hybrid.identity(), format!("hybrid/24 {}", learned(|_| true)));
        for left_out in &all {
            assert_ne!(learned(|pack| pack != *left_out), learned(|_| true), "{left_out}");
        }
        let geometric =
            learned(|pack| !["confidence", "segments", "segments_fused"].contains(&pack));
        assert_eq!(Geometric.identity(), format!("geometric/19 {geometric}"));
    }
}

#[cfg(test)]
mod corrected;
#[cfg(test)]
mod golden;
#[cfg(test)]
mod tests;
