//! Many machines, on Restate: this process takes the items, asks services and keeps the ledger;
//! stages that compute are calls that Restate hands to workers and repeats until one has answered.
//!
//! One call per stage, its idempotency key the key of the stage's result, digests alone in its
//! journal: whoever asks twice gets one answer, and a worker that was killed, or that wakes up late,
//! makes bytes that stand in the shared store already.

mod admin;
mod ingress;
#[cfg(feature = "restate")]
#[allow(missing_docs, reason = "the SDK's macro writes a client without any")]
pub mod worker;

use std::sync::Arc;

use super::BatchError;
use super::engine::{Embedded, Engine, Feed, Work};
use crate::dag::Workers;

pub use admin::{Admin, AdminError};
pub use ingress::Ingress;

/// The handler of every stage's service.
const HANDLER: &str = "make";

/// The service that does a stage.
fn service(stage: &str) -> String {
    format!("kinfold.{stage}")
}

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
