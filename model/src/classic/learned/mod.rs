//! What was learned, as files: trees, a small network, and the pack that says what they ask about.

pub mod forest;
pub mod network;
pub mod pack;
pub mod shipped;
