//! Why a training run cannot go on.

use std::path::{Path, PathBuf};

use model::net::{BatchError, ConfigError};
use model::weights::WeightsError;

use crate::dataset::DataError;

/// Why training cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// The disk.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A configuration or a table that breaks a rule.
    #[error("{}: {what}", path.display())]
    Config {
        /// The file.
        path: PathBuf,
        /// The rule and what was found.
        what: String,
    },
    /// Data.
    #[error(transparent)]
    Data(#[from] DataError),
    /// Weights or a checkpoint.
    #[error("{}: {source}", path.display())]
    Weights {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: WeightsError,
    },
    /// A checkpoint of another run.
    #[error("{} was made with another configuration", .0.display())]
    OtherRun(PathBuf),
    /// A folder another run works in.
    #[error("{} is in use by another run", .0.display())]
    Busy(PathBuf),
    /// Weights of other sizes.
    #[error("{}: its sizes or encoders are not those of the configuration", .0.display())]
    OtherSizes(PathBuf),
    /// Sizes that make no network.
    #[error(transparent)]
    Sizes(#[from] ConfigError),
    /// Lessons that make no batch.
    #[error(transparent)]
    Batch(#[from] BatchError),
    /// Objects that make no lessons.
    #[error("{0} objects drawn in a row made no lesson, the last because: {1}")]
    NoLesson(usize, String),
    /// A loss that is no number: the weights are lost, the last checkpoint is not.
    #[error("the loss of step {step} is {loss}")]
    Diverged {
        /// The step.
        step: u64,
        /// Its loss.
        loss: f32,
    },
    /// Numbers that could not be read back.
    #[error("results could not be read from the device: {0}")]
    Device(String),
    /// A plot or a text that could not be made.
    #[error("the plot could not be made: {0}")]
    Plot(String),
}

impl TrainError {
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }

    pub(crate) fn weights(path: &Path) -> impl FnOnce(WeightsError) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Weights { path, source }
    }
}
