//! The reader of manifests, compiled from the workflow's own source without the rooms below it, so
//! that the fuzz target builds in a minute.

#[path = "../../src/batch/manifest.rs"]
pub mod manifest;
