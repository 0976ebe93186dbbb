//! Mass and inertia: what a shape would have, and what several bodies have together.
//!
//! Kilograms and metres; inertia about the centre of mass unless a function says otherwise.

pub(crate) mod inertia;
pub mod lump;
pub(crate) mod solid;
