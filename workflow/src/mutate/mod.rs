//! Defects planted in a sound model, to see what a checker finds: one change each, of a known kind.

pub mod kinds;
pub mod language;
