//! From the condition's points and words to the first segments of each part.
//!
//! A part with a point starts where the point lies. A part without one is placed by its words, by
//! the tree and by copies of its siblings.

pub mod assign;
pub mod candidates;
pub mod placed;
pub mod repeats;
pub mod roles;
pub mod seeds;
pub mod shape;
