//! Many machines, on Restate: this process takes the items, asks services and keeps the ledger;
//! stages that compute are calls that Restate hands to workers and repeats until one has answered.
//!
//! One call per stage, its idempotency key the key of the stage's result, digests alone in its
//! journal: whoever asks twice gets one answer, and a worker that was killed, or that wakes up late,
//! makes bytes that stand in the shared store already.

mod admin;
mod ingress;

use std::sync::Arc;

use runner::Workers;

use super::engine::{Embedded, Engine, Feed, Work};
use super::error::BatchError;

pub use admin::{Admin, AdminError};
pub use ingress::Ingress;

/// Items on threads of this process, their computing on Restate's workers.
pub struct Restate {
    /// Items under way at a time, at least one.
    pub hands: usize,
    /// How Restate is asked.
    pub workers: Arc<Ingress>,
}

impl Engine for Restate {
    fn name(&self) -> &'static str {
        "restate"
    }

    fn workers(&self) -> Option<Arc<dyn Workers>> {
        let workers: Arc<dyn Workers> = Arc::<Ingress>::clone(&self.workers);
        Some(workers)
    }

    fn run(&self, feed: &dyn Feed, work: &dyn Work) -> Result<(), BatchError> {
        Embedded { hands: self.hands }.run(feed, work)
    }
}
