//! Defects planted in a sound model, to see what a checker finds: one change each, of a known kind.
//!
//! [`mod@read`] takes a model with all the files that it needs, [`mod@plant`] puts one defect of a
//! [`kinds::Kind`] into it. Nothing here asks the checks: what is wrong then follows from the change
//! itself, or from contact measured in `touch`.

mod axes;
pub mod kinds;
pub mod language;
mod limits;
pub mod manifest;
mod meshes;
pub mod model;
pub mod needed;
pub mod plant;
pub mod planted;
pub mod read;
mod shapes;
mod structure;
mod touch;
mod weights;
