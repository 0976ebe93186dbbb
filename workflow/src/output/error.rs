//! Why an output folder cannot be used.

use std::io;
use std::path::{Path, PathBuf};

use runner::ours::swap::Stuck;
use runner::ours::{Kind, LockError};

/// Why a folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum OutError {
    /// It holds files and neither our marker nor a trace of ours.
    #[error(
        "{} holds `{found}` and no marker of ours: no run of kinfold made this folder",
        runner::ours::name(root)
    )]
    NotOurs {
        /// The folder.
        root: PathBuf,
        /// What was found.
        found: String,
    },
    /// It is ours, and something else.
    #[error("{} is no output folder: its marker says {kind:?}", runner::ours::name(root))]
    Kind {
        /// The folder.
        root: PathBuf,
        /// What it is.
        kind: Kind,
    },
    /// No new folder can take its place by one step.
    #[error("{} {why}", runner::ours::name(root))]
    Place {
        /// The folder.
        root: PathBuf,
        /// Why not.
        why: &'static str,
    },
    /// Somebody is at work in it.
    #[error("output folder {} {source}", runner::ours::name(root))]
    Lock {
        /// The folder.
        root: PathBuf,
        /// Who.
        source: LockError,
    },
    /// A file of somebody else's stands in the way.
    #[error(transparent)]
    Stuck(#[from] Stuck),
    /// The disk.
    #[error("{}: cannot {doing}: {source}", runner::ours::name(path))]
    Io {
        /// What was tried.
        doing: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
}

pub(super) fn io_failed(
    doing: &'static str,
    path: &Path,
) -> impl FnOnce(io::Error) -> OutError + use<> {
    let path = path.to_path_buf();
    move |source| OutError::Io { doing, path, source }
}
