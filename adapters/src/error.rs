//! What can go wrong outside, sorted by what to do about it.

/// Why an adapter has no answer.
#[derive(Debug, thiserror::Error)]
pub enum AdapterError {
    /// A file that cannot be read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A photo that is no photo.
    #[error("{path}: {rule}, found {found}")]
    Photo {
        /// The file.
        path: String,
        /// What a photo must be.
        rule: String,
        /// What this is.
        found: String,
    },
    /// A mesh file that cannot be used.
    #[error("{path}: {source}")]
    Glb {
        /// The file.
        path: String,
        /// Which rule it breaks.
        source: object::glb::GlbError,
    },
    /// An OBJ file that cannot be used.
    #[error("{path}: {source}")]
    Obj {
        /// The file.
        path: String,
        /// Which rule it breaks.
        source: object::obj::ObjError,
    },
    /// A condition that cannot be used.
    #[error("{path}: {source}")]
    Condition {
        /// The file.
        path: String,
        /// Which rule it breaks.
        source: object::condition::ConditionError,
    },
    /// A file of a kind nobody here reads.
    #[error("{path}: expected {expected}, found {found}")]
    Format {
        /// The file.
        path: String,
        /// What can be read.
        expected: &'static str,
        /// What it looks like.
        found: String,
    },
    /// The network, at the one seam it passes through.
    #[error(transparent)]
    Transport(#[from] crate::transport::TransportError),
}

impl AdapterError {
    /// Whether asking again later may help.
    pub fn is_transient(&self) -> bool {
        matches!(self, Self::Transport(e) if e.transient)
    }
}
