//! How long a verb that only looks may take, and how much memory.

use std::time::Duration;

use clap::Args;

use super::parse::{at_least_one, seconds};
use crate::cli::watch::{Bounds, STOPPED};

/// What looking at a stranger's files may take.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct BoundsArgs {
    /// Longest time it may take [default: 600 for a trace, 3600 to replay one, 21600 for a batch or
    /// a store]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub deadline: Option<Duration>,
    /// Most memory it may take [default: 8]
    #[arg(long, value_name = "GIB", value_parser = at_least_one)]
    pub memory: Option<usize>,
}

impl BoundsArgs {
    /// What was asked for, or so many seconds and the usual memory.
    pub(in crate::cli) fn or(self, longest: u64) -> Bounds {
        let memory = self.memory.and_then(|gib| u64::try_from(gib).ok()?.checked_mul(1 << 30));
        Bounds {
            deadline: self.deadline.unwrap_or(Duration::from_secs(longest)),
            memory: memory.unwrap_or(Bounds::MEMORY),
            exit: STOPPED,
        }
    }
}
