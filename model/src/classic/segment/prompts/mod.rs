//! From points and words to the first segments of each part.

pub mod assign;
pub mod candidates;
pub mod placed;
pub mod repeats;
pub mod roles;
pub mod seeds;
pub mod shape;
