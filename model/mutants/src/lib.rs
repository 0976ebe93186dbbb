//! The learned path and its golden test, compiled from the model's own sources without the tensor library
//! beside them.

#[path = "../../src/articulate.rs"]
pub mod articulate;
#[path = "../../src/geometric/mod.rs"]
pub mod geometric;

pub use articulate::{Articulate, ArticulateError, Articulation, Note};
pub use geometric::{Geometric, Hybrid};
