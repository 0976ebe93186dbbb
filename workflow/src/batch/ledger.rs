//! The ledger of a batch: what was planned, what was asked, and what became of each item. SQLite; rows
//! are only ever added, and each names the digest of the one before it in its table.

mod ask;
mod calls;
mod chain;
mod database;
mod opening;
mod orders;
mod outcomes;
mod plan;

pub use ask::{AskError, columns};
pub use calls::{Call, Sent};
pub use database::{FILE, Ledger, LedgerError};
pub use plan::{Planned, Settled, Standing};

#[cfg(test)]
mod tests;
