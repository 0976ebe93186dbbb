//! Waiting as an argument: real for services, imagined for replays and tests.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use trace::Digest;

/// Whatever tells how much time has passed, and waits.
pub trait Pace: Send + Sync {
    /// Time since some fixed moment.
    fn elapsed(&self) -> Duration;
    /// Waits.
    fn wait(&self, time: Duration);
}

/// The machine's own time.
#[derive(Debug)]
pub struct RealPace(Instant);

impl Default for RealPace {
    fn default() -> Self {
        Self(Instant::now())
    }
}

impl Pace for RealPace {
    fn elapsed(&self) -> Duration {
        self.0.elapsed()
    }

    fn wait(&self, time: Duration) {
        std::thread::sleep(time);
    }
}

/// Time that passes only by waiting, and then at once.
#[derive(Debug, Default)]
pub struct ImaginedPace(Mutex<Duration>);

impl Pace for ImaginedPace {
    fn elapsed(&self) -> Duration {
        *self.0.lock().unwrap_or_else(|e| e.into_inner())
    }

    fn wait(&self, time: Duration) {
        let mut now = self.0.lock().unwrap_or_else(|e| e.into_inner());
        *now = now.saturating_add(time);
    }
}

/// How long to wait before the next of several attempts: `first` doubled each time up to `most`, of
/// which a share between a half and all is taken. The share comes from a hash of `what` and the
/// attempt, so that callers spread and a run repeats.
pub fn back_off(first: Duration, most: Duration, attempt: u32, what: &str) -> Duration {
    let doubled = first.saturating_mul(2_u32.saturating_pow(attempt)).min(most);
    let digest = Digest::of(format!("{what} {attempt}").as_bytes());
    let share = u32::from_str_radix(digest.as_str().get(..4).unwrap_or("0"), 16).unwrap_or(0);
    doubled.mul_f64(0.5 + f64::from(share) / f64::from(0xffff_u32) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_double_up_to_the_most_and_repeat() {
        let (first, most) = (Duration::from_secs(1), Duration::from_secs(30));
        for attempt in 0..40 {
            let wait = back_off(first, most, attempt, "a job");
            let full = first.saturating_mul(2_u32.saturating_pow(attempt)).min(most);
            assert!(wait >= full / 2 && wait <= full, "{attempt}: {wait:?}");
            assert_eq!(wait, back_off(first, most, attempt, "a job"));
        }
        assert_ne!(back_off(first, most, 0, "a job"), back_off(first, most, 0, "another"));
    }
}
