//! How far a point is from a surface, and how far two surfaces are apart: exact, by trees of boxes.
//!
//! One tree serves both questions, costs a few milliseconds for a surface of 40,000 triangles, and
//! every question says from the start how near is near enough.
//!
//! ```
//! use object::DVec3;
//! use sim_check::geometry::near::BoxTree;
//! let tree = BoxTree::new(vec![[DVec3::ZERO, DVec3::X, DVec3::Y]]);
//! assert_eq!(tree.distance(DVec3::new(0.25, 0.25, 3.0), f64::INFINITY), 3.0);
//! ```

pub(crate) mod islands;
pub mod pair;
pub mod tree;
pub mod triangle;

pub use pair::{Nearest, nearest};
pub use tree::BoxTree;
