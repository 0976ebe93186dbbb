//! The one seam through which anything reaches a network: where calls are recorded and replayed.

/// Sends one request and waits for its answer.
///
/// Promise: what is returned is the whole answer, whatever its status; an error means that no
/// answer came. Implementations add no retries of their own: that is a decorator's work.
pub trait Transport: Send + Sync {
    /// Sends it.
    ///
    /// # Errors
    /// [`TransportError`] when no answer came.
    fn send(&self, request: &Request) -> Result<Response, TransportError>;
}

/// What is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// `GET`, `POST`, `PUT` or `DELETE`.
    pub method: String,
    /// Absolute address.
    pub url: String,
    /// Header names (lower case) and values, in order.
    pub headers: Vec<(String, String)>,
    /// Body; empty for none.
    pub body: Vec<u8>,
}

/// What came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Response {
    /// HTTP status.
    pub status: u16,
    /// Header names (lower case) and values, in order.
    pub headers: Vec<(String, String)>,
    /// Body.
    pub body: Vec<u8>,
}

/// No answer came.
#[derive(Debug, thiserror::Error)]
#[error("{host}: {found}")]
pub struct TransportError {
    /// Whom it was for, without path or query, which may hold secrets.
    pub host: String,
    /// What happened.
    pub found: String,
    /// Whether asking again later may help.
    pub transient: bool,
}
