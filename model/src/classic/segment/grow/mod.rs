//! Growing: labels spread from the prompts over links between segments, without a classifier.

pub mod distance;
pub mod evidence;
pub mod fused_unary;
pub mod islands;
pub mod merge;
