//! Gemini's generateContent.
//!
//! Source: the vendor's discovery document, `GenerateContentRequest` and `GenerateContentResponse`.

use std::time::Duration;

use secrecy::SecretString;
use serde_json::{Value, json};

use super::reading::{Ending, check_whole, joined, reply};
use super::{Codec, Piece, Question, Reply, Turn};
use crate::generators::answer::{Asked, shortened};
use crate::{AdapterError, Request, Response};

/// An account at Google.
#[derive(Clone, Debug)]
pub struct Gemini {
    /// The service's address, `https://generativelanguage.googleapis.com`.
    pub base: String,
    /// Key; sent as a header, never in the address.
    pub key: SecretString,
    /// Model.
    pub model: String,
}

impl Codec for Gemini {
    fn identity(&self) -> String {
        format!("gemini/1 {}", self.model)
    }

    fn request(&self, question: &Question<'_>) -> Request {
        let body = json!({
            "systemInstruction": { "parts": [{ "text": question.system }] },
            "contents": question.turns.iter().map(content).collect::<Vec<_>>(),
            "generationConfig": {
                "responseMimeType": "application/json",
                "responseJsonSchema": question.schema,
                "maxOutputTokens": question.max_tokens,
            },
        });
        let base = self.base.trim_end_matches('/');
        let url = format!("{base}/v1beta/models/{}:generateContent", self.model);
        let request = Request::post_json(&question.step, url, &body);
        let request = request.with_secret("x-goog-api-key", Some(self.key.clone()));
        request.within(Duration::from_secs(300), 4 << 20)
    }

    fn reply(&self, step: &str, response: &Response) -> Result<Reply, AdapterError> {
        let asked = Asked { provider: &self.model, step };
        let answer = asked.json(response)?;
        if let Some(reason) = answer.pointer("/promptFeedback/blockReason").and_then(Value::as_str)
        {
            return Err(
                asked.broke("the model must answer", format!("a block: {}", shortened(reason)))
            );
        }
        let ending = Ending { pointer: "/candidates/0/finishReason", whole: &["STOP"] };
        check_whole(asked, &answer, &ending)?;
        let text = joined(&answer, "/candidates/0/content/parts", "text");
        let used = ["/usageMetadata/promptTokenCount", "/usageMetadata/candidatesTokenCount"];
        reply(asked, text, &answer, used)
    }
}

fn content(turn: &Turn) -> Value {
    let piece = |piece: &Piece| match piece {
        Piece::Text(text) => json!({ "text": text }),
        Piece::Picture { media_type, base64 } => {
            json!({ "inlineData": { "mimeType": media_type, "data": base64 } })
        }
    };
    match turn {
        Turn::Ours(pieces) => {
            json!({ "role": "user", "parts": pieces.iter().map(piece).collect::<Vec<_>>() })
        }
        Turn::Theirs(text) => json!({ "role": "model", "parts": [{ "text": text }] }),
    }
}
