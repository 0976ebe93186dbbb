//! Reads a service's answers, error pages and broken JSON included.

use serde_json::Value;

use crate::net::redact;
use crate::{AdapterError, Response};

/// Longest piece of a service's own words that is passed on, characters.
const MAX_WORDS: usize = 300;

/// Who was asked for what: the beginning of every complaint about an answer.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// Provider.
    pub provider: &'a str,
    /// Step.
    pub step: &'a str,
}

impl Asked<'_> {
    /// An answer that breaks a rule; what was found is told as far as it may be.
    pub fn broke(&self, rule: &'static str, found: impl Into<String>) -> AdapterError {
        let (provider, step) = (self.provider.into(), self.step.into());
        let found = shortened(&found.into());
        AdapterError::Service { provider, step, rule, found, status: None }
    }

    /// An answer whose status says that it did not work.
    pub fn refused(&self, response: &Response) -> AdapterError {
        let (provider, step) = (self.provider.into(), self.step.into());
        let found = format!("{} {}", response.status, words(response));
        let (rule, status) = ("the answer must be a success", Some(response.status));
        AdapterError::Service { provider, step, rule, found, status }
    }

    /// The JSON of an answer that worked.
    ///
    /// # Errors
    /// [`AdapterError::Service`] for an error status, another type or broken JSON.
    pub fn json(&self, response: &Response) -> Result<Value, AdapterError> {
        if !response.is_success() {
            return Err(self.refused(response));
        }
        serde_json::from_slice(&response.body).map_err(|e| {
            let found = format!("{} ({e})", words(response));
            self.broke("the answer must be JSON", found)
        })
    }

    /// A text in an answer.
    ///
    /// # Errors
    /// [`AdapterError::Service`] where there is none.
    pub fn text<'v>(
        &self,
        value: &'v Value,
        pointer: &str,
        rule: &'static str,
    ) -> Result<&'v str, AdapterError> {
        let text = value.pointer(pointer).and_then(Value::as_str);
        text.ok_or_else(|| self.broke(rule, shortened(&value.to_string())))
    }
}

/// What an answer says of itself: the message of an error in JSON, else its type and beginning.
pub fn words(response: &Response) -> String {
    let json: Option<Value> = serde_json::from_slice(&response.body).ok();
    let spoken = ["/error/message", "/message", "/detail", "/text", "/error", "/errors"];
    let told = json.as_ref().and_then(|j| spoken.iter().find_map(|p| j.pointer(p)));
    if let Some(told) = told {
        return shortened(told.as_str().unwrap_or(&told.to_string()));
    }
    if response.body.is_empty() {
        return "an empty answer".into();
    }
    let media = response.media_type();
    match media.as_str() {
        "text/html" => "an HTML page".into(),
        "application/json" | "text/plain" | "" => {
            shortened(&String::from_utf8_lossy(&response.body))
        }
        _ => format!("{} bytes of {media}", response.body.len()),
    }
}

/// The beginning of a text on one line, without what a terminal would obey and what opens doors.
pub fn shortened(text: &str) -> String {
    let text = redact::words(text);
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    guard::text::brief(&plain, MAX_WORDS).into_owned()
}
