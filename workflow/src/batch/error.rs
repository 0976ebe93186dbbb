//! Why a batch as a whole cannot go on.

use super::ledger::LedgerError;
use super::manifest::ManifestError;

/// Why a batch as a whole cannot go on; no item is to blame for it.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// The manifest.
    #[error(transparent)]
    Manifest(#[from] ManifestError),
    /// The ledger.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    /// The state directory.
    #[error(transparent)]
    State(#[from] runner::StateError),
    /// A run that could not be recorded.
    #[error(transparent)]
    Run(#[from] runner::RunError),
    /// An output folder.
    #[error(transparent)]
    Out(#[from] crate::output::OutError),
    /// The store.
    #[error(transparent)]
    Store(#[from] runner::store::StoreError),
    /// A trace.
    #[error(transparent)]
    Trace(#[from] trace::TraceError),
    /// Threads to work with.
    #[error("cannot start threads: {0}")]
    Threads(rayon::ThreadPoolBuildError),
    /// The batch's own folder.
    #[error("{}: cannot {doing}: {source}", path.display())]
    Io {
        /// What was tried.
        doing: &'static str,
        /// The file or folder.
        path: std::path::PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The folder holds something else, and no marker of ours.
    #[error(
        "{} holds `{found}` and no marker of ours: no batch was made in this folder",
        runner::ours::name(path)
    )]
    NotOurs {
        /// The folder.
        path: std::path::PathBuf,
        /// What was found.
        found: String,
    },
    /// Another batch is at work in it.
    #[error("batch {} {source}", runner::ours::name(path))]
    Lock {
        /// The folder.
        path: std::path::PathBuf,
        /// Who.
        source: runner::ours::LockError,
    },
    /// The folder is not what it should be.
    #[error("{}: {found}", path.display())]
    Folder {
        /// The folder.
        path: std::path::PathBuf,
        /// What is wrong with it.
        found: String,
    },
    /// A stage met a disk that is full or may not be written.
    #[error("{stage}: {found}")]
    House {
        /// The stage.
        stage: String,
        /// What it met.
        found: String,
    },
    /// What was spent is not known, so no budget can be kept.
    #[error("what was spent is not known: {found}")]
    Spending {
        /// What does not hold.
        found: String,
    },
    /// Items need something nobody makes.
    #[error("nobody to ask for {what}, which {items} items need: no provider is configured")]
    Nobody {
        /// What they need.
        what: &'static str,
        /// How many.
        items: u64,
    },
    /// Nothing works any more.
    #[error("{items} items in a row met a passing trouble, the last: {last}")]
    Down {
        /// How many.
        items: u32,
        /// What the last one met.
        last: String,
    },
}
