//! The solver that needs no weights: labels from prompts, joints from shape and free motion.

pub mod candidates;
pub mod contact;
pub mod features;
pub mod joints;
pub mod labels;
pub mod scene;
pub mod sweep;
pub mod words;

/// The geometric articulator.
#[derive(Clone, Debug, Default)]
pub struct Geometric;
