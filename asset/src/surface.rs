//! Surfaces fit to be drawn and weighed.
//!
//! A mesh that was made to look right has faces without area, faces twice, faces turned inside out,
//! and holes where parts were cut from one skin. Here each part's surface is welded, oriented
//! outward, closed where it moves, and brought within the budget of faces. Metres, asset frame.

pub(crate) mod borders;
pub(crate) mod caps;
pub(crate) mod fans;
pub mod orient;
pub(crate) mod patches;
pub(crate) mod polygon;
pub mod repair;
pub mod repaired;
pub(crate) mod seal;
pub(crate) mod simplify;
