//! Who may ask, and how often: whoever has a token, as often as is agreed.

use std::time::Instant;

use axum::extract::{Request, State};
use axum::http::{StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::room::Desk;
use crate::http::answers::Refusal;
use crate::http::guard::kept_apart;
use crate::http::room::locked;

/// Whose token a request carries.
#[derive(Clone, Debug)]
pub(super) struct Who(pub(super) String);

/// Lets through whoever has a token, as often as is agreed.
pub(super) async fn guarded(
    State(desk): State<Desk>,
    mut request: Request,
    next: Next,
) -> Response {
    let said = request.headers().get(header::AUTHORIZATION).and_then(|v| v.to_str().ok());
    let said = said.and_then(|said| {
        let (scheme, token) = said.split_once(' ')?;
        scheme.eq_ignore_ascii_case("bearer").then(|| token.trim())
    });
    // Every token is compared, so that time does not tell which are nearly right.
    let all = desk.tokens.iter().filter(|(_, token)| said.is_some_and(|said| token.is(said)));
    let Some(who) = all.fold(None, |_, (name, _)| Some(name.clone())) else {
        let refusal = Refusal::new(StatusCode::UNAUTHORIZED, "the token is missing or wrong");
        let refusal =
            refusal.hint("send `Authorization: Bearer TOKEN`, with a token of this service");
        let mut response = refusal.into_response();
        let wanted = axum::http::HeaderValue::from_static("Bearer");
        response.headers_mut().insert(header::WWW_AUTHENTICATE, wanted);
        return kept_apart(response);
    };
    let turn = locked(&desk.rates).take(&who, desk.limits.most_requests, Instant::now());
    if let Err(seconds) = turn {
        let most = desk.limits.most_requests;
        let found = format!("expected at most {most} requests a second, found more");
        let refusal = Refusal::new(StatusCode::TOO_MANY_REQUESTS, found).hint(
            "wait as long as `Retry-After` says, and follow a job instead of asking after it",
        );
        let mut response = refusal.into_response();
        let wait = axum::http::HeaderValue::from(seconds.ceil().clamp(1.0, 3600.0) as u64);
        response.headers_mut().insert(header::RETRY_AFTER, wait);
        return kept_apart(response);
    }
    request.extensions_mut().insert(Who(who));
    kept_apart(next.run(request).await)
}
