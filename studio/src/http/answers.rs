//! What is answered when something cannot be done.

use axum::Json;
use axum::extract::rejection::JsonRejection;
use axum::extract::{FromRequest, Request};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use object::condition::ConditionError;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::desk::DeskError;
use crate::house::Failure;
use crate::paper::PaperError;

/// A question that is not answered: why, and what to do.
#[derive(Debug)]
pub(crate) struct Refusal {
    status: StatusCode,
    failure: Failure,
    more: Map<String, Value>,
}

/// What is asked, as JSON; what is none is answered as everything else that cannot be done.
pub(crate) struct Asked<T>(pub(crate) T);

impl<S: Send + Sync, T: serde::de::DeserializeOwned> FromRequest<S> for Asked<T> {
    type Rejection = Refusal;

    async fn from_request(request: Request, state: &S) -> Result<Self, Refusal> {
        let read = Json::<T>::from_request(request, state).await;
        read.map(|Json(asked)| Self(asked)).map_err(|rejection: JsonRejection| {
            Refusal::new(rejection.status(), format!("the question: {}", rejection.body_text()))
                .hint("`/api/openapi.json` says what is asked for, and how")
        })
    }
}

/// Something that is wrong with a condition.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct FaultLine {
    /// Its line in the file, from 1, where it has one.
    pub line: Option<usize>,
    /// The rule and what was found.
    pub message: String,
}

/// All that is wrong with a condition.
pub(crate) fn faults(error: &ConditionError) -> Vec<FaultLine> {
    error.faults().map(|f| FaultLine { line: f.line, message: f.message.clone() }).collect()
}

impl Refusal {
    pub(crate) fn new(status: StatusCode, message: impl Into<String>) -> Self {
        Self { status, failure: Failure::new(message), more: Map::new() }
    }

    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.failure = self.failure.with_hint(hint);
        self
    }

    pub(crate) fn with(mut self, name: &str, value: Value) -> Self {
        self.more.insert(name.to_owned(), value);
        self
    }

    /// The answer: in words where a person opened a page, as JSON otherwise.
    pub(crate) fn told(self, is_page: bool) -> Response {
        if !is_page {
            return self.into_response();
        }
        let Failure { message, hint } = self.failure;
        (self.status, format!("{message}\n{}\n", hint.unwrap_or_default())).into_response()
    }

    /// A question about what is gone by now.
    pub(crate) fn superseded() -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "a newer question was asked meanwhile")
    }

    /// Something of ours that did not go as it must.
    pub(crate) fn broken(message: impl Into<String>) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, message)
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let mut body = self.more;
        body.insert("error".into(), json!(self.failure));
        (self.status, Json(Value::Object(body))).into_response()
    }
}

impl From<Failure> for Refusal {
    fn from(failure: Failure) -> Self {
        Self { status: StatusCode::UNPROCESSABLE_ENTITY, failure, more: Map::new() }
    }
}

impl From<ConditionError> for Refusal {
    fn from(error: ConditionError) -> Self {
        let refusal = Self::new(StatusCode::UNPROCESSABLE_ENTITY, error.to_string());
        refusal.with("faults", json!(faults(&error)))
    }
}

impl From<DeskError> for Refusal {
    fn from(error: DeskError) -> Self {
        match error {
            DeskError::Condition(error) => error.into(),
            DeskError::Model(_) | DeskError::Mesh(_) => {
                Self::new(StatusCode::UNPROCESSABLE_ENTITY, error.to_string())
                    .with("faults", json!([]))
            }
            DeskError::Joint { .. } => Self::new(StatusCode::NOT_FOUND, error.to_string()),
        }
    }
}

impl From<PaperError> for Refusal {
    fn from(error: PaperError) -> Self {
        let status = match &error {
            PaperError::Changed(_) => StatusCode::CONFLICT,
            PaperError::Text(_) => StatusCode::BAD_REQUEST,
            PaperError::Kind { .. } => StatusCode::PAYLOAD_TOO_LARGE,
            PaperError::Io { .. } => StatusCode::INTERNAL_SERVER_ERROR,
        };
        let refusal = Self::new(status, error.to_string());
        match error {
            PaperError::Io { .. } => refusal.hint(
                "make room on the disk, or let the file and its folder be written to; nothing is lost meanwhile",
            ),
            PaperError::Kind { .. } => refusal.hint("put the file back, or begin with another --condition FILE"),
            _ => refusal,
        }
    }
}
