//! Every reader of every service's answers, on answers that are damaged in every way: a value or an
//! error, never a panic, nothing paid for twice and nothing told that opens doors.

use std::sync::{Arc, Mutex};

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

use super::bench::{ALL, Bench, photo};
use super::fake::{Fake, Trouble};
use crate::damage::{misshapen, misshapen_events, torn};
use crate::net::redact;
use crate::usage::Usage;
use crate::{Request, Response, Transport, TransportError};

/// How answers are damaged.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Damage {
    /// They stay what they are by their form: JSON, or a stream of events.
    Shape,
    /// They need not be anything.
    Bytes,
}

/// Passes some of a service's answers on as they are, and others damaged.
struct Damaging {
    fake: Arc<Fake>,
    damage: Damage,
    rng: Mutex<Pcg64Mcg>,
}

impl Transport for Damaging {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let mut response = self.fake.send(request)?;
        let mut rng = self.rng.lock().unwrap();
        if rng.random_range(0..3) == 0 {
            let damage = match (self.damage, response.media_type().as_str()) {
                (Damage::Bytes, _) => torn,
                (Damage::Shape, "text/event-stream") => misshapen_events,
                (Damage::Shape, _) => misshapen,
            };
            response.body = damage(&response.body, &mut rng);
        }
        // Whoever else reads an answer reads this one.
        let _ = (Usage::reported(&response), redact::body(&response.body, &request.secrets));
        Ok(response)
    }
}

/// Asks every service many times through damage; gives what was told where nothing came of it.
fn told_of(damage: Damage, times: u64) -> Vec<String> {
    let mut told = vec![];
    for (protocol, seed) in ALL.into_iter().flat_map(|p| (0..times).map(move |seed| (p, seed))) {
        let trouble = [Trouble::None, Trouble::Dead, Trouble::LooksLost][seed as usize % 3];
        let bench = Bench::new(protocol, trouble);
        let rng = Mutex::new(Pcg64Mcg::seed_from_u64(seed));
        let damaging = Damaging { fake: Arc::clone(&bench.fake), damage, rng };
        match bench.adapter_through(Arc::new(damaging)).generate(&photo(), 7) {
            Ok(made) => assert!(made.file.starts_with(b"glTF"), "{protocol:?} {seed}"),
            Err(error) => told.push(format!("{protocol:?} {seed}: {error} {error:?}")),
        }
        assert!(bench.counts()[0] <= 1, "{protocol:?} {seed}: asked for more than once");
    }
    told
}

#[test]
fn no_misshapen_answer_makes_a_reader_panic_or_tell_what_opens_doors() {
    let told = told_of(Damage::Shape, 300);
    assert!(told.len() > 300, "the damage must be felt, found {} errors", told.len());
    for told in told {
        assert!(!told.contains("canary"), "{told}");
        assert!(!told.contains('\u{1b}'), "a terminal would obey: {told}");
        assert!(told.len() < 4000, "{} bytes: {}", told.len(), &told[..200]);
    }
}

#[test]
fn no_torn_answer_makes_a_reader_panic() {
    assert!(told_of(Damage::Bytes, 300).len() > 300);
}
