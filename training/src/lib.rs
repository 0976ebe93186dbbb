//! Where weights come from: objects with exact labels, the lessons they make, and the training that
//! turns those into weights.

mod alone;
pub mod augment;
pub mod dataset;
pub mod evaluate;
pub mod fit;
pub mod forest;
pub mod fuse;
pub mod loss;
pub mod metrics;
pub mod procedural;
pub mod train;
pub mod truth;
