//! Growing: labels spread from the prompts over links between segments, without a classifier.
//!
//! The result is good enough to use on its own, and the trees that classify segments start from
//! it.

pub mod distance;
pub mod evidence;
pub mod fused_unary;
pub mod islands;
pub mod merge;
