//! Models that were fitted, and the files they come in: boosted trees, a small network, and the
//! pack, a file that names the features its models ask about.

pub mod forest;
pub mod grove;
pub mod network;
pub mod pack;
pub mod shipped;
