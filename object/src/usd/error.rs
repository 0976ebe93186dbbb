//! Why bytes are not a USD surface.

use std::borrow::Cow;

use crate::mesh::MeshError;

/// Why bytes are not a USD surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UsdError {
    /// What cannot be read.
    #[error("USD: {0}")]
    Unreadable(String),
    /// The library that reads layers broke down on it, or did not come to an end: nothing is known of it.
    #[error("USD: {0}")]
    Unanswered(String),
    /// Something in the file breaks a rule.
    #[error("USD {prim}: {rule}, found {found}")]
    Rule {
        /// Path of the prim.
        prim: String,
        /// The rule.
        rule: Cow<'static, str>,
        /// What the file has.
        found: String,
    },
    /// The surface is not a mesh: empty, too large, without extent.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// An error with its causes, in a line.
pub(super) fn shortened(error: &anyhow::Error) -> String {
    format!("{error:#}")
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .chars()
        .take(300)
        .collect()
}
