//! Anthropic's messages.
//!
//! Source: the vendor's API specification, `CreateMessageParams` and `Message`.

use std::time::Duration;

use secrecy::SecretString;
use serde_json::{Value, json};

use super::reading::{Ending, check_whole, joined, reply};
use super::{Codec, Piece, Question, Reply, Turn};
use crate::generators::answer::Asked;
use crate::{AdapterError, Request, Response};

/// An account at Anthropic.
#[derive(Clone, Debug)]
pub struct Anthropic {
    /// The service's address, `https://api.anthropic.com`.
    pub base: String,
    /// Key.
    pub key: SecretString,
    /// Model.
    pub model: String,
}

impl Codec for Anthropic {
    fn identity(&self) -> String {
        format!("anthropic/1 {}", self.model)
    }

    fn request(&self, question: &Question<'_>) -> Request {
        let body = json!({
            "model": self.model,
            "max_tokens": question.max_tokens,
            "system": question.system,
            "messages": question.turns.iter().map(message).collect::<Vec<_>>(),
            "output_config": { "format": { "type": "json_schema", "schema": question.schema } },
        });
        let url = format!("{}/v1/messages", self.base.trim_end_matches('/'));
        let mut request = Request::post_json(&question.step, url, &body);
        request.headers.push(("anthropic-version".into(), "2023-06-01".into()));
        let request = request.with_secret("x-api-key", Some(self.key.clone()));
        request.within(Duration::from_secs(300), 4 << 20)
    }

    fn reply(&self, step: &str, response: &Response) -> Result<Reply, AdapterError> {
        let asked = Asked { provider: &self.model, step };
        let answer = asked.json(response)?;
        check_whole(asked, &answer, &Ending { pointer: "/stop_reason", whole: &["end_turn"] })?;
        let text = joined(&answer, "/content", "text");
        reply(asked, text, &answer, ["/usage/input_tokens", "/usage/output_tokens"])
    }
}

fn message(turn: &Turn) -> Value {
    let piece = |piece: &Piece| match piece {
        Piece::Text(text) => json!({ "type": "text", "text": text }),
        Piece::Picture { media_type, base64 } => json!({ "type": "image",
            "source": { "type": "base64", "media_type": media_type, "data": base64 } }),
    };
    match turn {
        Turn::Ours(pieces) => {
            json!({ "role": "user", "content": pieces.iter().map(piece).collect::<Vec<_>>() })
        }
        Turn::Theirs(text) => json!({ "role": "assistant", "content": text }),
    }
}
