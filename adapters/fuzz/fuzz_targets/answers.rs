//! Any bytes as the answers of every service: a result or an error that may be shown, never a crash.
//!
//! The first byte says who answers, the second how. The rest are the answers in their order, with
//! [`BETWEEN`] between two of them; the last one is given again when there are no more.
#![no_main]

mod asked;
mod services;

use std::sync::atomic::{AtomicUsize, Ordering};

use adapters::net::redact;
use adapters::usage::Usage;
use adapters::{AdapterError, Request, Response, Transport, TransportError};
use libfuzzer_sys::fuzz_target;

/// What stands between two answers.
const BETWEEN: &[u8] = b"\xff\xff";

/// Somebody who answers with what stands in a script.
pub struct Script {
    answers: Vec<Vec<u8>>,
    /// Bits 0 to 2: status; 3 and 4: which answers are lost; 5 and 6: media type; 7: whether answers
    /// are what a model said, and come in the envelopes of its protocol.
    how: u8,
    given: AtomicUsize,
}

impl Script {
    fn new(how: u8, mut bytes: &[u8]) -> Self {
        let mut answers = vec![];
        while let Some(at) = bytes.windows(BETWEEN.len()).position(|w| w == BETWEEN) {
            answers.push(bytes[..at].to_vec());
            bytes = &bytes[at + BETWEEN.len()..];
        }
        answers.push(bytes.to_vec());
        Self { answers, how, given: AtomicUsize::new(0) }
    }

    /// Whether answers come in the envelopes of a model's protocol.
    fn is_spoken(&self) -> bool {
        self.how & 0x80 != 0
    }
}

impl Transport for Script {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let given = self.given.fetch_add(1, Ordering::Relaxed);
        let every = [0, 2, 3, 5][usize::from(self.how >> 3 & 3)];
        if every > 0 && given % every == every - 1 {
            let lost = TransportError::refused(request, "the answer stopped before its end");
            return Err(TransportError { transient: true, may_have_arrived: true, ..lost });
        }
        let status = [200, 200, 201, 202, 404, 422, 429, 500][usize::from(self.how & 7)];
        let media = ["application/json", "model/gltf-binary", "text/event-stream", "text/html"];
        let media = media[usize::from(self.how >> 5 & 3)];
        let headers = vec![("content-type".to_owned(), media.to_owned())];
        let last = self.answers.len().saturating_sub(1);
        let body = self.answers.get(given.min(last)).cloned().unwrap_or_default();
        let body = if self.is_spoken() { asked::enveloped(&request.url, &body) } else { body };
        let response = Response { status, headers, body };
        // Whoever else reads an answer reads this one.
        let _ = Usage::reported(&response);
        let kept = redact::body(&response.body, &request.secrets);
        // What a service that was sent no key says is no key.
        let was_sent = redact::sentence("canary-key", &request.secrets) != "canary-key";
        assert!(!(was_sent && holds(&kept, b"canary-key")), "a key was kept");
        Ok(response)
    }
}

fn holds(text: &[u8], word: &[u8]) -> bool {
    text.windows(word.len()).any(|w| w == word)
}

/// An error may be shown to anybody on any terminal. What a service says of a key of its own accord
/// is kept from errors elsewhere.
fn may_be_shown(error: &AdapterError, bytes: &[u8]) {
    let told = format!("{error}");
    assert!(holds(bytes, b"canary-key") || !told.contains("canary-key"), "{told}");
    assert!(!told.contains('\u{1b}'), "a terminal would obey: {told:?}");
    assert!(told.len() < 20_000, "{} bytes", told.len());
}

fuzz_target!(|bytes: &[u8]| {
    let [who, how, rest @ ..] = bytes else { return };
    let script = Script::new(*how, rest);
    let error = match who % 16 {
        who @ 0..10 => services::ask(who, script).err(),
        who => asked::ask(who - 10, script).err(),
    };
    error.iter().for_each(|error| may_be_shown(error, bytes));
});
