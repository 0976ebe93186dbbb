//! How one ensemble of segments is fitted, as a recipe says.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::super::recipe::{Families, counted};
use crate::forest::Growth;
use crate::fuse;

/// How one ensemble is fitted.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ensemble {
    /// At most so many objects of the shards; all where it is not given.
    #[serde(default)]
    pub objects: Option<usize>,
    /// How often each object is drawn, of each way to fuse it.
    #[serde(default = "once")]
    pub draws: u64,
    /// How often each object is drawn cut up, beside how often it is as it is.
    #[serde(default)]
    pub cut: u64,
    /// The ways to fuse it; none where objects are seen as they are.
    #[serde(default)]
    pub fused: Vec<fuse::Recipe>,
    /// Whether what is fused is the object as it moves, not the object at rest.
    #[serde(default)]
    pub posed: bool,
    /// Objects of our own families.
    #[serde(default)]
    pub families: Families,
    /// How often each of those is drawn; as often as the others where it is not given.
    #[serde(default)]
    pub own_draws: Option<u64>,
    /// Whether anything is learned of which neighbours are of one part.
    pub pairwise: bool,
    /// How many folds there are: each is fitted without another share of the objects.
    pub folds: usize,
    /// For how many rounds it is fitted.
    pub rounds: usize,
    /// Into how many ensembles of the pack the folds are split, in order.
    #[serde(default = "whole")]
    pub split: usize,
    /// How trees grow.
    pub growth: Growth,
}

fn once() -> u64 {
    1
}

fn whole() -> usize {
    1
}

/// Metrics by name, as they stand in a pack.
pub(crate) type Metrics = BTreeMap<String, f64>;

impl Ensemble {
    pub(super) fn check(&self) -> Result<(), String> {
        counted("folds", self.folds, [2, 64])?;
        counted("rounds", self.rounds, [1, 16])?;
        counted("draws", self.draws as usize, [1, 64])?;
        counted("split", self.split, [1, self.folds])?;
        if !self.folds.is_multiple_of(self.split) {
            let (folds, split) = (self.folds, self.split);
            return Err(format!(
                "`folds` must be a multiple of `split`, found {folds} and {split}"
            ));
        }
        if self.posed && self.fused.is_empty() {
            return Err("`posed` needs a way in `fused`, found none".into());
        }
        if self.cut > 0 && !self.fused.is_empty() {
            return Err(
                "`cut` must be 0 where `fused` is given: what is cut up is not fused".into()
            );
        }
        self.growth.check().map_err(|what| format!("growth: {what}"))
    }
}
