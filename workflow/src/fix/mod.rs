//! A model mended where it stands: the smallest changes of its text that the checks approve of.
//!
//! [`run::fix`] is the door. It reads a model, asks every [`remedies::Way`] what it would change, and
//! keeps a change only if the checks find less afterwards and nothing more. Comments, order and
//! indentation stay as they are.

mod collisions;
mod joints;
mod judge;
pub(crate) mod lines;
pub(crate) mod numbers;
mod offer;
mod pivots;
pub mod remedies;
pub mod run;
mod weights;
pub(crate) mod winding;
