//! Many photos to many assets: a manifest, a ledger, and items in any order on any number of hands.
//!
//! The store decides what is done: every stage of every item is recalled by its key, whoever made
//! it. The [`ledger`] says what became of each item and is only ever added to; the [`engine`] only
//! decides which item is next. So a batch that was killed goes on with the next line that has no
//! outcome, and nothing has to be rebuilt.

pub mod allowance;
pub mod attest;
pub mod audit;
pub mod class;
pub mod engine;
mod error;
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
pub mod service;
pub mod signed;

pub use class::Class;
pub use engine::{Embedded, Engine, Feed, Shard, Work};
pub use error::BatchError;
pub use ledger::{Ledger, LedgerError, Planned};
pub use manifest::{Item, Line, ManifestError};
pub use record::Record;
