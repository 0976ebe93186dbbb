//! Over-segmentation: the surface cut into segments small enough to belong to one part each.

pub mod contact;
pub mod flood;
pub mod patches;
pub mod segment;
pub mod segments;
pub mod units;
