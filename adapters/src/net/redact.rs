//! What may be written down of a request and its answer; everything else is left out.

use secrecy::SecretString;
use serde_json::Value;
use ureq::http::Uri;

use super::hidden::{HIDDEN, QUERY_KEYS};
use super::redactor::Redactor;

/// Request headers that may be kept.
const REQUEST_HEADERS: [&str; 4] = ["accept", "anthropic-version", "content-type", "user-agent"];
/// Response headers that may be kept; names that begin with one of the last two as well.
const RESPONSE_HEADERS: [&str; 9] = [
    "content-length",
    "content-type",
    "openai-processing-ms",
    "request-id",
    "retry-after",
    "retry-after-ms",
    "x-fal-billable-units",
    "x-fal-request-id",
    "x-request-id",
];
const RESPONSE_PREFIXES: [&str; 2] = ["x-ratelimit-", "anthropic-ratelimit-"];
/// Keys of an answer whose values open doors.
const SECRET_KEYS: [&str; 8] = [
    "access_token",
    "session_token",
    "sts_ak",
    "sts_sk",
    "subscription_key",
    "token",
    "upload_url",
    "webhook_secret",
];

/// The host and port of an address, or what stands for an address that is none.
pub fn host(url: &str) -> String {
    let uri: Option<Uri> = url.parse().ok();
    let authority = uri.and_then(|u| u.into_parts().authority);
    let bare = |a: &ureq::http::uri::Authority| {
        a.port().map_or_else(|| a.host().to_owned(), |p| format!("{}:{p}", a.host()))
    };
    authority.as_ref().map_or_else(|| "an address that is none".to_owned(), bare)
}

/// An address without user, fragment and the values of its query, save those known to be harmless.
/// Of an address out of a record it is the address itself.
pub fn url(text: &str) -> String {
    // What stands for a hidden value is itself no part of an address.
    let text = &text.replace(HIDDEN, "hidden");
    let Ok(uri) = text.parse::<Uri>() else { return HIDDEN.to_owned() };
    let scheme = uri.scheme_str().unwrap_or("https");
    let path = uri.path();
    let plain = format!("{scheme}://{}{path}", host(text));
    match uri.query() {
        Some(query) => format!("{plain}?{}", redacted_query(query)),
        None => plain,
    }
}

fn redacted_query(query: &str) -> String {
    let pair = |pair: &str| match pair.split_once('=') {
        Some((key, value)) if QUERY_KEYS.contains(&key) => format!("{key}={value}"),
        Some((key, _)) => format!("{key}={HIDDEN}"),
        None => HIDDEN.to_owned(),
    };
    query.split('&').map(pair).collect::<Vec<_>>().join("&")
}

/// The request headers that may be kept.
pub fn request_headers(headers: &[(String, String)]) -> Vec<(String, String)> {
    headers.iter().filter(|(n, _)| REQUEST_HEADERS.contains(&n.as_str())).cloned().collect()
}

/// The response headers that may be kept.
pub fn response_headers(headers: &[(String, String)]) -> Vec<(String, String)> {
    let known = |name: &str| {
        RESPONSE_HEADERS.contains(&name) || RESPONSE_PREFIXES.iter().any(|p| name.starts_with(p))
    };
    headers.iter().filter(|(n, _)| known(n)).cloned().collect()
}

/// A body as it may be kept: in JSON, queries of addresses and values of keys that open doors are
/// hidden; and nowhere stands one of `secrets` in any form.
pub fn body(bytes: &[u8], secrets: &[(String, SecretString)]) -> Vec<u8> {
    kept_body(bytes, &of(secrets))
}

/// The same, by whoever takes the secrets out.
pub fn kept_body(bytes: &[u8], redactor: &Redactor) -> Vec<u8> {
    let hidden = match serde_json::from_slice::<Value>(bytes) {
        Ok(mut value) if value.is_object() || value.is_array() => {
            if hide(&mut value) {
                value.to_string().into_bytes()
            } else {
                bytes.to_vec()
            }
        }
        _ => bytes.to_vec(),
    };
    redactor.body(hidden)
}

/// Whoever takes a request's secrets out.
pub fn of(secrets: &[(String, SecretString)]) -> Redactor {
    Redactor::new(secrets.iter().map(|(_, secret)| secret))
}

/// A service's words as they may be passed on: addresses in them without what may open doors.
pub fn words(text: &str) -> String {
    let quoted: Option<Value> = is_json(text).then(|| serde_json::from_str(text).ok()).flatten();
    let quoted = quoted.and_then(|mut value| hide(&mut value).then(|| value.to_string()));
    let text = quoted.as_deref().unwrap_or(text);
    let ends = |c: char| c.is_whitespace() || "\"'<>()[]{}|".contains(c);
    let mut told = String::new();
    for piece in text.replace(HIDDEN, "hidden").split_inclusive(ends) {
        let word = piece.trim_end_matches(ends);
        let shown = if word.contains("://") { url(word) } else { word.to_owned() };
        told.push_str(&shown);
        told.push_str(&piece[word.len()..]);
    }
    told
}

/// A sentence as it may be shown: nowhere stands one of `secrets` in any form.
pub fn sentence(text: &str, secrets: &[(String, SecretString)]) -> String {
    of(secrets).text(text).into_owned()
}

/// Hides what must not be kept; says whether anything was.
fn hide(value: &mut Value) -> bool {
    match value {
        Value::Array(items) => items.iter_mut().fold(false, |any, item| hide(item) | any),
        Value::Object(map) => map.iter_mut().fold(false, |any, (k, v)| hide_entry(k, v) | any),
        Value::String(text) if is_json(text) => {
            // Some services quote an answer in an answer.
            let Ok(mut inner) = serde_json::from_str::<Value>(text) else { return false };
            let changed = hide(&mut inner);
            if changed {
                *text = inner.to_string();
            }
            changed
        }
        Value::String(text) if text.contains("://") && text.contains('?') => {
            let redacted = url(text);
            let changed = redacted != *text;
            *text = redacted;
            changed
        }
        _ => false,
    }
}

/// Whether a text looks like JSON that holds something.
fn is_json(text: &str) -> bool {
    let text = text.trim();
    (text.starts_with('{') && text.ends_with('}')) || (text.starts_with('[') && text.ends_with(']'))
}

fn hide_entry(key: &str, value: &mut Value) -> bool {
    let key = key.to_ascii_lowercase();
    let opens = SECRET_KEYS.contains(&key.as_str()) || key.starts_with("secret");
    if opens && value.is_string() {
        *value = HIDDEN.into();
        return true;
    }
    hide(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_keeps_its_path_and_no_value_of_its_query() {
        let signed = "https://me:pw@cdn.example:8443/a/b.glb?X-Amz-Signature=abc&filename=b.glb&x";
        let expected =
            "https://cdn.example:8443/a/b.glb?X-Amz-Signature=<redacted>&filename=b.glb&<redacted>";
        assert_eq!(url(signed), expected);
        assert_eq!(url(expected), expected, "what is redacted stays as it is");
        assert_eq!(host(signed), "cdn.example:8443");
        assert_eq!(url("\u{0}"), HIDDEN);
    }

    #[test]
    fn only_known_headers_are_kept() {
        let pairs = |names: &[&str]| -> Vec<(String, String)> {
            names.iter().map(|n| (n.to_string(), "v".into())).collect()
        };
        let kept = request_headers(&pairs(&["authorization", "content-type", "x-custom"]));
        assert_eq!(kept, pairs(&["content-type"]));
        let kept = response_headers(&pairs(&["set-cookie", "x-ratelimit-reset", "retry-after"]));
        assert_eq!(kept, pairs(&["x-ratelimit-reset", "retry-after"]));
    }

    #[test]
    fn who_signed_and_the_signature_are_hidden_and_the_date_is_not() {
        let header = "TC3-HMAC-SHA256 Credential=canary-id/2019-02-25/ai3d/tc3_request, \
                      SignedHeaders=content-type;host, Signature=canary00ff";
        let secrets = [("authorization".to_owned(), SecretString::from(header.to_owned()))];
        let told = sentence("canary-id signed canary00ff on 2019-02-25", &secrets);
        assert_eq!(told, "<redacted> signed <redacted> on 2019-02-25");
    }

    #[test]
    fn an_address_in_a_sentence_loses_its_query_and_nothing_else_changes() {
        let told = words("no file at <https://c.example/m.glb?sig=abc>, ask (later)");
        assert_eq!(told, "no file at <https://c.example/m.glb?sig=<redacted>>, ask (later)");
        assert_eq!(words("plain words  stay"), "plain words  stay");
        assert_eq!(words(r#"{"access_token":"t0k","n":1}"#), r#"{"access_token":"hidden","n":1}"#);
    }

    #[test]
    fn signed_addresses_and_door_keys_inside_an_answer_are_hidden() {
        let answer =
            br#"{"model":{"url":"https://c.example/m.glb?sig=abc"},"Access_Token":"t0k","n":1}"#;
        let kept: Value = serde_json::from_slice(&body(answer, &[])).unwrap();
        assert_eq!(kept["model"]["url"], "https://c.example/m.glb?sig=<redacted>");
        assert_eq!(kept["Access_Token"], HIDDEN);
        let quoted = serde_json::json!({ "message": r#"{"access_token":"t0k"}"# }).to_string();
        assert!(!String::from_utf8_lossy(&body(quoted.as_bytes(), &[])).contains("t0k"));
        assert_eq!(body(b"{\"n\": 1}", &[]), b"{\"n\": 1}", "what hides nothing keeps its bytes");
    }
}
