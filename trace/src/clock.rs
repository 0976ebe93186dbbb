//! Time as an argument: nanoseconds since the Unix epoch, from the system or from a number given.
//!
//! ```
//! use trace::{Clock, FixedClock};
//!
//! let clock = FixedClock(1_700_000_000_000_000_000);
//! assert_eq!(clock.now(), clock.now());
//! assert_eq!(trace::moment::written(clock.now()), "2023-11-14T22:13:20Z");
//! ```

use std::sync::atomic::{AtomicU64, Ordering};

/// Nanoseconds since 1970-01-01T00:00:00Z.
pub type Time = u64;

/// Whatever tells the time.
pub trait Clock: Send + Sync {
    /// The time now; never earlier than an answer before it.
    fn now(&self) -> Time;
}

/// The machine's clock.
#[derive(Debug, Default)]
pub struct SystemClock {
    latest: AtomicU64,
}

impl Clock for SystemClock {
    #[allow(clippy::disallowed_methods, reason = "the one place where the system's clock is read")]
    fn now(&self) -> Time {
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        let now = since.map_or(0, |d| d.as_nanos() as Time);
        self.latest.fetch_max(now, Ordering::Relaxed).max(now)
    }
}

/// A clock that stands still until told: for runs that must repeat byte for byte.
#[derive(Debug)]
pub struct FixedClock(pub Time);

impl Clock for FixedClock {
    fn now(&self) -> Time {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_system_clock_never_runs_backwards() {
        let clock = SystemClock::default();
        let times: Vec<_> = (0..1000).map(|_| clock.now()).collect();
        assert!(times.is_sorted() && times[0] > 1_600_000_000_000_000_000);
    }
}
