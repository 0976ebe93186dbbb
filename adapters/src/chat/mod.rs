//! Talking with vision-language models: one question in our words, three protocols.

pub mod anthropic;
pub mod gemini;
pub mod openai;
mod reading;
#[cfg(test)]
mod tests;

pub use anthropic::Anthropic;
pub use gemini::Gemini;
pub use openai::OpenAi;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{AdapterError, Request, Response};

/// Turns a question into one service's request and its answer back into a reply.
///
/// Promise: the same question gives the same bytes; no answer, however broken, makes it panic; a
/// refusal, a cut answer or an empty one is an error and never a reply.
pub trait Codec: Send + Sync {
    /// Provider and model. Part of the stage key.
    fn identity(&self) -> String;

    /// The request that asks.
    fn request(&self, question: &Question<'_>) -> Request;

    /// What was answered.
    ///
    /// # Errors
    /// [`AdapterError::Service`] with the rule and what was found.
    fn reply(&self, step: &str, response: &Response) -> Result<Reply, AdapterError>;
}

impl Codec for Box<dyn Codec> {
    fn identity(&self) -> String {
        (**self).identity()
    }

    fn request(&self, question: &Question<'_>) -> Request {
        (**self).request(question)
    }

    fn reply(&self, step: &str, response: &Response) -> Result<Reply, AdapterError> {
        (**self).reply(step, response)
    }
}

/// A question whose answer is JSON of one schema.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// What it is for, such as `vlm.kinematics/0`.
    pub step: String,
    /// Whom the model should be.
    pub system: &'a str,
    /// What was said so far; ends with a turn of ours.
    pub turns: Vec<Turn>,
    /// Name of the schema: letters, digits and `_`.
    pub schema_name: &'a str,
    /// JSON Schema of the answer, in the subset all services take: flat, every key required, no
    /// unknown keys, no bounds.
    pub schema: Value,
    /// Most tokens of the answer.
    pub max_tokens: u32,
}

/// What one side said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Turn {
    /// We.
    Ours(Vec<Piece>),
    /// The model.
    Theirs(String),
}

/// A piece of what we say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// Words.
    Text(String),
    /// A picture.
    Picture {
        /// `image/png`, `image/jpeg` or `image/webp`.
        media_type: String,
        /// The file in base64.
        base64: String,
    },
}

impl Piece {
    /// Words.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// A picture file.
    pub fn picture(media_type: &str, bytes: &[u8]) -> Self {
        use base64::Engine as _;
        let base64 = base64::engine::general_purpose::STANDARD.encode(bytes);
        Self::Picture { media_type: media_type.into(), base64 }
    }
}

/// What a model answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reply {
    /// Its words, which should be JSON.
    pub text: String,
    /// What it says to have used.
    pub usage: Usage,
}

/// Tokens used, as the service reports them; unknown is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Usage {
    /// Read.
    pub input: Option<u64>,
    /// Written.
    pub output: Option<u64>,
}
