//! How often each token may ask.

use std::collections::BTreeMap;
use std::time::Instant;

/// How many requests each token has left for now.
#[derive(Debug, Default)]
pub(super) struct Rates(BTreeMap<String, (f64, Instant)>);

impl Rates {
    /// Takes one; or the seconds after which there is one again.
    pub(super) fn take(&mut self, who: &str, a_second: f64, now: Instant) -> Result<(), f64> {
        let most = (2.0 * a_second).max(1.0);
        let (left, since) = self.0.entry(who.to_owned()).or_insert((most, now));
        let come = now.saturating_duration_since(*since).as_secs_f64() * a_second;
        (*left, *since) = ((*left + come).min(most), now);
        if *left >= 1.0 {
            *left -= 1.0;
            return Ok(());
        }
        Err((1.0 - *left) / a_second)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn twice_as_many_may_come_at_once_and_then_as_many_as_agreed() {
        let (mut rates, now) = (Rates::default(), Instant::now());
        let mut take = |who, at| rates.take(who, 5.0, now + Duration::from_millis(at)).is_ok();
        assert_eq!((0..12).filter(|_| take("ann", 0)).count(), 10);
        assert!(take("bob", 0), "another's requests are another's");
        assert_eq!((0..12).filter(|_| take("ann", 1000)).count(), 5);
    }
}
