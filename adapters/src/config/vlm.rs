//! Who says what the parts are, as a section of the configuration says.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::asking::Asking;
use crate::asking::pointing::Convention;
use crate::chat::openai::LengthKey;
use crate::chat::{Anthropic, Codec, Gemini, OpenAi};
use crate::net::redact;
use crate::terms::{OF_YOUR_ACCOUNT, Terms, UNTOLD};
use crate::{AdapterError, Vlm, World};

/// Most tokens of one answer.
const MAX_TOKENS: u32 = 16_384;

/// Who says what the parts are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VlmConfig {
    /// Whose protocol is spoken.
    pub provider: VlmProvider,
    /// Model.
    pub model: String,
    /// The service's address; the vendor's own if left out.
    pub base: Option<String>,
    /// The variable that holds the key. If left out the vendor's usual one; a server at a `base` of
    /// its own is then spoken to without a key.
    pub key_env: Option<String>,
    /// How the model writes a point: `yx1000`, `xy1000` or `xy_pixels`; by its name if left out.
    pub points: Option<Convention>,
    /// Whether the model also looks at the object in motion and flags what looks wrong; off if left
    /// out.
    #[serde(default, skip_serializing_if = "is_off")]
    pub critic: bool,
}

/// What is off leaves no word, so that a trace says nothing of what nobody asked for.
fn is_off(switch: &bool) -> bool {
    !switch
}

/// Whose protocol is spoken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VlmProvider {
    /// Chat completions, as most servers speak them.
    Openai,
    /// Messages.
    Anthropic,
    /// generateContent.
    Gemini,
}

impl VlmConfig {
    /// Its word in the configuration.
    pub fn name(&self) -> &'static str {
        match self.provider {
            VlmProvider::Openai => "openai",
            VlmProvider::Anthropic => "anthropic",
            VlmProvider::Gemini => "gemini",
        }
    }

    /// What is known of its licence.
    pub fn terms(&self) -> Terms {
        if self.base.is_some() { UNTOLD } else { OF_YOUR_ACCOUNT }
    }

    /// The variable that holds its key, where it has one.
    pub fn key_variable(&self) -> Option<&str> {
        let own = self.provider == VlmProvider::Openai && self.base.is_some();
        let usual = (!own).then(|| self.usual_key());
        self.key_env.as_deref().or(usual)
    }

    /// The variable that holds the vendor's key.
    pub(super) fn usual_key(&self) -> &'static str {
        match self.provider {
            VlmProvider::Openai => "OPENAI_API_KEY",
            VlmProvider::Anthropic => "ANTHROPIC_API_KEY",
            VlmProvider::Gemini => "GEMINI_API_KEY",
        }
    }

    /// The server's address.
    pub fn base(&self) -> &str {
        self.base.as_deref().unwrap_or(self.usual_base())
    }

    /// The vendor's address.
    pub(super) fn usual_base(&self) -> &'static str {
        match self.provider {
            VlmProvider::Openai => "https://api.openai.com/v1",
            VlmProvider::Anthropic => "https://api.anthropic.com",
            VlmProvider::Gemini => "https://generativelanguage.googleapis.com",
        }
    }

    /// How the model writes a point.
    pub fn convention(&self) -> Convention {
        self.points.unwrap_or_else(|| Convention::of_model(&self.model))
    }

    /// The same as it may be kept in a trace.
    pub(super) fn redacted(mut self) -> Self {
        self.base = self.base.map(|base| redact::url(&base));
        self
    }

    /// The adapter as it is written.
    pub(crate) fn adapter(&self, world: &World) -> Result<Box<dyn Vlm>, AdapterError> {
        Ok(Box::new(self.asking(world)?))
    }

    /// Whoever puts questions to that model.
    pub(crate) fn asking(&self, world: &World) -> Result<Asking<Box<dyn Codec>>, AdapterError> {
        let (codec, convention) = (self.codec(world)?, self.convention());
        let transport = Arc::clone(&world.transport);
        Ok(Asking { codec, transport, convention, max_tokens: MAX_TOKENS })
    }

    /// The protocol as it is spoken to that model.
    pub(crate) fn codec(&self, world: &World) -> Result<Box<dyn Codec>, AdapterError> {
        let (base, model) = (self.base().to_owned(), self.model.clone());
        let key = self.key_variable().map(|variable| world.key(variable)).transpose()?;
        let missing = || AdapterError::Key { variable: "named by key_env".into() };
        Ok(match self.provider {
            VlmProvider::Openai => {
                let own = self.base.is_some();
                let length = if own { LengthKey::Plain } else { LengthKey::Completion };
                let temperature = own.then_some(0.0);
                Box::new(OpenAi { base, key, model, temperature, length })
            }
            VlmProvider::Anthropic => {
                Box::new(Anthropic { base, key: key.ok_or_else(missing)?, model })
            }
            VlmProvider::Gemini => Box::new(Gemini { base, key: key.ok_or_else(missing)?, model }),
        })
    }
}
