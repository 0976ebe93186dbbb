//! Who may ask: whoever has the token, from this machine, from our own page or from no page.

use axum::extract::{Request, State};
use axum::http::header::{HOST, ORIGIN};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::Response;

use super::answers::Refusal;
use super::room::Room;

/// The header that carries the token.
pub(crate) const TOKEN: &str = "x-kinfold-token";
/// What browsers say of where a question comes from.
const SITE: &str = "sec-fetch-site";
/// What browsers say of what an answer is for.
const MODE: &str = "sec-fetch-mode";

/// Lets through what comes from our page, or from a program that knows the token.
pub(super) async fn guarded(State(room): State<Room>, request: Request, next: Next) -> Response {
    let headers = request.headers();
    let is_page = request.uri().path() == "/";
    if let Err(why) = at_home(headers, &room.hosts, is_page) {
        return why.told(is_page);
    }
    let said = headers.get(TOKEN).and_then(|v| v.to_str().ok()).map(str::to_owned);
    let said = said.or_else(|| asked(request.uri().query().unwrap_or_default()));
    if !said.is_some_and(|said| room.token.is(&said)) {
        let refusal = Refusal::new(StatusCode::UNAUTHORIZED, "the token is missing or wrong");
        let hint = "open the address that `kinfold studio` printed when it began";
        return refusal.hint(hint).told(is_page);
    }
    kept_apart(next.run(request).await)
}

/// The token of a query.
fn asked(query: &str) -> Option<String> {
    query.split('&').find_map(|pair| pair.strip_prefix("token=")).map(str::to_owned)
}

/// A name that leads here from elsewhere, or a page from elsewhere, is refused: neither knows the token,
/// but a browser might be made to bring it.
fn at_home(headers: &HeaderMap, hosts: &[String], is_page: bool) -> Result<(), Refusal> {
    let text = |name: HeaderName| headers.get(name).map(|v| v.to_str().unwrap_or("?"));
    let forbidden = |found: String| {
        Err(Refusal::new(StatusCode::FORBIDDEN, found)
            .hint("the studio answers its own page on this machine, and programs here"))
    };
    let host = text(HOST).unwrap_or_default();
    if !hosts.iter().any(|h| h.eq_ignore_ascii_case(host)) {
        return forbidden(format!(
            "expected to be asked as {}, found `{host}`",
            hosts.join(" or ")
        ));
    }
    if let Some(origin) = text(ORIGIN) {
        let own = origin
            .strip_prefix("http://")
            .is_some_and(|o| hosts.iter().any(|h| h.eq_ignore_ascii_case(o)));
        if !own {
            return forbidden(format!("expected no other origin, found `{origin}`"));
        }
    }
    match text(HeaderName::from_static(SITE)) {
        None | Some("same-origin" | "none") => Ok(()),
        // A link on another page, such as that of a terminal in a browser, may lead to ours.
        Some(_) if is_page && text(HeaderName::from_static(MODE)) == Some("navigate") => Ok(()),
        Some(site) => forbidden(format!("expected no other site, found `{site}`")),
    }
}

/// What every answer says of itself: not kept, not guessed at, not shown elsewhere.
pub(crate) fn kept_apart(mut response: Response) -> Response {
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CACHE_CONTROL, "no-store"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}
