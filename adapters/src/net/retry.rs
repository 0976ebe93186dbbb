//! Asks again, with manners: what costs nothing to repeat, and paid work only if it never arrived.

use std::sync::Arc;
use std::time::Duration;

use super::pace::{Pace, back_off};
use crate::transport::{Method, Request, Response, Transport, TransportError};

/// Longest wait a service may ask for; beyond it the answer stands as it is.
pub const MAX_ASKED_WAIT: Duration = Duration::from_secs(120);

/// Asks again up to `attempts` times in all.
///
/// A `GET` is repeated after 408, 429, 5xx or no answer; a `POST` only if it cannot have arrived,
/// after 429, or after 503 with `retry-after`; a look that has to be posted is a `GET` here.
/// `retry-after` and `retry-after-ms` are kept to.
pub struct Retrying<T> {
    /// Who is asked.
    pub inner: T,
    /// Who waits.
    pub pace: Arc<dyn Pace>,
    /// Most attempts, at least one.
    pub attempts: u32,
}

impl<T: Transport> Transport for Retrying<T> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let mut attempt = 0;
        loop {
            let outcome = self.inner.send(request);
            attempt += 1;
            let again = attempt < self.attempts && may_repeat(request, &outcome);
            let Some(wait) = again.then(|| wait(request, &outcome, attempt - 1)).flatten() else {
                return outcome;
            };
            self.pace.wait(wait);
        }
    }
}

fn may_repeat(request: &Request, outcome: &Result<Response, TransportError>) -> bool {
    let method = if request.is_look() { Method::Get } else { request.method };
    match (method, outcome) {
        (Method::Get, Ok(r)) => matches!(r.status, 408 | 429 | 500..),
        (Method::Post, Ok(r)) => match r.status {
            // An empty purse does not fill by waiting.
            429 => !String::from_utf8_lossy(&r.body).contains("insufficient_quota"),
            503 => asked_wait(r).is_some(),
            _ => false,
        },
        (Method::Get, Err(e)) => e.transient,
        (Method::Post, Err(e)) => e.transient && !e.may_have_arrived,
    }
}

/// How long to wait; none if the service asks for more than is reasonable.
fn wait(
    request: &Request,
    outcome: &Result<Response, TransportError>,
    attempt: u32,
) -> Option<Duration> {
    let asked = outcome.as_ref().ok().and_then(asked_wait);
    let own = back_off(Duration::from_secs(1), Duration::from_secs(30), attempt, &request.step);
    Some(asked.unwrap_or(own)).filter(|w| *w <= MAX_ASKED_WAIT)
}

/// What the service asks for, in seconds or milliseconds; a date was made seconds further down.
pub(crate) fn asked_wait(response: &Response) -> Option<Duration> {
    let number = |name| response.header(name)?.trim().parse::<f64>().ok();
    let seconds = number("retry-after-ms").map(|ms| ms / 1e3).or_else(|| number("retry-after"))?;
    Duration::try_from_secs_f64(seconds).ok()
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::super::pace::ImaginedPace;
    use super::*;

    /// Gives its answers in order and counts.
    struct Moody(Mutex<Vec<Result<Response, TransportError>>>);

    impl Transport for Moody {
        fn send(&self, _: &Request) -> Result<Response, TransportError> {
            self.0.lock().unwrap().remove(0)
        }
    }

    fn status(status: u16, headers: &[(&str, &str)]) -> Result<Response, TransportError> {
        let headers = headers.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        Ok(Response { status, headers, body: vec![] })
    }

    fn lost(may_have_arrived: bool) -> Result<Response, TransportError> {
        let error = TransportError::refused(&Request::new("s", Method::Get, "http://h"), "lost");
        Err(TransportError { transient: true, may_have_arrived, ..error })
    }

    /// What is left of the answers, the last one's status (0 for none) and the time waited.
    fn ask(
        method: Method,
        answers: Vec<Result<Response, TransportError>>,
    ) -> (usize, u16, Duration) {
        let pace = Arc::new(ImaginedPace::default());
        let inner = Moody(Mutex::new(answers));
        let retrying = Retrying { inner, pace: pace.clone(), attempts: 4 };
        let last = retrying.send(&Request::new("s", method, "http://h"));
        let left = retrying.inner.0.lock().unwrap().len();
        (left, last.map_or(0, |r| r.status), pace.elapsed())
    }

    #[test]
    fn a_fetch_is_repeated_until_it_works_or_four_times() {
        let answers = vec![status(502, &[]), lost(true), status(200, &[]), status(200, &[])];
        assert_eq!(ask(Method::Get, answers).0, 1);
        assert_eq!(ask(Method::Get, (0..9).map(|_| status(500, &[])).collect()).0, 5);
        assert_eq!(ask(Method::Get, vec![status(404, &[]), status(200, &[])]).1, 404);
    }

    #[test]
    fn a_look_that_has_to_be_posted_is_repeated_like_a_fetch() {
        let look = Request::new("tencent.status", Method::Post, "http://h");
        assert!(may_repeat(&look, &status(502, &[])) && may_repeat(&look, &lost(true)));
        assert!(!look.is_work());
    }

    #[test]
    fn paid_work_is_repeated_only_if_it_never_arrived() {
        assert_eq!(ask(Method::Post, vec![lost(true), status(200, &[])]).1, 0);
        assert_eq!(ask(Method::Post, vec![lost(false), status(200, &[])]).1, 200);
        assert_eq!(ask(Method::Post, vec![status(500, &[]), status(200, &[])]).1, 500);
        assert_eq!(ask(Method::Post, vec![status(429, &[]), status(200, &[])]).1, 200);
    }

    #[test]
    fn a_service_that_asks_for_time_gets_it_within_reason() {
        let busy = |wait| vec![status(429, &[("retry-after", wait)]), status(200, &[])];
        assert_eq!(ask(Method::Post, busy("7")), (0, 200, Duration::from_secs(7)));
        assert_eq!(ask(Method::Post, busy("700")), (1, 429, Duration::ZERO));
        assert_eq!(ask(Method::Post, busy("-1")).1, 200, "nonsense is not kept to");
    }
}
