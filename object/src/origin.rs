//! Where a number comes from; every number in an asset carries one of these.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The five ways a number may enter an asset.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    /// Computed from the geometry at hand.
    Measured,
    /// Predicted by the articulation model.
    Model,
    /// Answered by a vision-language model.
    Vlm,
    /// Written by a person, in the condition file or on the command line.
    User,
    /// Nobody said: a documented default.
    Default,
}

/// A value with its origin and a word on how it came about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Sourced<T> {
    /// The value, in the unit its field documents.
    pub value: T,
    /// Where it comes from.
    pub origin: Origin,
    /// How: the rule, table or measurement, in a few words.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub how: String,
}

impl<T> Sourced<T> {
    /// A value with its origin and how it came about.
    pub fn new(value: T, origin: Origin, how: impl Into<String>) -> Self {
        Self { value, origin, how: how.into() }
    }
}
