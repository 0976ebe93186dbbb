//! What the program can be asked to do, one file per command.

pub mod audit;
pub mod batch;
pub mod check;
pub mod completions;
pub mod doctor;
mod engines;
pub mod eval;
mod given;
pub mod make;
pub mod plan;
pub mod provider_list;
mod providers;
pub mod schema;
mod sealed;
pub mod signing;
pub mod store;
pub mod summary;
mod supply;
pub mod trace;
pub mod trace_diff;
pub mod trace_extract;
pub mod trace_replay;
pub mod trace_verify;
pub mod train;
pub mod trust;
pub mod weights;
pub mod worker;
