//! Surfaces: simple shapes as triangles, hulls that are their own, distances by trees of boxes.
//!
//! Metres; each surface in the frame of its link unless a function says otherwise.

pub(crate) mod convex;
pub mod near;
pub mod tessellate;
