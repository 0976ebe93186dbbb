//! What one process tells the other: a page, or why there is none.

use serde::{Deserialize, Serialize};

/// A page, and what it shows.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Shown {
    pub(super) html: String,
    pub(super) name: String,
    pub(super) links: usize,
    pub(super) moving_joints: usize,
    pub(super) tier: Option<String>,
    pub(super) failures: Vec<String>,
    pub(super) notes: Vec<String>,
}

/// What the process apart says.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Told {
    Page(Shown),
    Complaint { message: String, hints: Vec<String> },
}
