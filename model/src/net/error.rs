//! Why examples make no batch, and why a network gives no answer.

/// Why examples do not make a batch.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BatchError {
    /// Nothing to stack.
    #[error("a batch needs at least one example")]
    Empty,
    /// A count that does not fit the configuration or the other examples.
    #[error("example {example}: {what} must be {rule}, found {found}")]
    Count {
        /// Which example.
        example: usize,
        /// What was counted.
        what: &'static str,
        /// What it must be.
        rule: String,
        /// What it is.
        found: usize,
    },
}

/// Why the network gave no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NetworkError {
    /// The question does not fit the configuration.
    #[error(transparent)]
    Question(#[from] BatchError),
    /// Tokens a text encoder cannot take.
    #[error("a text has 1 to {positions} tokens below {vocabulary}, found {found:?}")]
    Tokens {
        /// Most tokens.
        positions: usize,
        /// Tokens there are.
        vocabulary: usize,
        /// What was given.
        found: Vec<u32>,
    },
    /// NaN or infinity on the way.
    #[error("{0} gave a value that is not finite")]
    NotFinite(String),
    /// Numbers that could not be read back from the device.
    #[error("results could not be read from the device: {0}")]
    Device(String),
}
