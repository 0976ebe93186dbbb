//! Many photos to many assets: a manifest, a ledger, and items in any order on any number of hands.
//!
//! The store decides what is done: every stage of every item is recalled by its key, whoever made
//! it. The [`ledger`] says what became of each item and is only ever added to; the [`engine`] only
//! decides which item is next. So a batch that was killed goes on with the next line that has no
//! outcome, and nothing has to be rebuilt.

pub mod attest;
pub mod audit;
pub mod class;
pub mod engine;
pub mod estimate;
pub mod feed;
pub mod folder;
pub mod gate;
pub mod index;
pub mod item;
pub mod keep;
pub mod ledger;
pub mod look;
pub mod manifest;
pub mod plan;
pub mod progress;
pub mod purse;
pub mod record;
pub mod report;
pub mod restate;
pub mod run;
pub mod signed;

pub use class::Class;
pub use engine::{Embedded, Engine, Feed, Shard, Work};
pub use ledger::{Ledger, LedgerError, Planned};
pub use manifest::{Item, Line, ManifestError};
pub use record::Record;

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
    State(#[from] crate::dag::StateError),
    /// A run that could not be recorded.
    #[error(transparent)]
    Run(#[from] crate::dag::RunError),
    /// An output folder.
    #[error(transparent)]
    Out(#[from] crate::output::OutError),
    /// The store.
    #[error(transparent)]
    Store(#[from] crate::dag::store::StoreError),
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
        crate::ours::name(path)
    )]
    NotOurs {
        /// The folder.
        path: std::path::PathBuf,
        /// What was found.
        found: String,
    },
    /// Another batch is at work in it.
    #[error("batch {} {source}", crate::ours::name(path))]
    Lock {
        /// The folder.
        path: std::path::PathBuf,
        /// Who.
        source: crate::ours::LockError,
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
