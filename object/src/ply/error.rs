//! Why bytes are not a PLY surface.

use crate::mesh::MeshError;

/// Why bytes are not a PLY surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlyError {
    /// A line of the header that breaks a rule.
    #[error("PLY line {line}: {rule}, found `{found}`")]
    Header {
        /// Number of the line, from 1.
        line: usize,
        /// The rule.
        rule: &'static str,
        /// The line's text, shortened.
        found: String,
    },
    /// What the header promises is no surface.
    #[error("PLY: {rule}, found {found}")]
    Rule {
        /// The rule.
        rule: &'static str,
        /// What the file has.
        found: String,
    },
    /// A row of an element that breaks a rule.
    #[error("PLY {element} {row}: {rule}, found {found}")]
    Row {
        /// Name of the element.
        element: String,
        /// Number of the row, from 0.
        row: usize,
        /// The rule.
        rule: &'static str,
        /// What the file has.
        found: String,
    },
    /// The surface is not a mesh: empty, too large, without extent.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}
