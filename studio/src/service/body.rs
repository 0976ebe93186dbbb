//! Bodies of requests: bounded, and not slower than they may be.

use std::pin::Pin;
use std::time::Duration;

use axum::body::{Body, Bytes};
use axum::extract::Request;
use axum::http::{StatusCode, header};
use futures_core::Stream as _;
use serde::de::DeserializeOwned;
use tokio::time::{Instant, timeout_at};

use super::room::LISTED;
use crate::http::answers::Refusal;

/// The least bytes a second that a body comes with, once its sender's patience is over. A guess: a tenth of
/// what a poor mobile connection sends.
const SLOWEST: f64 = 16384.0;
/// Most bytes of a question in JSON: a condition of the longest, and its wrapping.
const MOST_JSON: u64 = 4 << 20;

/// A body that is read piece by piece.
pub(super) struct Pieces {
    stream: axum::body::BodyDataStream,
    most: u64,
    got: u64,
    began: Instant,
    patience: Duration,
}

impl Pieces {
    /// The body of a request, unless it says itself that it is too long.
    pub(super) fn of(request: Request, most: u64, patience: Duration) -> Result<Self, Refusal> {
        let said = request.headers().get(header::CONTENT_LENGTH).and_then(|v| v.to_str().ok());
        let said: Option<u64> = said.and_then(|said| said.parse().ok());
        if let Some(said) = said.filter(|&said| said > most) {
            return Err(too_long(most, &format!("{said}")));
        }
        let body: Body = request.into_body();
        let (stream, began) = (body.into_data_stream(), Instant::now());
        Ok(Self { stream, most, got: 0, began, patience })
    }

    /// The next piece; none at the end.
    pub(super) async fn next(&mut self) -> Result<Option<Bytes>, Refusal> {
        let due = Duration::from_secs_f64(self.got as f64 / SLOWEST);
        let stream = &mut self.stream;
        let next = std::future::poll_fn(|context| Pin::new(&mut *stream).poll_next(context));
        let Ok(next) = timeout_at(self.began + self.patience + due, next).await else {
            let found = format!("the body came too slowly: {} bytes so far", self.got);
            return Err(Refusal::new(StatusCode::REQUEST_TIMEOUT, found)
                .hint("send it again; the same file is kept once"));
        };
        let Some(piece) = next else { return Ok(None) };
        let piece = piece.map_err(|e| {
            Refusal::new(StatusCode::BAD_REQUEST, format!("the body broke off: {e}"))
        })?;
        self.got = self.got.saturating_add(piece.len() as u64);
        if self.got > self.most {
            return Err(too_long(self.most, "more"));
        }
        Ok(Some(piece))
    }
}

fn too_long(most: u64, found: &str) -> Refusal {
    let found = format!("expected a body of at most {most} bytes, found {found}");
    Refusal::new(StatusCode::PAYLOAD_TOO_LARGE, found)
        .hint("`/v1/about` says how long a file may be")
}

/// What a request asks, as JSON.
pub(super) async fn json<T: DeserializeOwned>(
    request: Request,
    patience: Duration,
) -> Result<T, Refusal> {
    let mut pieces = Pieces::of(request, MOST_JSON, patience)?;
    let mut all = Vec::new();
    while let Some(piece) = pieces.next().await? {
        all.extend_from_slice(&piece);
    }
    serde_json::from_slice(&all).map_err(|e| {
        Refusal::new(StatusCode::BAD_REQUEST, format!("the question: {e}")).hint(LISTED)
    })
}
