//! Over-segmentation: the surface is cut into segments so small that each belongs to one part.

pub mod contact;
pub mod flood;
pub mod hurdles;
pub mod patches;
pub mod segment;
pub mod segments;
pub mod units;
