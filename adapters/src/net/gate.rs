//! One gate a service: so many requests at once, so many a minute, and silence when it asks for it.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::pace::Pace;
use super::redact;
use super::retry::{MAX_ASKED_WAIT, asked_wait};
use crate::transport::{Request, Response, Transport, TransportError};

/// How much a service is asked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rate {
    /// Most requests on their way at once; 4 if left out.
    pub at_once: Option<u32>,
    /// Most requests that begin in a minute; without limit if left out.
    pub per_minute: Option<u32>,
}

/// Most requests on their way at once where nothing is said.
const AT_ONCE: u32 = 4;

/// The gates of all services, by host; shared by everybody in a program.
#[derive(Debug, Default)]
pub struct Gates(Mutex<BTreeMap<String, Arc<Gate>>>);

impl Gates {
    fn of(&self, host: &str) -> Arc<Gate> {
        let mut gates = self.0.lock().unwrap_or_else(|e| e.into_inner());
        Arc::clone(gates.entry(host.to_owned()).or_default())
    }
}

#[derive(Debug, Default)]
struct Gate {
    state: Mutex<Passing>,
    left: Condvar,
}

/// Who is passing, and when the next may begin (by the pace's time).
#[derive(Debug, Default)]
struct Passing {
    inside: u32,
    next: Duration,
}

/// Lets requests through as the gate of their host allows.
pub struct Gated<T> {
    /// Who is asked.
    pub inner: T,
    /// The gates.
    pub gates: Arc<Gates>,
    /// How much this service is asked.
    pub rate: Rate,
    /// Who waits.
    pub pace: Arc<dyn Pace>,
}

impl<T: Transport> Transport for Gated<T> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let gate = self.gates.of(&redact::host(&request.url));
        let _inside = self.enter(&gate);
        let response = self.inner.send(request);
        if let Some(wait) = response.as_ref().ok().and_then(silence) {
            let mut state = gate.state.lock().unwrap_or_else(|e| e.into_inner());
            state.next = state.next.max(self.pace.elapsed().saturating_add(wait));
        }
        response
    }
}

impl<T> Gated<T> {
    /// Waits for a place, then for the time.
    fn enter<'a>(&self, gate: &'a Gate) -> Inside<'a> {
        let most = self.rate.at_once.unwrap_or(AT_ONCE).max(1);
        let state = gate.state.lock().unwrap_or_else(|e| e.into_inner());
        let full = |s: &mut Passing| s.inside >= most;
        let mut state = gate.left.wait_while(state, full).unwrap_or_else(|e| e.into_inner());
        state.inside += 1;
        let now = self.pace.elapsed();
        let wait = state.next.saturating_sub(now);
        let apart = self.rate.per_minute.map_or(Duration::ZERO, |n| MINUTE / n.max(1));
        state.next = state.next.max(now) + apart;
        drop(state);
        if !wait.is_zero() {
            self.pace.wait(wait);
        }
        Inside(gate)
    }
}

const MINUTE: Duration = Duration::from_secs(60);

/// A place behind the gate, given back when it is let go.
struct Inside<'a>(&'a Gate);

impl Drop for Inside<'_> {
    fn drop(&mut self) {
        let mut state = self.0.state.lock().unwrap_or_else(|e| e.into_inner());
        state.inside = state.inside.saturating_sub(1);
        self.0.left.notify_one();
    }
}

/// How long a service that has enough wants to be left alone.
fn silence(response: &Response) -> Option<Duration> {
    let enough = matches!(response.status, 429 | 503);
    enough.then(|| asked_wait(response)).flatten().filter(|w| *w <= MAX_ASKED_WAIT)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use crate::net::pace::{ImaginedPace, RealPace};
    use crate::transport::Method;

    /// Counts who is inside at once.
    #[derive(Default)]
    struct Crowd {
        now: AtomicU32,
        most: AtomicU32,
    }

    impl Transport for Arc<Crowd> {
        fn send(&self, _: &Request) -> Result<Response, TransportError> {
            let now = self.now.fetch_add(1, Ordering::SeqCst) + 1;
            self.most.fetch_max(now, Ordering::SeqCst);
            std::thread::sleep(Duration::from_millis(5));
            self.now.fetch_sub(1, Ordering::SeqCst);
            Ok(Response { status: 200, headers: vec![], body: vec![] })
        }
    }

    #[test]
    fn no_more_are_on_their_way_than_the_service_takes() {
        let crowd = Arc::new(Crowd::default());
        let rate = Rate { at_once: Some(2), per_minute: None };
        let gates = Arc::new(Gates::default());
        std::thread::scope(|scope| {
            for n in 0..7 {
                let (inner, gates) = (Arc::clone(&crowd), Arc::clone(&gates));
                scope.spawn(move || {
                    let pace = Arc::new(RealPace::default());
                    let gated = Gated { inner, gates, rate, pace };
                    gated.send(&Request::new("s", Method::Get, format!("http://h/{n}"))).unwrap();
                });
            }
        });
        assert!(crowd.most.load(Ordering::SeqCst) <= 2);
    }

    struct Says(u16, &'static str);

    impl Transport for Says {
        fn send(&self, _: &Request) -> Result<Response, TransportError> {
            let headers = vec![("retry-after".into(), self.1.into())];
            Ok(Response { status: self.0, headers, body: vec![] })
        }
    }

    fn waited(inner: Says, rate: Rate, requests: usize) -> Duration {
        let pace = Arc::new(ImaginedPace::default());
        let gated = Gated { inner, gates: Arc::default(), rate, pace: pace.clone() };
        for _ in 0..requests {
            gated.send(&Request::new("s", Method::Get, "http://h/")).unwrap();
        }
        pace.elapsed()
    }

    #[test]
    fn requests_begin_as_far_apart_as_their_rate_says() {
        let rate = Rate { at_once: None, per_minute: Some(30) };
        assert_eq!(waited(Says(200, "0"), rate, 4), Duration::from_secs(6));
        assert_eq!(waited(Says(200, "9"), Rate::default(), 4), Duration::ZERO);
    }

    #[test]
    fn a_service_that_wants_silence_gets_it_from_everybody() {
        assert_eq!(waited(Says(429, "7"), Rate::default(), 2), Duration::from_secs(7));
        assert_eq!(waited(Says(429, "7000"), Rate::default(), 2), Duration::ZERO);
    }
}
