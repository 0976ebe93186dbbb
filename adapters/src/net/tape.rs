//! Every call written down as it may be kept, and played back without a network.

use std::collections::BTreeMap;
use std::sync::Mutex;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trace::Digest;

use super::redact;
use super::redactor::Redactor;
use crate::transport::{Method, Request, Response, Transport, TransportError};

/// One request and what came of it, as it may be kept: no secret, bodies by their digests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Exchange {
    /// What it was for.
    pub step: String,
    /// What was to be done.
    pub method: Method,
    /// The address, redacted.
    pub url: String,
    /// The headers that may be kept.
    pub headers: Vec<(String, String)>,
    /// The redacted body.
    pub body: Digest,
    /// Name of the request in this record: the digest of step, method, address and body.
    pub key: Digest,
    /// What came of it.
    pub outcome: Outcome,
}

/// What came of a request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// An answer.
    Answered {
        /// HTTP status.
        status: u16,
        /// The headers that may be kept.
        headers: Vec<(String, String)>,
        /// The redacted body.
        body: Digest,
    },
    /// None.
    Unanswered(TransportError),
}

/// Bodies by their digests.
pub type Bodies = BTreeMap<Digest, Vec<u8>>;

/// Keeps what is recorded.
pub trait Tape: Send + Sync {
    /// Keeps one exchange and the bodies it names.
    ///
    /// # Errors
    /// Why it cannot be kept; the call then counts as failed, for a record with gaps is none.
    fn keep(&self, exchange: Exchange, bodies: Bodies) -> Result<(), String>;
}

impl<T: Tape + ?Sized> Tape for std::sync::Arc<T> {
    fn keep(&self, exchange: Exchange, bodies: Bodies) -> Result<(), String> {
        (**self).keep(exchange, bodies)
    }
}

/// A tape in memory.
#[derive(Debug, Default)]
pub struct MemoryTape(Mutex<(Vec<Exchange>, Bodies)>);

impl MemoryTape {
    /// What was kept so far.
    pub fn contents(&self) -> (Vec<Exchange>, Bodies) {
        self.0.lock().unwrap_or_else(|e| e.into_inner()).clone()
    }
}

impl Tape for MemoryTape {
    fn keep(&self, exchange: Exchange, bodies: Bodies) -> Result<(), String> {
        let mut kept = self.0.lock().unwrap_or_else(|e| e.into_inner());
        kept.0.push(exchange);
        kept.1.extend(bodies);
        Ok(())
    }
}

/// Writes every call down before its answer is used.
pub struct Recorded<T, S> {
    /// Who is asked.
    pub inner: T,
    /// Where it is kept.
    pub tape: S,
}

impl<T: Transport, S: Tape> Transport for Recorded<T, S> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let outcome = self.inner.send(request);
        let (exchange, bodies) = written_down(request, &outcome);
        let as_kept = match &exchange.outcome {
            Outcome::Answered { body, .. } => bodies.get(body).cloned(),
            Outcome::Unanswered(_) => None,
        };
        let kept = self.tape.keep(exchange, bodies);
        kept.map_err(|found| {
            let found = format!("the call cannot be recorded: {found}");
            TransportError { may_have_arrived: true, ..TransportError::refused(request, found) }
        })?;
        match (outcome, as_kept) {
            (Ok(response), Some(body)) if is_used_as_kept(&request.step) => {
                Ok(Response { body, ..response })
            }
            (outcome, _) => outcome,
        }
    }
}

/// Whether an answer is used as it stands on record: a model's, so that it says the same when it is
/// answered from there. What a service says of a job may hold addresses of which a part is hidden.
pub(super) fn is_used_as_kept(step: &str) -> bool {
    step.starts_with("vlm.")
}

pub(super) fn written_down(
    request: &Request,
    outcome: &Result<Response, TransportError>,
) -> (Exchange, Bodies) {
    let mut bodies = Bodies::new();
    let redactor = redact::of(&request.secrets);
    let mut keep = |bytes: &[u8]| {
        let bytes = redact::kept_body(bytes, &redactor);
        let digest = Digest::of(&bytes);
        bodies.insert(digest.clone(), bytes);
        digest
    };
    let body = keep(&request.body);
    let outcome = match outcome {
        Ok(r) => {
            let hide = |(n, v): (String, String)| (n, redactor.text(&v).into_owned());
            let headers = redact::response_headers(&r.headers).into_iter().map(hide).collect();
            Outcome::Answered { status: r.status, headers, body: keep(&r.body) }
        }
        Err(e) => Outcome::Unanswered(e.clone()),
    };
    let exchange = Exchange {
        step: request.step.clone(),
        method: request.method,
        url: redactor.text(&redact::url(&request.url)).into_owned(),
        headers: redact::request_headers(&request.headers),
        key: key(request, &redactor, &body),
        body,
        outcome,
    };
    (exchange, bodies)
}

fn key(request: &Request, redactor: &Redactor, body: &Digest) -> Digest {
    let url = redactor.text(&redact::url(&request.url)).into_owned();
    named(&request.step, request.method, &url, body)
}

fn named(step: &str, method: Method, url: &str, body: &Digest) -> Digest {
    let words = serde_json::json!([step, method, url, body]);
    Digest::of(words.to_string().as_bytes())
}

/// The name a request has in a record.
pub(super) fn key_of(request: &Request) -> Digest {
    let redactor = redact::of(&request.secrets);
    let body = Digest::of(&redact::kept_body(&request.body, &redactor));
    key(request, &redactor, &body)
}

impl Exchange {
    /// The key it should have.
    pub(super) fn own_key(&self) -> Digest {
        named(&self.step, self.method, &self.url, &self.body)
    }
}

/// Answers every request as it was answered before, by its key: what was never asked is an error,
/// never a guess.
///
/// A record may hold earlier tries of a question, lost, refused, given up or set aside. What a
/// request came to last is what the run went on with, so that is what counts.
pub struct Replayed {
    exchanges: Vec<Exchange>,
    bodies: Bodies,
}

impl Replayed {
    /// Plays back what a tape kept.
    pub fn new(exchanges: Vec<Exchange>, bodies: Bodies) -> Self {
        Self { exchanges, bodies }
    }

    /// What a request came to last.
    fn last(&self, key: &Digest) -> Option<&Exchange> {
        self.exchanges.iter().rfind(|e| e.key == *key)
    }

    /// What a request that was never asked differs in from the ones recorded.
    fn difference(&self, request: &Request) -> String {
        let asked = redact::body(&request.body, &request.secrets);
        let Some(near) = self.exchanges.iter().find(|e| e.step == request.step) else {
            let steps: Vec<_> = self.exchanges.iter().map(|e| e.step.as_str()).collect();
            return format!("the record has no such step; it has {}", steps.join(", "));
        };
        let url = redact::url(&request.url);
        if url != near.url || near.method != request.method {
            return format!(
                "recorded was {:?} {}, asked is {:?} {url}",
                near.method, near.url, request.method
            );
        }
        let recorded = self.bodies.get(&near.body).map(Vec::as_slice).unwrap_or_default();
        let parse = |b: &[u8]| serde_json::from_slice::<serde_json::Value>(b).ok();
        let place = parse(recorded).zip(parse(&asked)).and_then(|(r, a)| first_difference(&r, &a));
        let place = place.map_or_else(|| "its body".to_owned(), |p| format!("its body at `{p}`"));
        format!("the recorded request differs in {place}")
    }
}

/// JSON pointer of the first place where two values differ.
fn first_difference(a: &serde_json::Value, b: &serde_json::Value) -> Option<String> {
    use serde_json::Value::{Array, Object};
    let below = |key: &str, a, b| Some(format!("/{key}{}", first_difference(a, b)?));
    match (a, b) {
        _ if a == b => None,
        (Object(x), Object(y)) if x.keys().eq(y.keys()) => {
            x.iter().find_map(|(k, v)| below(k, v, y.get(k)?))
        }
        (Array(x), Array(y)) if x.len() == y.len() => {
            x.iter().zip(y).enumerate().find_map(|(i, (v, w))| below(&i.to_string(), v, w))
        }
        _ => Some(String::new()),
    }
}

impl Transport for Replayed {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let redactor = redact::of(&request.secrets);
        let body = Digest::of(&redact::kept_body(&request.body, &redactor));
        let Some(exchange) = self.last(&key(request, &redactor, &body)) else {
            let found = format!("not in the record: {}", self.difference(request));
            return Err(TransportError::refused(request, found));
        };
        match &exchange.outcome {
            Outcome::Unanswered(error) => Err(error.clone()),
            Outcome::Answered { status, headers, body } => {
                let lost = || {
                    TransportError::refused(request, format!("the record lacks the body {body}"))
                };
                let body = self.bodies.get(body).ok_or_else(lost)?.clone();
                Ok(Response { status: *status, headers: headers.clone(), body })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use secrecy::SecretString;
    use serde_json::json;

    use super::*;
    use crate::transport::Deny;

    const CANARY: &str = "canary-0123456789";

    /// Says everything back that it was told, and counts.
    #[derive(Default)]
    struct Echo(Mutex<u32>);

    impl Transport for Echo {
        fn send(&self, request: &Request) -> Result<Response, TransportError> {
            let mut count = self.0.lock().unwrap();
            *count += 1;
            let body =
                json!({ "n": *count, "url": request.url, "auth": format!("Bearer {CANARY}") });
            let headers = vec![
                ("content-type".into(), "application/json".into()),
                ("x-request-id".into(), format!("for {CANARY}")),
                ("set-cookie".into(), CANARY.into()),
            ];
            Ok(Response { status: 200, headers, body: body.to_string().into_bytes() })
        }
    }

    fn request(body: &str) -> Request {
        let url = format!("https://h.example/a?token={CANARY}");
        let key = SecretString::from(format!("Bearer {CANARY}"));
        Request::post_json("step", url, &json!({ "ask": { "words": body } }))
            .with_secret("authorization", Some(key))
    }

    #[test]
    fn what_was_recorded_plays_back_in_order_and_holds_no_secret() {
        let tape = Arc::new(MemoryTape::default());
        let recorded = Recorded { inner: Echo::default(), tape: tape.clone() };
        for _ in 0..2 {
            recorded.send(&request("x")).unwrap();
        }
        let (exchanges, bodies) = tape.contents();
        let written = serde_json::to_string(&exchanges).unwrap();
        assert!(!written.contains("canary"), "{written}");
        assert!(bodies.values().all(|b| !String::from_utf8_lossy(b).contains("canary")));

        let replayed = Replayed::new(exchanges, bodies);
        let count = || {
            let response = replayed.send(&request("x")).unwrap();
            serde_json::from_slice::<serde_json::Value>(&response.body).unwrap()["n"].clone()
        };
        assert_eq!([count(), count()], [2, 2], "the last answer, as often as it is asked for");
    }

    #[test]
    fn what_a_request_came_to_last_counts() {
        let tape = Arc::new(MemoryTape::default());
        let recorded = Recorded { inner: Echo::default(), tape: tape.clone() };
        for step in ["submit", "look", "submit", "look", "look"] {
            recorded.send(&request(step)).unwrap();
        }
        let (exchanges, bodies) = tape.contents();
        let replayed = Replayed::new(exchanges, bodies);
        let played = ["submit", "look", "look", "look"].map(|step| {
            let body = replayed.send(&request(step)).unwrap().body;
            serde_json::from_slice::<serde_json::Value>(&body).unwrap()["n"].clone()
        });
        assert_eq!(played, [3, 5, 5, 5]);
    }

    #[test]
    fn a_signed_address_out_of_a_record_finds_its_own_exchange() {
        let tape = Arc::new(MemoryTape::default());
        let recorded = Recorded { inner: Echo::default(), tape: tape.clone() };
        let signed = "https://cdn.example/m.glb?Signature=abc&type=glb";
        recorded.send(&Request::new("download", Method::Get, signed)).unwrap();
        let (exchanges, bodies) = tape.contents();
        let kept = redact::url(signed);
        let replayed = Replayed::new(exchanges, bodies);
        replayed.send(&Request::new("download", Method::Get, kept)).unwrap();
    }

    #[test]
    fn what_was_never_asked_is_an_error_that_names_the_difference() {
        let tape = Arc::new(MemoryTape::default());
        let recorded = Recorded { inner: Echo::default(), tape: tape.clone() };
        recorded.send(&request("x")).unwrap();
        let (exchanges, bodies) = tape.contents();
        let replayed = Replayed::new(exchanges, bodies);
        let error = replayed.send(&request("y")).unwrap_err().to_string();
        assert!(error.ends_with("differs in its body at `/ask/words`"), "{error}");
        let other = Request::new("elsewhere", Method::Get, "https://h.example/a");
        assert!(replayed.send(&other).unwrap_err().found.contains("it has step"));
    }

    #[test]
    fn a_failure_is_recorded_and_replayed_as_the_same_failure() {
        let tape = Arc::new(MemoryTape::default());
        let recorded = Recorded { inner: Deny, tape: tape.clone() };
        let error = recorded.send(&request("x")).unwrap_err();
        let (exchanges, bodies) = tape.contents();
        assert_eq!(Replayed::new(exchanges, bodies).send(&request("x")).unwrap_err(), error);
    }

    #[test]
    fn a_call_that_cannot_be_recorded_has_failed() {
        struct Full;
        impl Tape for Full {
            fn keep(&self, _: Exchange, _: Bodies) -> Result<(), String> {
                Err("the disk is full".into())
            }
        }
        let error =
            Recorded { inner: Echo::default(), tape: Full }.send(&request("x")).unwrap_err();
        assert!(error.may_have_arrived && error.found.ends_with("the disk is full"), "{error}");
    }
}
