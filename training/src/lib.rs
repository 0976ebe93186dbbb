//! Where weights come from: objects with exact labels, and what a prediction is worth against them.

pub mod evaluate;
pub mod metrics;
pub mod procedural;
pub mod truth;
