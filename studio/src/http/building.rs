//! What is being built, and what was.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use schemars::JsonSchema;
use serde::Serialize;

use crate::house::Built;

/// What is being built, and how the last build ended.
#[derive(Default)]
pub(super) struct Building {
    pub(super) count: u64,
    pub(super) running: Option<Arc<AtomicBool>>,
    pub(super) last: Option<BuiltAnswer>,
}

/// A build that goes on.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct BuildAnswer {
    /// Its number.
    pub(super) build: u64,
}

/// A build that ended.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct BuiltAnswer {
    /// The revision of the condition it was built from; empty where that is not known.
    pub(super) revision: String,
    /// As the command line's exit code.
    pub(super) exit: u8,
    /// The tier it reaches.
    pub(super) tier: Option<String>,
    /// How it went, in a line.
    pub(super) message: String,
    /// Where it stands.
    pub(super) out: String,
}

impl Building {
    /// Before anything is built: what stands there already, of a condition that nobody remembers.
    pub(super) fn over(standing: Option<Built>, out: &str) -> Self {
        let told = |built: Built| BuiltAnswer {
            revision: String::new(),
            exit: 0,
            tier: built.scene["tier"]["name"].as_str().map(str::to_owned),
            message: String::new(),
            out: out.to_owned(),
        };
        Self { last: standing.map(told), ..Self::default() }
    }

    /// Stops what is being built.
    pub(super) fn stop(&self) {
        if let Some(stop) = &self.running {
            stop.store(true, Ordering::SeqCst);
        }
    }

    pub(super) fn told(&self) -> (Option<BuiltAnswer>, Option<BuildAnswer>) {
        let running = self.running.as_ref().map(|_| BuildAnswer { build: self.count });
        (self.last.clone(), running)
    }
}
