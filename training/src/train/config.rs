//! What a training run is told: the file behind `kinfold train CONFIG.toml`.

use std::path::{Path, PathBuf};

use model::features::{GeometricFeatures, NgramText, PointFeatures, TextFeatures, geometric, text};
use model::net::{Config, Positions};
use model::weights::Header;
use serde::{Deserialize, Serialize};

use super::error::TrainError;
use super::optimiser::Schedule;
use crate::augment::{Augment, LessonSize};
use crate::dataset::SourceConfig;
use crate::dataset::sample::Counts;
use crate::loss::LossWeights;

/// A training run. Paths are relative to the file it is read from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainConfig {
    /// Folder of the run: checkpoint, weights, curves.
    pub out: PathBuf,
    /// Folder of measured samples; runs may share it.
    pub cache: PathBuf,
    /// Weights to start from instead of random ones.
    #[serde(default)]
    pub from: Option<PathBuf>,
    /// Seed of the weights and of everything drawn.
    #[serde(default)]
    pub seed: u64,
    /// The step the run ends with; may be raised later.
    pub steps: u64,
    /// Objects in a step.
    #[serde(default = "eight")]
    pub batch: usize,
    /// M, query points of each object.
    #[serde(default = "queries")]
    pub queries: usize,
    /// The share of those that is spread over the parts evenly.
    #[serde(default = "quarter")]
    pub balanced: f64,
    /// Sizes of the network.
    #[serde(default)]
    pub network: Sizes,
    /// Optimiser.
    #[serde(default)]
    pub schedule: Schedule,
    /// Loss.
    #[serde(default)]
    pub loss: LossWeights,
    /// Augmentation.
    #[serde(default)]
    pub augment: Augment,
    /// Points of a sample.
    #[serde(default)]
    pub sample: Counts,
    /// How often things are written.
    #[serde(default)]
    pub every: Every,
    /// The mixture.
    #[serde(rename = "source")]
    pub sources: Vec<SourceConfig>,
    /// Lists of record ids that must not be trained on.
    #[serde(default)]
    pub held_out: Vec<PathBuf>,
    /// What is looked at, and never trained on, to see how good the weights are.
    #[serde(default)]
    pub validation: Option<Validation>,
}

/// Sizes of the network that a run may choose; the encoders settle the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sizes {
    /// D.
    pub width: usize,
    /// Attention heads.
    pub heads: usize,
    /// B, attention blocks.
    pub blocks: usize,
    /// N, points the shape is seen through.
    pub points: usize,
    /// L, shape tokens.
    pub tokens: usize,
    /// Most parts of an object.
    pub max_parts: usize,
}

impl Default for Sizes {
    fn default() -> Self {
        Self { width: 160, heads: 4, blocks: 3, points: 2_048, tokens: 256, max_parts: 64 }
    }
}

/// How often things are written, in steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Every {
    /// A line of the loss curve: the mean since the last one.
    pub curve: u64,
    /// A checkpoint, the weights and the plot; a multiple of `curve`.
    pub checkpoint: u64,
    /// A line of validation; a multiple of `checkpoint`.
    pub validation: u64,
}

impl Default for Every {
    fn default() -> Self {
        Self { curve: 20, checkpoint: 100, validation: 500 }
    }
}

/// What is validated on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Validation {
    /// Where it comes from.
    pub source: SourceConfig,
    /// At most this many objects, spread over all.
    pub objects: usize,
}

/// Most steps of a run.
const MOST_STEPS: u64 = 1 << 40;

fn eight() -> usize {
    8
}

fn queries() -> usize {
    1_024
}

fn quarter() -> f64 {
    0.25
}

impl TrainConfig {
    /// Reads a configuration; paths become relative to the working directory.
    ///
    /// # Errors
    /// [`TrainError`] when it cannot be read or breaks a rule.
    pub fn read(path: &Path) -> Result<Self, TrainError> {
        let text = std::fs::read_to_string(path).map_err(TrainError::io(path))?;
        let told = |what: String| TrainError::Config { path: path.into(), what };
        let mut config: Self = toml::from_str(&text).map_err(|e| told(e.to_string()))?;
        config.move_paths(path.parent().unwrap_or(Path::new("")));
        config.check().map_err(told)?;
        Ok(config)
    }

    fn move_paths(&mut self, folder: &Path) {
        let all = [&mut self.out, &mut self.cache].into_iter();
        let all = all.chain(&mut self.from).chain(&mut self.held_out);
        let sources =
            self.sources.iter_mut().chain(self.validation.iter_mut().map(|v| &mut v.source));
        for path in all.chain(sources.filter_map(|s| s.shards.as_mut())) {
            *path = folder.join(&*path);
        }
    }

    fn check(&self) -> Result<(), String> {
        self.model().check().map_err(|e| e.to_string())?;
        let every = [self.every.curve, self.every.checkpoint, self.every.validation];
        let counts = [
            ("steps", self.steps, MOST_STEPS),
            ("batch", self.batch as u64, 1 << 12),
            ("sample.even", self.sample.even as u64, 1 << 20),
            ("every.curve", every[0], MOST_STEPS),
            ("every.checkpoint", every[1], MOST_STEPS),
            ("every.validation", every[2], MOST_STEPS),
        ];
        for (name, count, most) in counts {
            if !(1..=most).contains(&count) {
                return Err(format!("`{name}` must be between 1 and {most}, found {count}"));
            }
        }
        if !every[1].is_multiple_of(every[0]) || !every[2].is_multiple_of(every[1]) {
            return Err(format!(
                "each of every.curve, every.checkpoint and every.validation must be a multiple of the one before, found {every:?}"
            ));
        }
        self.check_shares()?;
        self.sources.iter().try_for_each(check_source)?;
        self.validation.iter().try_for_each(|v| check_source(&v.source))?;
        if self.sources.is_empty() {
            Err("at least one [[source]] is needed".into())
        } else {
            Ok(())
        }
    }

    fn check_shares(&self) -> Result<(), String> {
        let a = &self.augment;
        let shares = [
            ("balanced", self.balanced),
            ("augment.scale", a.scale),
            ("augment.shift", a.shift),
            ("augment.no_normals", a.no_normals),
            ("augment.merge", a.merge),
            ("augment.no_text", a.no_text),
            ("augment.no_point", a.no_point),
        ];
        for (name, share) in shares {
            if !(0.0..=1.0).contains(&share) {
                return Err(format!("`{name}` must be between 0 and 1, found {share}"));
            }
        }
        let s = &self.schedule;
        let sound = |v: f64| v.is_finite() && v >= 0.0;
        if !sound(s.rate) || !sound(s.weight_decay) {
            return Err("`schedule.rate` and `schedule.weight_decay` must not be negative".into());
        }
        Ok(())
    }

    /// Sizes of the network, encoders included.
    pub fn model(&self) -> Config {
        Config {
            width: self.network.width,
            heads: self.network.heads,
            blocks: self.network.blocks,
            points: self.network.points,
            tokens: self.network.tokens,
            chunk: self.queries,
            queries: Config::small().queries,
            features: geometric::WIDTH,
            text: text::NGRAM_WIDTH,
            max_parts: self.network.max_parts,
            positions: Positions::Offset,
        }
    }

    /// What stands beside the weights.
    pub fn header(&self) -> Header {
        Header::new(&self.model(), &NgramText.identity(), &GeometricFeatures.identity())
    }

    /// Size of a lesson.
    pub fn lesson(&self) -> LessonSize {
        LessonSize {
            points: self.network.points,
            queries: self.queries,
            balanced: (self.queries as f64 * self.balanced).round() as usize,
            parts: self.network.max_parts,
        }
    }

    /// Digest of everything the weights depend on; where files lie and how often things are written
    /// is not part of it, nor is how long the run goes.
    ///
    /// # Errors
    /// [`TrainError`] if the configuration has no text form.
    pub fn identity(&self) -> Result<String, TrainError> {
        let mut bare = self.clone();
        (bare.out, bare.cache, bare.steps) = (PathBuf::new(), PathBuf::new(), 0);
        (bare.every, bare.validation) = (Every::default(), None);
        let name = |p: &PathBuf| p.file_name().map(PathBuf::from).unwrap_or_default();
        bare.from = bare.from.as_ref().map(name);
        bare.held_out = bare.held_out.iter().map(name).collect();
        bare.sources.iter_mut().for_each(|s| s.shards = s.shards.as_ref().map(name));
        let text = serde_json::to_string(&bare).map_err(|e| TrainError::Plot(e.to_string()))?;
        Ok(blake3::hash(text.as_bytes()).to_hex().to_string())
    }
}

fn check_source(source: &SourceConfig) -> Result<(), String> {
    let name = &source.name;
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.is_empty() || !name.chars().all(plain) {
        return Err(format!("a source's name has letters, digits, - and _ only, found `{name}`"));
    }
    if source.shards.is_some() == source.procedural.is_some() {
        return Err(format!("source `{name}` needs either `shards` or `procedural`"));
    }
    if !(source.weight.is_finite() && source.weight > 0.0) {
        return Err(format!("source `{name}`: `weight` must be above 0, found {}", source.weight));
    }
    if (0.0..=1.0).contains(&source.fused_share) {
        return Ok(());
    }
    Err(format!("source `{name}`: `fused_share` must be between 0 and 1"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "out = 'run'\ncache = '/tmp/c'\nsteps = 10\n[[source]]\nname = 'ours'\nprocedural = 4\n";

    fn read(text: &str) -> Result<TrainConfig, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.toml");
        std::fs::write(&path, text).unwrap();
        let config = TrainConfig::read(&path).map_err(|e| e.to_string())?;
        assert_eq!(config.out, folder.path().join("run"));
        assert_eq!(config.cache, Path::new("/tmp/c"));
        Ok(config)
    }

    #[test]
    fn what_is_not_said_is_the_papers_or_ours() {
        let config = read(TEXT).unwrap();
        assert_eq!((config.schedule.rate, config.schedule.warmup), (6.4e-5, 1_000));
        assert_eq!((config.augment.merge, config.loss.limits), (0.15, 10.0));
        assert_eq!(config.model().check(), Ok(()));
    }

    #[test]
    fn a_rule_that_is_broken_is_named() {
        let told = |more: &str| read(&format!("{more}\n{TEXT}")).unwrap_err();
        assert!(told("batch = 0").contains("`batch` must be between 1 and 4096, found 0"));
        assert!(told("balanced = 2.0").contains("`balanced` must be between 0 and 1"));
        assert!(told("speed = 1").contains("unknown field `speed`"));
        assert!(told("every = { curve = 3, checkpoint = 4 }").contains("multiple"));
        let both = TEXT.replace("procedural = 4", "procedural = 4\nshards = 'x'");
        assert!(read(&both).unwrap_err().contains("either `shards` or `procedural`"));
        assert!(told("network = { width = 30, heads = 4 }").contains("`width` must be a multiple"));
    }

    #[test]
    fn every_recipe_is_sound() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes");
        let mut found = 0;
        for recipe in std::fs::read_dir(folder).unwrap() {
            let path = recipe.unwrap().path();
            // Those of fits have a test of their own.
            if crate::fit::fit_of(&path).unwrap().is_none() {
                TrainConfig::read(&path).unwrap();
                found += 1;
            }
        }
        assert!(found > 0);
    }

    #[test]
    fn the_identity_changes_with_what_the_weights_depend_on() {
        let config = read(TEXT).unwrap();
        let longer = TrainConfig { steps: 99, out: "b".into(), ..config.clone() };
        assert_eq!(config.identity().unwrap(), longer.identity().unwrap());
        let other = TrainConfig { seed: 1, ..config.clone() };
        assert_ne!(config.identity().unwrap(), other.identity().unwrap());
    }
}
