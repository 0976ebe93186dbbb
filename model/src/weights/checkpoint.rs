//! What is taken of a checkpoint that PyTorch wrote, and why one is refused.

use super::file::WeightsError;

/// Why a checkpoint could not be converted.
#[derive(Debug, thiserror::Error)]
pub enum ConvertError {
    /// The disk said no.
    #[error("checkpoint: {0}")]
    Io(#[from] std::io::Error),
    /// Not the kind of zip file PyTorch writes.
    #[error("not a PyTorch checkpoint: {0}")]
    Archive(String),
    /// A pickle that is damaged or says what tensors do not need.
    #[error("the checkpoint's pickle, {0}")]
    Pickle(String),
    /// A pickle that wants something other than tensors and plain containers.
    #[error("the checkpoint's pickle asks for `{0}`; only tensors and plain containers are read")]
    Foreign(String),
    /// Tensors that are not where or what they should be.
    #[error("checkpoint entry `{name}`: {rule}")]
    Entry {
        /// The key.
        name: String,
        /// What is wrong with it.
        rule: String,
    },
    /// The safetensors file could not be written.
    #[error(transparent)]
    Write(#[from] WeightsError),
}

/// What becomes of objects that are neither tensors nor plain containers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foreign {
    /// The checkpoint is refused.
    Refused,
    /// They stay opaque, are never looked into, and may stand beside the tensors, never among them:
    /// for trainers' checkpoints, which keep their settings beside `state_dict`.
    Opaque,
}
