//! Why a pack is not fitted, and who watches while it is.

use std::path::{Path, PathBuf};

use model::classic::learned::pack::Fault;

use crate::dataset::DataError;
use crate::procedural::FamilyError;

/// Why a pack is not fitted.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The disk.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A recipe that breaks a rule.
    #[error("{}: {what}", path.display())]
    Recipe {
        /// The file.
        path: PathBuf,
        /// Field, rule and what was found.
        what: String,
    },
    /// Data, what is held out among it.
    #[error(transparent)]
    Data(#[from] DataError),
    /// One of our own families.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// A folder another run works in.
    #[error("{} is in use by another run", .0.display())]
    Busy(PathBuf),
    /// Data of which nothing is learned.
    #[error("there is nothing to learn {0} from: no object of the recipe shows any")]
    Nothing(&'static str),
    /// What was fitted makes no pack.
    #[error("what was fitted makes no pack: {0}")]
    Pack(#[from] Fault),
    /// What was kept of a run is not what it was.
    #[error("{0}: remove the run's folder and fit again")]
    Broken(String),
    /// Somebody wants the run to end here; it goes on next time.
    #[error("the run was ended")]
    Stopped,
}

impl FitError {
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }

    pub(crate) fn recipe(path: &Path, what: impl std::fmt::Display) -> Self {
        Self::Recipe { path: path.to_path_buf(), what: what.to_string() }
    }
}

/// Somebody who watches a fit and may end it.
pub trait Watcher: Sync {
    /// Something happened. May be called from several threads.
    fn say(&self, line: &str);

    /// Whether another model is to be made after those that this run has made; asked before each.
    fn go_on(&self, made: usize) -> bool;
}
