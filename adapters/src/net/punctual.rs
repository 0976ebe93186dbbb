//! Turns the moment a service wants to be left alone until into seconds from now.

use std::sync::Arc;
use std::time::Duration;

use chrono::{DateTime, NaiveDateTime};
use trace::Clock;

use crate::transport::{Request, Response, Transport, TransportError};

const RETRY_AFTER: &str = "retry-after";

/// Answers whose `retry-after` is a number of seconds, where the service wrote a date; a moment that
/// has passed is none. It stands below the record: what was waited for stands there, and a replay
/// needs no clock.
pub struct Punctual<T> {
    /// Who is asked.
    pub inner: T,
    /// Who knows what time it is.
    pub clock: Arc<dyn Clock>,
}

impl<T: Transport> Transport for Punctual<T> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let mut response = self.inner.send(request)?;
        let now = Duration::from_nanos(self.clock.now());
        for (name, value) in &mut response.headers {
            let moment = (name == RETRY_AFTER).then(|| http_date(value.trim()));
            if let Some(moment) = moment.flatten() {
                let wait = moment.saturating_sub(now);
                *value = wait.as_secs_f64().ceil().to_string();
            }
        }
        Ok(response)
    }
}

/// The moment an HTTP date names, since 1970, in any of the three forms of RFC 9110 (section 5.6.7);
/// years of two digits are those from 1969 on.
fn http_date(text: &str) -> Option<Duration> {
    let old = ["%A, %d-%b-%y %H:%M:%S GMT", "%a %b %e %H:%M:%S %Y"];
    let older = |form: &&str| NaiveDateTime::parse_from_str(text, form).ok();
    let moment = match DateTime::parse_from_rfc2822(text) {
        Ok(moment) => moment.timestamp(),
        Err(_) => old.iter().find_map(older)?.and_utc().timestamp(),
    };
    u64::try_from(moment).ok().map(Duration::from_secs)
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use trace::FixedClock;

    use super::*;
    use crate::net::pace::{ImaginedPace, Pace as _};
    use crate::net::retry::Retrying;
    use crate::net::tape::{MemoryTape, Recorded, Replayed};
    use crate::transport::Method;

    /// 1994-11-06T08:49:37Z.
    const MOMENT: u64 = 784_111_777;
    const WRITTEN: &str = "Sun, 06 Nov 1994 08:49:37 GMT";

    /// Busy when it is asked for the second time.
    struct Busy(Mutex<u32>);

    impl Transport for Busy {
        fn send(&self, _: &Request) -> Result<Response, TransportError> {
            let mut asked = self.0.lock().unwrap();
            *asked += 1;
            let headers = vec![(RETRY_AFTER.to_owned(), WRITTEN.to_owned())];
            Ok(Response { status: if *asked == 2 { 429 } else { 200 }, headers, body: vec![] })
        }
    }

    /// The last status of two requests and the time waited.
    fn two(inner: impl Transport) -> (u16, Duration) {
        let pace = Arc::new(ImaginedPace::default());
        let retrying = Retrying { inner, pace: pace.clone(), attempts: 2 };
        let last = ["s", "t"].map(|step| {
            retrying.send(&Request::new(step, Method::Post, "http://h/")).unwrap().status
        })[1];
        (last, pace.elapsed())
    }

    /// The same of a service that is busy, and what was recorded.
    fn asked(now: Duration) -> (u16, Duration, Arc<MemoryTape>) {
        let tape = Arc::new(MemoryTape::default());
        let clock = Arc::new(FixedClock(now.as_nanos() as u64));
        let inner = Punctual { inner: Busy(Mutex::default()), clock };
        let (status, waited) = two(Recorded { inner, tape: tape.clone() });
        (status, waited, tape)
    }

    #[test]
    fn a_date_is_waited_for_like_so_many_seconds() {
        let before = |seconds| Duration::from_secs(MOMENT - seconds);
        assert_eq!(asked(before(7)).1, Duration::from_secs(7));
        let between = before(7) + Duration::from_millis(300);
        assert_eq!(asked(between).1, Duration::from_secs(7), "never too early");
        let (status, waited, _) = asked(before(121));
        assert_eq!((status, waited), (429, Duration::ZERO), "no longer than a number may ask for");
    }

    #[test]
    fn a_moment_that_has_passed_is_no_reason_to_wait() {
        let (status, waited, _) = asked(Duration::from_secs(MOMENT + 1000));
        assert_eq!((status, waited), (200, Duration::ZERO));
    }

    #[test]
    fn what_was_waited_for_stands_on_record_in_seconds_and_a_replay_needs_no_clock() {
        let (exchanges, bodies) = asked(Duration::from_secs(MOMENT - 7)).2.contents();
        let written = serde_json::to_string(&exchanges).unwrap();
        assert!(written.contains(r#"["retry-after","7"]"#), "{written}");
        assert_eq!(two(Replayed::new(exchanges, bodies)), (200, Duration::ZERO));
    }

    #[test]
    fn the_three_forms_of_a_date_name_one_moment_and_what_is_no_date_is_none() {
        for text in [WRITTEN, "Sunday, 06-Nov-94 08:49:37 GMT", "Sun Nov  6 08:49:37 1994"] {
            assert_eq!(http_date(text), Some(Duration::from_secs(MOMENT)), "{text}");
        }
        for text in [
            "",
            "soon",
            "7",
            "Wed, 30 Feb 2000 00:00:00 GMT",
            "Wed, 00 Mar 2000 00:00:00 GMT",
            "Sat, 01 Jan 1966 00:00:00 GMT",
            "Sun, 06 Nov 1994 24:00:00 GMT",
            "Sun, 06 Nov 99999999999999999999 08:49:37 GMT",
        ] {
            assert_eq!(http_date(text), None, "{text}");
        }
    }
}
