//! Why bytes are not a GLB file we can take a surface from.

use crate::mesh::MeshError;

/// Why bytes are not a GLB file we can take a surface from.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GlbError {
    /// Header or chunks break a rule.
    #[error("GLB: {rule}, found {found}")]
    Container {
        /// The rule.
        rule: &'static str,
        /// What the file has.
        found: String,
    },
    /// The JSON chunk does not parse as glTF.
    #[error("GLB: the JSON chunk must be glTF: {0}")]
    Json(String),
    /// Something in the file breaks a rule.
    #[error("GLB: {place}: {rule}, found {found}")]
    Rule {
        /// Where in the file.
        place: String,
        /// The rule.
        rule: &'static str,
        /// What the file has.
        found: String,
    },
    /// An index that names nothing.
    #[error("GLB: {place} uses {what} {index}, but the file has {count}")]
    Reference {
        /// Who refers.
        place: String,
        /// To what.
        what: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// The file cannot be read without an extension we do not follow.
    #[error("GLB: the file needs the extension `{0}`, which kinfold does not read")]
    Extension(String),
    /// A URI that leaves the file.
    #[error("GLB: all data must be inside the file, found the URI `{0}`")]
    External(String),
    /// A compressed stream that does not unpack.
    #[error("GLB: {place}: the {codec} data does not decode: {reason}")]
    Codec {
        /// Where in the file.
        place: String,
        /// Which codec.
        codec: &'static str,
        /// What the codec says.
        reason: String,
    },
    /// The surface is not a mesh: empty, too large, without extent.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl GlbError {
    pub(crate) fn rule(
        place: impl Into<String>,
        rule: &'static str,
        found: impl Into<String>,
    ) -> Self {
        Self::Rule { place: place.into(), rule, found: found.into() }
    }

    pub(super) fn reference(
        place: impl Into<String>,
        what: &'static str,
        index: usize,
        count: usize,
    ) -> Self {
        Self::Reference { place: place.into(), what, index, count }
    }
}
