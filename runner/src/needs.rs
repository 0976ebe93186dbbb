//! What a stage needs: something to run on, and patience.
//!
//! ```
//! use std::time::Duration;
//!
//! use runner::Patience;
//!
//! let patience = Patience::default();
//! assert_eq!((patience.timeout, patience.attempts), (Duration::from_secs(600), 1));
//! ```

use std::time::Duration;

/// What a stage occupies while it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resource {
    /// A processor (and its threads).
    Cpu,
    /// Somebody else's machine.
    Network,
}

/// How long a stage may take and how often it may try.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// Longest time of one attempt.
    pub timeout: Duration,
    /// Most attempts, at least 1.
    pub attempts: u32,
    /// Pause before the second attempt; doubles each time.
    pub pause: Duration,
}

impl Default for Patience {
    /// Ten minutes, one attempt.
    fn default() -> Self {
        Self { timeout: Duration::from_secs(600), attempts: 1, pause: Duration::from_secs(1) }
    }
}
