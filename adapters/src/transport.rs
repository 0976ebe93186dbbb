//! The one seam through which anything reaches a network: where calls are recorded and replayed.

use std::fmt;
use std::time::Duration;

use secrecy::SecretString;
use serde::{Deserialize, Serialize};

use crate::net::redact;

/// Sends one request and waits for its answer.
///
/// Promise: what is returned is the whole answer, whatever its status; an error means that no
/// whole answer came. Implementations add no retries of their own: that is a decorator's work.
pub trait Transport: Send + Sync {
    /// Sends it.
    ///
    /// # Errors
    /// [`TransportError`] when no answer came, or one that breaks the request's limits.
    fn send(&self, request: &Request) -> Result<Response, TransportError>;
}

impl<T: Transport + ?Sized> Transport for std::sync::Arc<T> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        (**self).send(request)
    }
}

/// What is sent. Its `Debug` shows no secret, no query and no body.
#[derive(Clone)]
pub struct Request {
    /// What it is for, such as `hunyuan.submit` or `vlm.kinematics/0`: part of its replay key.
    pub step: String,
    /// What is to be done at the address.
    pub method: Method,
    /// Absolute address.
    pub url: String,
    /// Header names (lower case) and values that hold no secret, in order.
    pub headers: Vec<(String, String)>,
    /// Header names (lower case) and values that are secret: sent, and never kept anywhere.
    pub secrets: Vec<(String, SecretString)>,
    /// Body; empty for none.
    pub body: Vec<u8>,
    /// What the answer may cost.
    pub limits: Limits,
}

/// What is to be done at an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "UPPERCASE")]
pub enum Method {
    /// Fetch; repeating it costs nothing.
    Get,
    /// Ask for work; repeating it may cost twice.
    Post,
}

/// What an answer may cost, and where it may come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The whole answer has come by then, or there is none.
    pub deadline: Duration,
    /// Most bytes of its body.
    pub max_bytes: u64,
    /// Whom the address may name.
    pub reach: Reach,
}

/// Whom an address may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Anybody: the user wrote this address down. Redirects are not followed.
    Configured,
    /// Public `https` hosts alone, at every hop: a service's answer named this address.
    Public,
}

impl Request {
    /// A request without headers or body, with a minute and 16 MiB for its answer.
    pub fn new(step: impl Into<String>, method: Method, url: impl Into<String>) -> Self {
        let (deadline, reach) = (Duration::from_secs(60), Reach::Configured);
        Self {
            step: step.into(),
            method,
            url: url.into(),
            headers: vec![],
            secrets: vec![],
            body: vec![],
            limits: Limits { deadline, max_bytes: 16 << 20, reach },
        }
    }

    /// A request that posts JSON.
    pub fn post_json(
        step: impl Into<String>,
        url: impl Into<String>,
        body: &serde_json::Value,
    ) -> Self {
        let mut request = Self::new(step, Method::Post, url);
        request.headers.push(("content-type".into(), "application/json".into()));
        request.body = body.to_string().into_bytes();
        request
    }

    /// Whether it asks for work that may cost; uploads and looks do not.
    pub fn is_work(&self) -> bool {
        !self.is_look() && !self.step.ends_with(".upload")
    }

    /// Whether it only fetches, or asks how a job is doing, which some services want posted.
    pub fn is_look(&self) -> bool {
        self.method == Method::Get || self.step.ends_with(".status")
    }

    /// The same with a secret header, where there is one to send.
    pub fn with_secret(mut self, name: &str, value: Option<SecretString>) -> Self {
        self.secrets.extend(value.map(|v| (name.to_owned(), v)));
        self
    }

    /// The same with other limits.
    pub fn within(mut self, deadline: Duration, max_bytes: u64) -> Self {
        (self.limits.deadline, self.limits.max_bytes) = (deadline, max_bytes);
        self
    }
}

impl fmt::Debug for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let url = redact::url(&self.url);
        write!(f, "{} {:?} {url} ({} bytes)", self.step, self.method, self.body.len())
    }
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

impl Response {
    /// The first header of that (lower-case) name.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }

    /// The media type without its parameters, lower case; empty if none was given.
    pub fn media_type(&self) -> String {
        let given = self.header("content-type").unwrap_or_default();
        given.split(';').next().unwrap_or_default().trim().to_ascii_lowercase()
    }

    /// Whether the status says that it worked.
    pub fn is_success(&self) -> bool {
        (200..300).contains(&self.status)
    }
}

/// What stands at the end of an error where nobody knows whether the work was done.
pub const CHARGED: &str = "it may have been charged";

/// No answer came.
#[derive(
    Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize, Deserialize, schemars::JsonSchema,
)]
#[error("{step}: {host}: {found}")]
pub struct TransportError {
    /// What it was for.
    pub step: String,
    /// Whom it was for, without path or query, which may hold secrets.
    pub host: String,
    /// What happened.
    pub found: String,
    /// Whether asking again later may help.
    pub transient: bool,
    /// Whether the request may have reached its receiver, and so may have been charged.
    pub may_have_arrived: bool,
    /// Whether it was not sent because what may be spent is spent; never part of a record.
    #[serde(skip)]
    #[schemars(skip)]
    pub over_budget: bool,
}

impl TransportError {
    /// Something about a request that asking again does not change, found before it left.
    pub fn refused(request: &Request, found: impl Into<String>) -> Self {
        Self {
            step: request.step.clone(),
            host: redact::host(&request.url),
            found: found.into(),
            transient: false,
            may_have_arrived: false,
            over_budget: false,
        }
    }
}

/// Refuses every request: for `--offline`, and for tests that must not reach out.
#[derive(Clone, Copy, Debug, Default)]
pub struct Deny;

impl Transport for Deny {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        Err(TransportError::refused(request, "the network is switched off for this run"))
    }
}
