//! What the program can be asked to do, one file per command.

pub mod audit;
pub mod batch;
pub mod check;
pub mod completions;
pub mod eval;
pub mod make;
pub mod plan;
mod providers;
pub mod schema;
pub mod store;
pub mod summary;
pub mod trace;
pub mod train;
pub mod weights;
