//! One attempt of a stage, on a thread of its own.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::Sender;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use trace::Digest;

use super::errand::{Done, Errand, Workers};
use super::failure::StageError;
use super::gate::{Entry, Gate};
use super::graph::Kind;
use super::inputs::Value;
use super::needs::Resource;
use super::observe::Artefact;
use super::stage::{AnyStage, Made};

/// Stack of a stage's thread, bytes; meshes make deep trees.
const STACK: usize = 32 << 20;

/// An artefact's bytes, and its value once somebody wanted it.
#[derive(Clone)]
pub(super) struct Shelf {
    pub(super) kind: Kind,
    pub(super) digest: Digest,
    pub(super) bytes: Arc<Vec<u8>>,
    value: Arc<OnceLock<Result<Value, StageError>>>,
}

impl Shelf {
    pub(super) fn new(kind: Kind, digest: Digest, bytes: Arc<Vec<u8>>) -> Self {
        Self { kind, digest, bytes, value: Arc::default() }
    }

    pub(super) fn artefact(&self) -> Artefact {
        let bytes = self.bytes.len() as u64;
        Artefact { kind: self.kind, digest: self.digest.clone(), bytes }
    }

    fn value(&self) -> Result<Value, StageError> {
        let decode = || (self.kind.decode)(&self.bytes).map_err(|e| StageError::from_error(&e));
        self.value.get_or_init(decode).clone()
    }
}

/// What is to be tried.
pub(super) struct Attempt {
    pub(super) node: usize,
    pub(super) attempt: u32,
    pub(super) name: &'static str,
    pub(super) resource: Resource,
    pub(super) inputs: Vec<Shelf>,
    pub(super) gate: Arc<dyn Gate>,
    /// Who does it instead of this process.
    pub(super) elsewhere: Option<(Errand, Arc<dyn Workers>)>,
}

/// News of it.
pub(super) struct Report {
    pub(super) node: usize,
    pub(super) attempt: u32,
    pub(super) said: Said,
}

/// What there is to say of an attempt.
pub(super) enum Said {
    /// It has its place and begins.
    Begun,
    /// The gate is closed: it never began.
    KeptOut,
    /// It is over.
    Ended {
        /// What came of it.
        result: Result<Made, StageError>,
        /// How long the work took, without the wait at the gate.
        took: Duration,
    },
}

/// Starts the attempt; reports of it come through `reports`. The thread is left to itself: one that
/// is given up as too slow cannot be stopped, only ignored.
pub(super) fn begin<T: Send + Sync + 'static>(
    work: Attempt,
    stage: Arc<dyn AnyStage<T>>,
    tools: Arc<T>,
    reports: Sender<Report>,
) -> Result<(), StageError> {
    let thread = std::thread::Builder::new().name(work.name.into()).stack_size(STACK);
    let body = move || {
        let Attempt { node, attempt, .. } = work;
        // Nobody listens any more when the run was aborted.
        let say = |said| drop(reports.send(Report { node, attempt, said }));
        let _place = match work.gate.enter(work.name, work.resource) {
            Entry::Open(place) => place,
            Entry::Closed => return say(Said::KeptOut),
            Entry::Refused(error) => {
                return say(Said::Ended { result: Err(error), took: Duration::ZERO });
            }
        };
        if let Some((errand, workers)) = &work.elsewhere {
            return say(sent(&work, errand, &**workers));
        }
        say(Said::Begun);
        let began = Instant::now();
        // A panic in a stage is that stage's failure, not the end of the run.
        let tried = catch_unwind(AssertUnwindSafe(|| self::attempt(&work, &*stage, &tools)));
        let result = tried.unwrap_or_else(|panic| Err(StageError::of_panic(&*panic)));
        say(Said::Ended { result, took: began.elapsed() });
    };
    let started = thread.spawn(body);
    started.map(drop).map_err(|e| StageError::new(format!("cannot start a thread: {e}")))
}

/// Has it done elsewhere; its time is counted there.
fn sent(work: &Attempt, errand: &Errand, workers: &dyn Workers) -> Said {
    let input = |shelf: &Shelf| (shelf.digest.clone(), Arc::clone(&shelf.bytes));
    let inputs: Vec<_> = work.inputs.iter().map(input).collect();
    match workers.perform(errand, &inputs) {
        Ok(Done { result, bytes, took }) => {
            let made = Made { bytes, notes: result.notes, shared: true };
            Said::Ended { result: Ok(made), took }
        }
        Err(error) => Said::Ended { result: Err(error), took: Duration::ZERO },
    }
}

fn attempt<T>(work: &Attempt, stage: &dyn AnyStage<T>, tools: &T) -> Result<Made, StageError> {
    let values = work.inputs.iter().map(Shelf::value).collect::<Result<Vec<_>, _>>()?;
    stage.run(&values, tools)
}
