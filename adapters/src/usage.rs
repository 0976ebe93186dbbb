//! What a call used, as the service itself reports it: never guessed, never invented.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::transport::Response;

/// Tokens, credits and seconds of one call or of many; unknown is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Usage {
    /// Tokens read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<u64>,
    /// Tokens written, thoughts included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<u64>,
    /// The service's own currency.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub credits: Option<f64>,
    /// Seconds of the service's machines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

/// Where answers say how many tokens were read: OpenAI, Anthropic, Gemini.
const INPUT: [&str; 3] =
    ["/usage/prompt_tokens", "/usage/input_tokens", "/usageMetadata/promptTokenCount"];
/// Where they say how many were written.
const OUTPUT: [&str; 3] =
    ["/usage/completion_tokens", "/usage/output_tokens", "/usageMetadata/candidatesTokenCount"];
/// Written as well, but counted apart: Gemini's thoughts.
const THOUGHTS: &str = "/usageMetadata/thoughtsTokenCount";
/// Where jobs say what they cost: Meshy, Tripo, Tencent.
const CREDITS: [&str; 3] =
    ["/consumed_credits", "/data/credits_consumed", "/Response/ResultCreditConsumed"];
/// Where jobs say how long they took: Replicate.
const SECONDS: &str = "/metrics/total_time";
/// fal's header.
const UNITS: &str = "x-fal-billable-units";

impl Usage {
    /// What an answer reports.
    pub fn reported(response: &Response) -> Self {
        let json = serde_json::from_slice(&response.body).unwrap_or(Value::Null);
        let whole = |p: &&str| json.pointer(p).and_then(Value::as_u64);
        let number = |p: &&str| json.pointer(p).and_then(Value::as_f64).filter(|n| *n >= 0.0);
        let thoughts = whole(&THOUGHTS).unwrap_or(0);
        let units = || response.header(UNITS)?.trim().parse::<f64>().ok();
        Self {
            input: INPUT.iter().find_map(whole),
            output: OUTPUT.iter().find_map(whole).map(|n| n.saturating_add(thoughts)),
            credits: CREDITS.iter().find_map(number).or_else(units),
            seconds: number(&SECONDS),
        }
    }

    /// Whether nothing was reported.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn of(body: &Value, headers: &[(&str, &str)]) -> Usage {
        let headers = headers.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        Usage::reported(&Response { status: 200, headers, body: body.to_string().into_bytes() })
    }

    #[test]
    fn every_service_is_read_in_its_own_words() {
        let tokens = |i, o| Usage { input: Some(i), output: Some(o), ..Usage::default() };
        let openai = json!({ "usage": { "prompt_tokens": 7, "completion_tokens": 5 } });
        assert_eq!(of(&openai, &[]), tokens(7, 5));
        let anthropic = json!({ "usage": { "input_tokens": 7, "output_tokens": 5 } });
        assert_eq!(of(&anthropic, &[]), tokens(7, 5));
        let gemini = json!({ "usageMetadata": { "promptTokenCount": 7, "candidatesTokenCount": 5,
            "thoughtsTokenCount": 11 } });
        assert_eq!(of(&gemini, &[]), tokens(7, 16));
        let credits = |n| Usage { credits: Some(n), ..Usage::default() };
        assert_eq!(of(&json!({ "data": { "credits_consumed": 30 } }), &[]), credits(30.0));
        assert_eq!(of(&json!({}), &[("x-fal-billable-units", "1.5")]), credits(1.5));
        let replicate = json!({ "metrics": { "total_time": 8.25 } });
        assert_eq!(of(&replicate, &[]).seconds, Some(8.25));
    }

    #[test]
    fn what_is_not_reported_is_unknown() {
        assert!(of(&json!({ "usage": { "prompt_tokens": "many" } }), &[]).is_empty());
        assert!(of(&json!({ "consumed_credits": -3 }), &[]).is_empty());
        assert!(of(&json!([1, 2]), &[("x-fal-billable-units", "soon")]).is_empty());
    }
}
