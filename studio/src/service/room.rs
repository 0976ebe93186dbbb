//! All that answers need: who may ask, how much, and who makes what is asked for.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::sync::broadcast;

use super::rates::Rates;
use crate::http::Token;
use crate::works::Works;

/// What to do where nothing else is known.
pub(super) const LISTED: &str = "`/v1/openapi.json` lists what can be asked, and how";

/// Jobs whose news a listener may fall behind; it asks anew then.
const BEHIND: usize = 256;

/// What a service answers whom, and how much.
pub struct Service {
    /// Who may ask, by name.
    pub tokens: Vec<(String, Token)>,
    /// How much may be asked.
    pub limits: Limits,
    /// Who makes what is asked for.
    pub works: Arc<dyn Works>,
    /// Rung when something becomes of a job.
    pub bell: Bell,
}

/// How much may be asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Most bytes of a file.
    pub most_bytes: u64,
    /// Most requests a second of a token; twice as many may come at once.
    pub most_requests: f64,
    /// Connections at a time.
    pub connections: usize,
    /// How long a connection may do nothing, a third of it, and a body may be slow.
    pub patience: Duration,
}

/// Tells whoever listens that something became of a job.
#[derive(Clone)]
pub struct Bell(pub(super) broadcast::Sender<(String, String)>);

impl Default for Bell {
    fn default() -> Self {
        Self(broadcast::Sender::new(BEHIND))
    }
}

impl Bell {
    /// Something became of this one's job.
    pub fn ring(&self, who: &str, id: &str) {
        // Nobody may be listening.
        let _ = self.0.send((who.to_owned(), id.to_owned()));
    }
}

/// All that answers need.
pub(crate) struct Inner {
    pub(super) tokens: Vec<(String, Token)>,
    pub(super) limits: Limits,
    pub(super) works: Arc<dyn Works>,
    pub(super) bell: Bell,
    pub(super) rates: Mutex<Rates>,
}

pub(crate) type Desk = Arc<Inner>;

/// The desk of a service.
pub(super) fn desk(service: Service) -> Desk {
    let Service { tokens, limits, works, bell } = service;
    Arc::new(Inner { tokens, limits, works, bell, rates: Mutex::default() })
}
