//! Texts to vectors by CLIP's text tower, from a checkpoint's folder on disk.

mod tokens;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use object::condition::MAX_TEXT;
use serde::Deserialize;

use super::{FeatureError, TextFeatures};
use crate::net::clip::{Activation, ClipSizes, ClipTower};
use crate::weights::{TensorFile, WeightsError};
use tokens::{Tokens, Unsound};

/// Longest file beside the weights that is read, bytes.
const MAX_FILE: u64 = 64 << 20;
/// What stands in OpenAI's configurations where the number of the end of text should be.
const LEGACY_END: u32 = 2;

/// CLIP's text tower with its tokenizer (Radford et al. 2021, section 2.4): trained on 400 million
/// pictures and their captions, so that words lie near each other that are said of like things.
///
/// The vector is the projected one, as long as the tower made it. It depends on the text alone, bit
/// for bit, on every run and any thread count.
#[derive(Debug)]
pub struct ClipText {
    tower: ClipTower,
    tokens: Tokens,
    identity: String,
}

/// Why a CLIP checkpoint could not be used.
#[derive(Debug, thiserror::Error)]
pub enum ClipError {
    /// A file that cannot be read, or says what a checkpoint's does not.
    #[error("{}: {rule}", .file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The rule, and what was found.
        rule: String,
    },
    /// Weights that cannot be used; with every tensor that does not fit.
    #[error("{}: {source}", .file.display())]
    Weights {
        /// The file.
        file: PathBuf,
        /// What is wrong with them.
        source: WeightsError,
    },
}

impl ClipText {
    /// Reads a checkpoint's folder as Hugging Face lays one out: `config.json`, `vocab.json`,
    /// `merges.txt` and `model.safetensors`. Nothing is downloaded.
    ///
    /// # Errors
    /// [`ClipError`], naming the file and what it should be.
    pub fn open(folder: &Path) -> Result<Self, ClipError> {
        let config = Config::parse(&read(folder, "config.json")?);
        let config = config.map_err(|rule| broken(folder, "config.json", rule))?;
        let sizes = config.sizes;
        let (vocabulary, merges) = (read(folder, "vocab.json")?, read(folder, "merges.txt")?);
        let tokens = Tokens::parse(&vocabulary, &merges, sizes.vocabulary);
        let tokens = tokens.map_err(|e| match e {
            Unsound::Vocabulary(rule) => broken(folder, "vocab.json", rule),
            Unsound::Merges(rule) => broken(folder, "merges.txt", rule),
        })?;
        let end = config.end(tokens.end());
        end.map_err(|rule| broken(folder, "config.json", rule))?;
        let mut hasher = blake3::Hasher::new();
        tokens.hash(&mut hasher);
        hash_sizes(&sizes, &mut hasher);
        let tower = tower(folder, sizes, &mut hasher)?;
        let digest = hasher.finalize().to_hex();
        Ok(Self { tower, tokens, identity: format!("clip/1 {}", &digest[..16]) })
    }

    /// The tokens of a text, the first its start, the last its end.
    pub fn tokens(&self, text: &str) -> Vec<u32> {
        self.tokens.encode(text)
    }
}

impl TextFeatures for ClipText {
    /// Name, version and a digest of sizes, vocabulary and weights.
    fn identity(&self) -> String {
        self.identity.clone()
    }

    fn width(&self) -> usize {
        let ClipSizes { out, .. } = *self.tower.sizes();
        out
    }

    /// The vector of a text, which may say anything: `<|endoftext|>` in it ends it.
    ///
    /// # Errors
    /// [`FeatureError::TextTooLong`], [`FeatureError::TooManyTokens`], and
    /// [`FeatureError::Encoder`] when a layer gives what is not finite.
    fn embed(&self, text: &str) -> Result<Vec<f32>, FeatureError> {
        let found = text.chars().count();
        if found > MAX_TEXT {
            return Err(FeatureError::TextTooLong { limit: MAX_TEXT, found });
        }
        let ids = self.tokens.encode(text);
        let (room, found) = (self.tower.sizes().positions, ids.len());
        if found > room {
            let limit = room.saturating_sub(2);
            return Err(FeatureError::TooManyTokens { limit, found: found - 2 });
        }
        // rows see only what is before them, so the rows after the end decide nothing
        let end = ids.iter().position(|&id| id == self.tokens.end());
        let seen = end.map_or(&ids[..], |end| &ids[..=end]);
        Ok(self.tower.forward(seen)?)
    }
}

/// Reads the tower, its parameters hashed on their way.
fn tower(
    folder: &Path,
    sizes: ClipSizes,
    hasher: &mut blake3::Hasher,
) -> Result<ClipTower, ClipError> {
    let path = folder.join("model.safetensors");
    let weights = |source| ClipError::Weights { file: path.clone(), source };
    let mut file = TensorFile::open(open(folder, "model.safetensors")?).map_err(weights)?;
    let mut watch = |name: &str, shape: &[usize], values: &[f32]| {
        hasher.update(format!("{name} {shape:?}\n").as_bytes());
        for some in values.chunks(1 << 14) {
            let bytes: Vec<u8> = some.iter().flat_map(|v| v.to_le_bytes()).collect();
            hasher.update(&bytes);
        }
    };
    ClipTower::load(sizes, &mut file, &mut watch).map_err(weights)
}

/// What the shapes of the weights do not tell.
fn hash_sizes(sizes: &ClipSizes, hasher: &mut blake3::Hasher) {
    let activation = match sizes.activation {
        Activation::QuickGelu => "quick_gelu",
        Activation::Gelu => "gelu",
    };
    hasher.update(format!("{activation} {} {:08x}\n", sizes.heads, sizes.eps.to_bits()).as_bytes());
}

fn broken(folder: &Path, name: &str, rule: String) -> ClipError {
    ClipError::File { file: folder.join(name), rule }
}

fn open(folder: &Path, name: &str) -> Result<File, ClipError> {
    let rule = "a CLIP folder holds config.json, vocab.json, merges.txt and model.safetensors";
    File::open(folder.join(name)).map_err(|e| broken(folder, name, format!("{rule}; {e}")))
}

fn read(folder: &Path, name: &str) -> Result<Vec<u8>, ClipError> {
    let mut bytes = Vec::new();
    let read = open(folder, name)?.take(MAX_FILE + 1).read_to_end(&mut bytes);
    read.map_err(|e| broken(folder, name, e.to_string()))?;
    if bytes.len() as u64 > MAX_FILE {
        return Err(broken(folder, name, format!("at most {MAX_FILE} bytes are read")));
    }
    Ok(bytes)
}

/// What `config.json` says of the text tower.
struct Config {
    sizes: ClipSizes,
    end: u32,
}

/// Keys of the text tower, with the values Hugging Face takes for those that are missing.
#[derive(Deserialize)]
#[serde(default)]
struct Keys {
    hidden_size: usize,
    num_attention_heads: usize,
    num_hidden_layers: usize,
    intermediate_size: usize,
    max_position_embeddings: usize,
    vocab_size: usize,
    projection_dim: usize,
    hidden_act: String,
    layer_norm_eps: f32,
    eos_token_id: u32,
}

impl Default for Keys {
    fn default() -> Self {
        let base = ClipSizes::base();
        Self {
            hidden_size: base.width,
            num_attention_heads: base.heads,
            num_hidden_layers: base.layers,
            intermediate_size: base.hidden,
            max_position_embeddings: base.positions,
            vocab_size: base.vocabulary,
            projection_dim: base.out,
            hidden_act: "quick_gelu".into(),
            layer_norm_eps: base.eps,
            eos_token_id: 49_407,
        }
    }
}

impl Config {
    /// Of both towers, the text tower below `text_config`, or of the text tower alone.
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let not_json = |e: serde_json::Error| format!("expected a CLIP configuration: {e}");
        let all: serde_json::Value = serde_json::from_slice(bytes).map_err(not_json)?;
        let text = all.get("text_config").filter(|text| !text.is_null());
        let mut keys = Keys::deserialize(text.unwrap_or(&all)).map_err(not_json)?;
        if let Some(out) = all.get("projection_dim") {
            keys.projection_dim = usize::deserialize(out).map_err(not_json)?;
        }
        let activation = match keys.hidden_act.as_str() {
            "quick_gelu" => Activation::QuickGelu,
            "gelu" => Activation::Gelu,
            other => return Err(format!("`hidden_act` is quick_gelu or gelu, found {other}")),
        };
        let eps = keys.layer_norm_eps;
        if !(eps.is_finite() && eps > 0.0) {
            return Err(format!("`layer_norm_eps` is above zero, found {eps}"));
        }
        let sizes = ClipSizes {
            width: keys.hidden_size,
            heads: keys.num_attention_heads,
            layers: keys.num_hidden_layers,
            hidden: keys.intermediate_size,
            positions: keys.max_position_embeddings,
            vocabulary: keys.vocab_size,
            out: keys.projection_dim,
            activation,
            eps,
        };
        sizes.check().map_err(|e| e.to_string())?;
        Ok(Self { sizes, end: keys.eos_token_id })
    }

    /// Proves that the text is read off where the vocabulary says it ends. OpenAI's configurations
    /// name another token, and mean the one with the greatest number.
    fn end(&self, found: u32) -> Result<(), String> {
        let last = (self.sizes.vocabulary - 1) as u32;
        let wanted = if self.end == LEGACY_END { last } else { self.end };
        if wanted == found {
            return Ok(());
        }
        Err(format!("texts end with token {wanted}, but `<|endoftext|>` is {found}"))
    }
}
