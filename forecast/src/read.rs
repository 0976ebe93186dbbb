//! Files on disk → what the rules look at. Everything is bounded, and nothing here panics.

mod error;
mod load;
pub mod mesh;
pub mod mjcf;
mod numbers;
mod obj;
mod scan;
mod shelf;
mod stl;
pub(crate) mod tree;
pub mod urdf;
pub mod usda;

pub use error::{ReadError, Reason};
pub use load::{MAX_BYTES, Model, read};
pub use shelf::Outside;
