//! Clean-up of found labels: connectivity, copies, siblings of one size, fusion of several over-segmentations.

pub mod connectivity;
pub mod copies;
pub mod fusion;
pub mod siblings;
pub mod surface;
