//! OpenAI's chat completions, which vLLM, LM Studio, llama.cpp, Ollama and OpenRouter speak too.
//!
//! Source: `openai/openai-openapi`, `CreateChatCompletionRequest`.

use std::time::Duration;

use secrecy::{ExposeSecret as _, SecretString};
use serde_json::{Value, json};

use super::reading::{Ending, check_whole, reply};
use super::{Codec, Piece, Question, Reply, Turn};
use crate::generators::answer::{Asked, shortened};
use crate::{AdapterError, Request, Response};

/// A server that speaks chat completions.
#[derive(Clone, Debug)]
pub struct OpenAi {
    /// Its address up to the version, such as `http://127.0.0.1:8000/v1`.
    pub base: String,
    /// Key, where it wants one.
    pub key: Option<SecretString>,
    /// Model.
    pub model: String,
    /// 0 for the likeliest answer; none for models that take no temperature.
    pub temperature: Option<f64>,
    /// The key under which the length is limited.
    pub length: LengthKey,
}

/// Under which key a server limits the length of its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthKey {
    /// `max_completion_tokens`: OpenAI itself.
    Completion,
    /// `max_tokens`: most others.
    Plain,
}

impl Codec for OpenAi {
    fn identity(&self) -> String {
        format!("openai-chat/1 {} at {}", self.model, crate::net::redact::host(&self.base))
    }

    fn request(&self, question: &Question<'_>) -> Request {
        let system = json!({ "role": "system", "content": question.system });
        let messages: Vec<_> =
            std::iter::once(system).chain(question.turns.iter().map(message)).collect();
        let mut body = json!({
            "model": self.model,
            "messages": messages,
            "response_format": { "type": "json_schema", "json_schema": {
                "name": question.schema_name, "strict": true, "schema": question.schema } },
        });
        let length = match self.length {
            LengthKey::Completion => "max_completion_tokens",
            LengthKey::Plain => "max_tokens",
        };
        body[length] = question.max_tokens.into();
        if let Some(temperature) = self.temperature {
            body["temperature"] = temperature.into();
        }
        let url = format!("{}/chat/completions", self.base.trim_end_matches('/'));
        let key = self.key.as_ref().map(|k| format!("Bearer {}", k.expose_secret()).into());
        let request = Request::post_json(&question.step, url, &body);
        request.with_secret("authorization", key).within(Duration::from_secs(300), 4 << 20)
    }

    fn reply(&self, step: &str, response: &Response) -> Result<Reply, AdapterError> {
        let asked = Asked { provider: &self.model, step };
        let answer = asked.json(response)?;
        if let Some(words) = answer.pointer("/choices/0/message/refusal").and_then(Value::as_str) {
            return Err(
                asked.broke("the model must answer", format!("a refusal: {}", shortened(words)))
            );
        }
        check_whole(
            asked,
            &answer,
            &Ending { pointer: "/choices/0/finish_reason", whole: &["stop"] },
        )?;
        let rule = "the answer must have `choices[0].message.content`";
        let text = asked.text(&answer, "/choices/0/message/content", rule)?.to_owned();
        reply(asked, text, &answer, ["/usage/prompt_tokens", "/usage/completion_tokens"])
    }
}

fn message(turn: &Turn) -> Value {
    let piece = |piece: &Piece| match piece {
        Piece::Text(text) => json!({ "type": "text", "text": text }),
        Piece::Picture { media_type, base64 } => json!({ "type": "image_url",
            "image_url": { "url": format!("data:{media_type};base64,{base64}") } }),
    };
    match turn {
        Turn::Ours(pieces) => {
            json!({ "role": "user", "content": pieces.iter().map(piece).collect::<Vec<_>>() })
        }
        Turn::Theirs(text) => json!({ "role": "assistant", "content": text }),
    }
}
