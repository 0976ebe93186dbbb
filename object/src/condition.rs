//! The kinematic condition: what the parts are, how they hang together, where to find them, and what a
//! person has corrected.
//!
//! On disk it is a JSON file a person can write ([`ConditionFile`], `kinfold-condition/2`); in
//! memory it is a [`Condition`], the paper's C, whose tree is proved and whose points are in the
//! object frame. Files of `kinfold-condition/1` and of the schema `condition/1` are read as well.

mod fault;
mod file;
mod foreign;
mod given;
mod lines;
mod names;
mod plain;
mod points;
mod read;
mod resolve;
mod runs;
mod types;
mod written;

pub use fault::{ConditionError, Fault};
pub use file::{
    ConditionFile, FileJoint, FileJoints, FilePart, FileSize, Quantity, SCHEMA, SCHEMA_1,
};
pub use given::GivenJoints;
pub use names::name_from_text;
pub use plain::{Plain, plain};
pub use runs::{Runs, RunsError};
pub use types::{
    Condition, Extent, GivenJoint, MAX_POINTS, MAX_TEXT, POINT_TOLERANCE, Prompt, TrueSize,
};

#[cfg(test)]
mod tests;
