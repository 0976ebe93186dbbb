//! The solver that needs no weights: labels from prompts, joints from shape and free motion.

pub mod labels;

/// The geometric articulator.
#[derive(Clone, Debug, Default)]
pub struct Geometric;
