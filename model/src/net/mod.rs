//! The articulation transformer.

pub(crate) mod kernel;
