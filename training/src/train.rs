//! Training: lessons in, weights out, in steps that can be interrupted at any moment.
//!
//! A run lives in a folder: `checkpoint.safetensors` (everything needed to go on),
//! `weights.safetensors` (what the articulator loads, half precision), `curves.csv`,
//! `validation.csv` and `loss.png`. A run that was killed goes on from its checkpoint and ends with
//! the same bytes as one that was not.

pub mod checkpoint;
pub mod config;
pub mod curves;
pub mod error;
pub mod optimiser;
pub mod validate;

use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use burn::tensor::Device;
use model::net::{Batch, Network, Precision};
use model::weights::{load_network, save_network_half};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::alone::Alone;
use crate::augment::{Lesson, lesson};
use crate::dataset::cache::write_whole;
use crate::dataset::library::held_out;
use crate::dataset::{Library, Plan, SourceConfig};
use crate::loss::Loss;
use checkpoint::{Checkpoint, Note};
pub use config::TrainConfig;
use curves::{Line, Table, plot};
pub use error::TrainError;
use optimiser::AdamW;
use validate::{Score, validate};

const CHECKPOINT: &str = "checkpoint.safetensors";
const WEIGHTS: &str = "weights.safetensors";
const CURVE_HEADS: &str = "step,loss,part_loss,joint_loss,rate";
/// Draws in a row that may make no lesson before that is an error.
const TRIES: usize = 1_000;

/// What happens in a run.
#[derive(Clone, Debug)]
pub enum Event {
    /// Objects of every source are ready.
    Ready {
        /// How many objects each source has.
        objects: Vec<usize>,
        /// The step a checkpoint was found at; 0 for a fresh run.
        step: u64,
    },
    /// A step is done.
    Stepped {
        /// Which.
        step: u64,
        /// Its loss.
        loss: f32,
    },
    /// A point of the curve.
    Curve {
        /// The step.
        step: u64,
        /// Mean loss, part loss and joint loss since the last point.
        losses: [f64; 3],
    },
    /// A checkpoint is on disk.
    Saved(u64),
    /// A set was validated.
    Validated {
        /// The step.
        step: u64,
        /// `plain` or `fused`.
        set: &'static str,
        /// What was measured.
        score: Score,
    },
}

/// Somebody who watches a run and may end it.
pub trait Watcher: Sync {
    /// Something happened.
    fn notice(&mut self, event: &Event);

    /// An object was measured. May be called from several threads.
    fn measured(&self, id: &str);

    /// Whether to go on with another step; asked after each.
    fn go_on(&mut self) -> bool;
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Steps done in all.
    pub step: u64,
    /// Whether those are all that were asked for.
    pub finished: bool,
    /// The weights, half precision.
    pub weights: PathBuf,
}

/// Trains until the configuration's last step or until the watcher has enough; in both cases
/// everything is on disk afterwards.
///
/// # Errors
/// [`TrainError`]; what the last checkpoint holds is safe.
pub fn train(config: &TrainConfig, watcher: &mut dyn Watcher) -> Result<Outcome, TrainError> {
    let out = &config.out;
    std::fs::create_dir_all(out).map_err(TrainError::io(out))?;
    let _lock = alone(out)?;
    let mut run = Run::open(config, &Device::flex().autodiff(), watcher)?;
    watcher.notice(&Event::Ready { objects: run.library.counts(), step: run.step() });
    let mut going = true;
    while going && run.step() < config.steps {
        run.advance(watcher)?;
        going = watcher.go_on();
        let step = run.step();
        if !going || step.is_multiple_of(config.every.checkpoint) || step == config.steps {
            run.save(watcher)?;
        }
    }
    let step = run.step();
    Ok(Outcome { step, finished: step >= config.steps, weights: out.join(WEIGHTS) })
}

/// Keeps other runs out of a folder until the result is dropped or the process ends.
fn alone(out: &Path) -> Result<Alone, TrainError> {
    let taken = Alone::in_folder(out).map_err(TrainError::io(out))?;
    taken.ok_or_else(|| TrainError::Busy(out.into()))
}

/// A run in progress.
struct Run<'a> {
    config: &'a TrainConfig,
    device: Device,
    identity: String,
    state: Checkpoint,
    library: Library,
    validation: Vec<(&'static str, Vec<PathBuf>)>,
    curves: Table,
    scores: Table,
    /// Losses since the last point of the curve.
    window: Vec<[f32; 3]>,
}

impl<'a> Run<'a> {
    fn open(
        config: &'a TrainConfig,
        device: &Device,
        watcher: &dyn Watcher,
    ) -> Result<Self, TrainError> {
        let identity = config.identity()?;
        let state = resume(config, &identity, device)?;
        let step = state.note.step;
        let library = library(config, &config.sources, "train", watcher)?;
        let validation = match &config.validation {
            None => vec![],
            Some(v) => {
                let all = library_of_validation(config, watcher)?;
                [("plain", false), ("fused", true)]
                    .map(|(name, fused)| (name, all.shown(fused, v.objects)))
                    .into_iter()
                    .filter(|(_, samples)| !samples.is_empty())
                    .collect()
            }
        };
        let curves = Table::open(&config.out.join("curves.csv"), CURVE_HEADS, step)?;
        let scores = Table::open(&config.out.join("validation.csv"), validate::HEADS, step)?;
        let device = device.clone();
        let window = state.note.window.iter().map(|l| l.map(f32::from_bits)).collect();
        Ok(Self { config, device, identity, state, library, validation, curves, scores, window })
    }

    fn step(&self) -> u64 {
        self.state.optimiser.steps
    }

    /// One step: lessons, answer, loss, new weights.
    fn advance(&mut self, watcher: &mut dyn Watcher) -> Result<(), TrainError> {
        let step = self.step() + 1;
        let lessons = self.lessons(step)?;
        let examples: Vec<_> = lessons.iter().map(|l| l.example.clone()).collect();
        let network = &self.state.network;
        let batch = Batch::new(&examples, network.config(), &self.device)?;
        let loss = Loss::of(&network.forward(&batch), &lessons, &self.config.loss);
        let losses = [&loss.total, &loss.part, &loss.joint].map(|t| t.clone().into_scalar::<f32>());
        if !losses[0].is_finite() {
            return Err(TrainError::Diverged { step, loss: losses[0] });
        }
        let mut gradients = loss.total.backward();
        let moved = self.state.optimiser.step(
            self.state.network.clone(),
            &mut gradients,
            &self.config.schedule,
        );
        self.state.network = moved;
        self.window.push(losses);
        watcher.notice(&Event::Stepped { step, loss: losses[0] });
        if step.is_multiple_of(self.config.every.curve) {
            self.draw_curve(step, watcher)?;
        }
        Ok(())
    }

    /// The lessons of a step: they depend on the seed and the step alone.
    fn lessons(&self, step: u64) -> Result<Vec<Lesson>, TrainError> {
        (0..self.config.batch).map(|place| self.lesson(step, place)).collect()
    }

    fn lesson(&self, step: u64, place: usize) -> Result<Lesson, TrainError> {
        let text = format!("lesson {} {step} {place}", self.config.seed);
        let bytes = *blake3::hash(text.as_bytes()).as_bytes();
        let seed = u64::from_le_bytes(std::array::from_fn(|i| bytes[i]));
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut last = String::new();
        for _ in 0..TRIES {
            let sample = self.library.draw(&mut rng)?;
            match lesson(&sample, &self.config.augment, self.config.lesson(), &mut rng) {
                Ok(lesson) => return Ok(lesson),
                Err(why) => last = why.to_string(),
            }
        }
        Err(TrainError::NoLesson(TRIES, last))
    }

    fn draw_curve(&mut self, step: u64, watcher: &mut dyn Watcher) -> Result<(), TrainError> {
        let count = self.window.len().max(1) as f64;
        let losses: [f64; 3] = std::array::from_fn(|i| {
            self.window.iter().map(|l| f64::from(l[i])).sum::<f64>() / count
        });
        self.window.clear();
        let rate = self.config.schedule.rate_at(step);
        let mut cells: Vec<String> = losses.iter().map(|l| format!("{l:.6}")).collect();
        cells.push(format!("{rate:.6e}"));
        self.curves.add(step, &cells)?;
        watcher.notice(&Event::Curve { step, losses });
        Ok(())
    }

    /// Weights, curves and validation first, the checkpoint last: a run killed in between does
    /// again what lies after the checkpoint on disk.
    fn save(&mut self, watcher: &mut dyn Watcher) -> Result<(), TrainError> {
        let step = self.step();
        self.write_weights()?;
        self.plot()?;
        if step.is_multiple_of(self.config.every.validation) || step == self.config.steps {
            self.validate(watcher)?;
        }
        self.state.note = Note::new(step, &self.identity, &self.config.header());
        self.state.note.window = self.window.iter().map(|l| l.map(f32::to_bits)).collect();
        self.state.write(&self.config.out.join(CHECKPOINT))?;
        watcher.notice(&Event::Saved(step));
        Ok(())
    }

    fn write_weights(&self) -> Result<(), TrainError> {
        let path = self.config.out.join(WEIGHTS);
        let mut bytes = Vec::new();
        save_network_half(&self.state.network, &self.config.header(), &mut bytes)
            .map_err(TrainError::weights(&path))?;
        write_whole(&path, &bytes).map_err(TrainError::io(&path))
    }

    fn plot(&self) -> Result<(), TrainError> {
        let colours =
            [("loss", [40, 44, 52]), ("part_loss", [36, 112, 196]), ("joint_loss", [214, 96, 36])];
        let line = |(name, colour)| Line { name, points: self.curves.column(name), colour };
        plot(&colours.map(line), &self.config.out.join("loss.png"))
    }

    fn validate(&mut self, watcher: &mut dyn Watcher) -> Result<(), TrainError> {
        let (step, size) = (self.step(), self.config.lesson());
        for (set, samples) in &self.validation {
            let score = validate(&self.state.network, samples, size, &self.config.loss)?;
            self.scores.add(step, &score.cells(set))?;
            watcher.notice(&Event::Validated { step, set, score });
        }
        Ok(())
    }
}

fn library(
    config: &TrainConfig,
    sources: &[SourceConfig],
    split: &str,
    watcher: &dyn Watcher,
) -> Result<Library, TrainError> {
    let mut held = BTreeSet::new();
    for path in &config.held_out {
        held.append(&mut held_out(path)?);
    }
    let plan = Plan {
        cache: &config.cache,
        counts: config.sample,
        seed: config.seed,
        split,
        held_out: &held,
    };
    Ok(Library::open(sources, &plan, &|id| watcher.measured(id))?)
}

fn library_of_validation(
    config: &TrainConfig,
    watcher: &dyn Watcher,
) -> Result<Library, TrainError> {
    let sources: Vec<_> = config.validation.iter().map(|v| v.source.clone()).collect();
    library(config, &sources, "val", watcher)
}

/// The state a run begins with: its checkpoint, given weights, or random ones.
fn resume(config: &TrainConfig, identity: &str, device: &Device) -> Result<Checkpoint, TrainError> {
    let path = config.out.join(CHECKPOINT);
    if path.exists() {
        let state = Checkpoint::read(&path, device)?;
        return if state.note.identity == identity {
            Ok(state)
        } else {
            Err(TrainError::OtherRun(path))
        };
    }
    let network = match &config.from {
        None => Network::new(&config.model(), config.seed, device)?,
        Some(path) => {
            let file = File::open(path).map_err(TrainError::io(path))?;
            let (network, header) = load_network(BufReader::new(file), device, Precision::Full)
                .map_err(TrainError::weights(path))?;
            if header != config.header() {
                return Err(TrainError::OtherSizes(path.clone()));
            }
            network
        }
    };
    let note = Note::new(0, identity, &config.header());
    Ok(Checkpoint { note, network, optimiser: AdamW::default() })
}

#[cfg(test)]
mod tests;
