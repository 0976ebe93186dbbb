//! `kinfold.toml`: who is asked for meshes and conditions, and where their keys are found.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use secrecy::SecretString;
use serde::Deserialize;

use crate::asking::Asking;
use crate::asking::pointing::Convention;
use crate::chat::openai::LengthKey;
use crate::chat::{Anthropic, Codec, Gemini, OpenAi};
use crate::files::read_limited;
use crate::generators::hunyuan::Manner;
use crate::generators::{Command, Generated, Hunyuan, Ledger, Meshy, Patience, meshy};
use crate::net::pace::Pace;
use crate::{AdapterError, ImageTo3d, Transport, Vlm};

/// Largest configuration file, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Most tokens of one answer.
const MAX_TOKENS: u32 = 16_384;

/// Who is asked; a section left out is nobody.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Who makes meshes.
    pub image_to_3d: Option<GeneratorConfig>,
    /// Who says what the parts are.
    pub vlm: Option<VlmConfig>,
}

/// Who makes meshes. Keys are named by the variable that holds them and never stand in the file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "provider", rename_all = "snake_case", deny_unknown_fields)]
pub enum GeneratorConfig {
    /// A program on this machine; of its arguments `{image}`, `{mesh}` and `{seed}` are filled in.
    Command {
        /// The program.
        program: String,
        /// Its arguments.
        arguments: Vec<String>,
        /// Seconds it may take; 900 if left out.
        seconds: Option<u64>,
    },
    /// A Hunyuan3D `api_server`.
    Hunyuan {
        /// Its address, such as `http://127.0.0.1:8081`.
        base: String,
        /// Ask for a job and look after it, instead of one long request.
        #[serde(default)]
        queue: bool,
    },
    /// Meshy; its key in `MESHY_API_KEY` unless `key_env` names another variable.
    Meshy {
        /// Such as `meshy-6`.
        model: String,
        /// Faces wanted, 100 to 300,000; 30,000 if left out.
        faces: Option<u32>,
        /// The variable that holds the key.
        key_env: Option<String>,
    },
}

/// Who says what the parts are.
#[derive(Clone, Debug, PartialEq, Deserialize)]
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
}

/// Whose protocol is spoken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VlmProvider {
    /// Chat completions, as most servers speak them.
    Openai,
    /// Messages.
    Anthropic,
    /// generateContent.
    Gemini,
}

/// What adapters reach the world through.
#[derive(Clone)]
pub struct World {
    /// What everything passes through.
    pub transport: Arc<dyn Transport>,
    /// Who waits.
    pub pace: Arc<dyn Pace>,
    /// What is known of jobs.
    pub ledger: Arc<dyn Ledger>,
    /// A folder for files that live no longer than a call.
    pub scratch: PathBuf,
    /// The environment: a variable's value by its name.
    pub variable: fn(&str) -> Option<String>,
}

impl Config {
    /// Reads a configuration file.
    ///
    /// # Errors
    /// [`AdapterError::Io`] or [`AdapterError::Format`], naming the file, the place and the rule.
    pub fn open(path: &Path) -> Result<Self, AdapterError> {
        let name = path.display().to_string();
        let text = String::from_utf8(read_limited(path, MAX_BYTES)?);
        let broken = |found: String| AdapterError::Format {
            path: name.clone(),
            expected: "a kinfold configuration",
            found: found.trim().replace('\n', " "),
        };
        let text = text.map_err(|e| broken(e.to_string()))?;
        toml::from_str(&text).map_err(|e| broken(e.to_string()))
    }

    /// Who makes meshes; none if nobody is configured.
    ///
    /// # Errors
    /// [`AdapterError::Key`] where a key is needed and not set.
    pub fn image_to_3d(&self, world: &World) -> Result<Option<Box<dyn ImageTo3d>>, AdapterError> {
        self.image_to_3d.as_ref().map(|g| g.adapter(world)).transpose()
    }

    /// Who says what the parts are; none if nobody is configured.
    ///
    /// # Errors
    /// [`AdapterError::Key`] where a key is needed and not set.
    pub fn vlm(&self, world: &World) -> Result<Option<Box<dyn Vlm>>, AdapterError> {
        self.vlm.as_ref().map(|v| v.adapter(world)).transpose()
    }
}

impl GeneratorConfig {
    fn adapter(&self, world: &World) -> Result<Box<dyn ImageTo3d>, AdapterError> {
        let World { transport, pace, ledger, scratch, .. } = world.clone();
        let patience = Patience::default();
        Ok(match self.clone() {
            Self::Command { program, arguments, seconds } => {
                let deadline = Duration::from_secs(seconds.unwrap_or(900));
                Box::new(Command { program, arguments, deadline, scratch, pace })
            }
            Self::Hunyuan { base, queue } => {
                let manner = if queue { Manner::Queue } else { Manner::Wait };
                let generator = Hunyuan { manner, ..Hunyuan::new(base) };
                Box::new(Generated { generator, transport, pace, ledger, patience })
            }
            Self::Meshy { model, faces, key_env } => {
                let key = key(world, key_env.as_deref().unwrap_or("MESHY_API_KEY"))?;
                let (base, faces) = (meshy::BASE.into(), faces.unwrap_or(30_000));
                let generator = Meshy { base, key, model, faces };
                Box::new(Generated { generator, transport, pace, ledger, patience })
            }
        })
    }
}

impl VlmConfig {
    fn adapter(&self, world: &World) -> Result<Box<dyn Vlm>, AdapterError> {
        let codec = self.codec(world)?;
        let convention = self.points.unwrap_or_else(|| Convention::of_model(&self.model));
        let transport = Arc::clone(&world.transport);
        Ok(Box::new(Asking { codec, transport, convention, max_tokens: MAX_TOKENS }))
    }

    fn codec(&self, world: &World) -> Result<Box<dyn Codec>, AdapterError> {
        let base = |vendor: &str| self.base.clone().unwrap_or_else(|| vendor.to_owned());
        let key = |usual| key(world, self.key_env.as_deref().unwrap_or(usual));
        let model = self.model.clone();
        Ok(match self.provider {
            VlmProvider::Openai => {
                let own = self.base.is_some();
                let keyless = own && self.key_env.is_none();
                let key = if keyless { None } else { Some(key("OPENAI_API_KEY")?) };
                let length = if own { LengthKey::Plain } else { LengthKey::Completion };
                let temperature = own.then_some(0.0);
                let base = base("https://api.openai.com/v1");
                Box::new(OpenAi { base, key, model, temperature, length })
            }
            VlmProvider::Anthropic => {
                let base = base("https://api.anthropic.com");
                Box::new(Anthropic { base, key: key("ANTHROPIC_API_KEY")?, model })
            }
            VlmProvider::Gemini => {
                let base = base("https://generativelanguage.googleapis.com");
                Box::new(Gemini { base, key: key("GEMINI_API_KEY")?, model })
            }
        })
    }
}

/// The key a variable holds.
fn key(world: &World, variable: &str) -> Result<SecretString, AdapterError> {
    let value = (world.variable)(variable).filter(|v| !v.trim().is_empty());
    let value = value.ok_or_else(|| AdapterError::Key { variable: variable.into() })?;
    Ok(value.trim().to_owned().into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generators::MemoryLedger;
    use crate::net::pace::ImaginedPace;
    use crate::transport::Deny;

    fn world() -> World {
        let variable = |name: &str| (name == "SOME_KEY").then(|| "canary".to_owned());
        let (transport, pace) = (Arc::new(Deny), Arc::new(ImaginedPace::default()));
        let ledger = Arc::new(MemoryLedger::default());
        World { transport, pace, ledger, scratch: "scratch".into(), variable }
    }

    fn open(text: &str) -> Result<Config, AdapterError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        Config::open(file.path())
    }

    fn identities(text: &str) -> Result<[Option<String>; 2], AdapterError> {
        let config = open(text)?;
        let mesh = config.image_to_3d(&world())?.map(|a| a.identity()).transpose()?;
        Ok([mesh, config.vlm(&world())?.map(|a| a.identity()).transpose()?])
    }

    #[test]
    fn providers_are_built_as_they_are_written() {
        let [mesh, vlm] = identities(
            "[image_to_3d]\nprovider = 'command'\nprogram = 'gen'\narguments = ['{image}']\n\
             [vlm]\nprovider = 'openai'\nbase = 'http://localhost:8000/v1'\nmodel = 'Qwen3-VL'\n",
        )
        .unwrap();
        assert_eq!(mesh.unwrap(), "command/1 gen {image}");
        let vlm = vlm.unwrap();
        assert!(vlm.starts_with("openai-chat/1 Qwen3-VL at localhost:8000"), "{vlm}");
        assert!(vlm.ends_with("Xy1000"), "{vlm}");
        let meshy = "[image_to_3d]\nprovider = 'meshy'\nmodel = 'meshy-6'\nkey_env = 'SOME_KEY'\n";
        assert!(identities(meshy).unwrap()[0].as_ref().unwrap().contains("meshy-6"));
        assert_eq!(identities("").unwrap(), [None, None]);
    }

    #[test]
    fn a_key_that_is_not_set_is_named() {
        let error = identities("[vlm]\nprovider = 'gemini'\nmodel = 'g'\n").unwrap_err();
        assert_eq!(error.to_string(), "no key: the variable GEMINI_API_KEY is not set");
        assert!(error.hint().is_some());
    }

    #[test]
    fn an_unknown_word_is_told_with_its_place() {
        let error = open("[vlm]\nprovider = 'openai'\nmodle = 'x'\n").unwrap_err().to_string();
        assert!(error.contains("modle") && error.contains("line 3"), "{error}");
        open("[image_to_3d]\nprovider = 'nobody'\n").unwrap_err();
    }
}
