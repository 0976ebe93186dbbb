//! The learned path and its golden test, compiled from the model's own sources without the tensor library
//! beside them.

#[path = "../../src/articulate.rs"]
pub mod articulate;
#[path = "../../src/classic/mod.rs"]
pub mod classic;

pub use articulate::{Articulate, ArticulateError, Articulation, Note};
pub use classic::prepared::{PartLabels, Prepared};
pub use classic::{Geometric, Hybrid};
