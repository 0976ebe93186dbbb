//! How far a point is from a surface, and how far two surfaces are apart: exact, by trees of boxes.
//!
//! One tree serves both questions, costs a few milliseconds for a surface of 40,000 triangles, and
//! every question says from the start how near is near enough.

pub(crate) mod islands;
pub mod pair;
pub mod tree;
pub mod triangle;

pub use pair::{Nearest, nearest};
pub use tree::BoxTree;
