//! A flow of three stages on text, for the runner's own tests.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use trace::FixedClock;

use super::artefact::Text;
use super::cancel::Cancel;
use super::failure::StageError;
use super::gate::AlwaysOpen;
use super::graph::Dag;
use super::needs::{Patience, Resource};
use super::observe::Observer;
use super::outcome::Outcome;
use super::run::{RunOptions, run};
use super::schedule::Limits;
use super::stage::Stage;
use super::state_dir::StateDir;

/// What toy stages reach the outside through.
#[derive(Default)]
pub(super) struct Toys {
    /// How often each stage ran.
    pub(super) ran: Mutex<BTreeMap<&'static str, u32>>,
    /// What `join` puts between its inputs.
    pub(super) glue: String,
    /// How often `join` fails before it works.
    pub(super) failures: AtomicU32,
    /// How `join` fails.
    pub(super) failure: Option<StageError>,
    /// How long `join` takes.
    pub(super) nap: Duration,
    /// Pressed once while `join` runs.
    pub(super) cancel: Option<Cancel>,
    /// Version of `upper`.
    pub(super) code: u32,
}

impl Toys {
    fn count(&self, stage: &'static str) {
        *self.ran.lock().unwrap().entry(stage).or_default() += 1;
    }

    pub(super) fn times(&self, stage: &str) -> u32 {
        self.ran.lock().unwrap().get(stage).copied().unwrap_or_default()
    }
}

pub(super) struct Upper(u32);

impl Stage<Toys> for Upper {
    type Input = Arc<Text>;
    type Output = Text;
    const NAME: &'static str = "upper";
    fn code(&self) -> String {
        self.0.to_string()
    }
    fn run(&self, text: Arc<Text>, toys: &Toys) -> Result<Text, StageError> {
        toys.count("upper");
        Ok(Text(text.0.to_uppercase()))
    }
}

pub(super) struct Reverse;

impl Stage<Toys> for Reverse {
    type Input = Arc<Text>;
    type Output = Text;
    const NAME: &'static str = "reverse";
    fn code(&self) -> String {
        "1".into()
    }
    fn run(&self, text: Arc<Text>, toys: &Toys) -> Result<Text, StageError> {
        toys.count("reverse");
        Ok(Text(text.0.chars().rev().collect()))
    }
}

pub(super) struct Join;

impl Stage<Toys> for Join {
    type Input = (Arc<Text>, Arc<Text>);
    type Output = Text;
    const NAME: &'static str = "join";
    fn code(&self) -> String {
        "1".into()
    }
    fn identity(&self, toys: &Toys) -> Result<Option<String>, StageError> {
        Ok(Some(format!("glue {}", toys.glue)))
    }
    fn patience(&self) -> Patience {
        let timeout = Duration::from_secs(2);
        Patience { timeout, attempts: 3, pause: Duration::from_millis(5) }
    }
    fn run(&self, (a, b): Self::Input, toys: &Toys) -> Result<Text, StageError> {
        toys.count("join");
        if let Some(cancel) = &toys.cancel {
            cancel.press();
        }
        std::thread::sleep(toys.nap);
        if let Some(failure) = &toys.failure
            && toys
                .failures
                .fetch_update(Ordering::SeqCst, Ordering::SeqCst, |n| n.checked_sub(1))
                .is_ok()
        {
            if failure.message == "panic" {
                // Past the hook: looking up a trace of the stack may take longer than a toy may.
                std::panic::resume_unwind(Box::new("a toy broke"));
            }
            return Err(failure.clone());
        }
        Ok(Text(format!("{}{}{}", a.0, toys.glue, b.0)))
    }
}

/// A stage the flow can do without: it fails as it is told to.
pub(super) struct Sigh;

impl Stage<Toys> for Sigh {
    type Input = Arc<Text>;
    type Output = Text;
    const NAME: &'static str = "sigh";
    fn code(&self) -> String {
        "1".into()
    }
    fn run(&self, text: Arc<Text>, toys: &Toys) -> Result<Text, StageError> {
        toys.count("sigh");
        toys.failure.clone().map_or(Ok(Text(format!("{}!", text.0))), Err)
    }
    fn instead(&self, error: &StageError) -> Option<Text> {
        Some(Text(format!("no sigh: {}", error.line())))
    }
}

/// A stage that asks somebody who takes his time, and may be asked three times.
pub(super) struct Ask;

impl Stage<Toys> for Ask {
    type Input = Arc<Text>;
    type Output = Text;
    const NAME: &'static str = "ask";
    fn code(&self) -> String {
        "1".into()
    }
    fn resource(&self) -> Resource {
        Resource::Network
    }
    fn patience(&self) -> Patience {
        let timeout = Duration::from_millis(200);
        Patience { timeout, attempts: 3, pause: Duration::from_millis(5) }
    }
    fn run(&self, text: Arc<Text>, toys: &Toys) -> Result<Text, StageError> {
        toys.count("ask");
        std::thread::sleep(toys.nap);
        Ok(Text(text.0.clone()))
    }
}

/// text → ask.
pub(super) fn asking(text: &str) -> Dag<Toys> {
    let mut dag = Dag::new("toy");
    let text = dag.input(Text(text.into()));
    dag.stage(Ask, text);
    dag
}

/// text → sigh → upper.
pub(super) fn sighing(text: &str) -> Dag<Toys> {
    let mut dag = Dag::new("toy");
    let text = dag.input(Text(text.into()));
    let sigh = dag.stage(Sigh, text);
    dag.stage(Upper(1), sigh);
    dag
}

/// text → upper, text → reverse, (upper, reverse) → join → upper.
pub(super) fn flow(text: &str) -> Dag<Toys> {
    flow_of(text, 1)
}

pub(super) fn flow_of(text: &str, code: u32) -> Dag<Toys> {
    let mut dag = Dag::new("toy");
    let text = dag.input(Text(text.into()));
    let upper = dag.stage(Upper(code), text);
    let reverse = dag.stage(Reverse, text);
    dag.stage(Join, (upper, reverse));
    dag
}

pub(super) fn options(cancel: Cancel) -> RunOptions {
    let clock = Arc::new(FixedClock(7));
    let (limits, gate) = (Limits::default(), Arc::new(AlwaysOpen));
    RunOptions { limits, cancel, clock, version: "0".into(), gate, workers: None }
}

/// Runs the toy flow in a state directory.
pub(super) fn play(
    text: &str,
    toys: Toys,
    state: &Path,
    observer: &mut dyn Observer,
) -> (Outcome, Arc<Toys>) {
    let state = StateDir::open(state).unwrap();
    let options = options(toys.cancel.clone().unwrap_or_default());
    let toys = Arc::new(toys);
    let dag = flow_of(text, toys.code);
    let outcome = run(&dag, &toys, &state, &options, observer).unwrap();
    (outcome, toys)
}
