//! Runs a flow: recalls what is done, starts what is ready, commits what comes back.
//!
//! ```
//! use runner::{Ending, Quiet, StateDir, run};
//! # use std::sync::Arc;
//! # use runner::{Dag, Stage, StageError, Text};
//! # struct Upper;
//! # impl Stage<()> for Upper {
//! #     type Input = Arc<Text>;
//! #     type Output = Text;
//! #     const NAME: &'static str = "upper";
//! #     fn code(&self) -> String {
//! #         "1".into()
//! #     }
//! #     fn run(&self, text: Arc<Text>, _: &()) -> Result<Text, StageError> {
//! #         Ok(Text(text.0.to_uppercase()))
//! #     }
//! # }
//! # let mut dag = Dag::new("shout");
//! # let text = dag.input(Text("a lid".into()));
//! # dag.stage(Upper, text);
//! # use runner::{AlwaysOpen, Cancel, Limits, RunOptions};
//! # let options = RunOptions {
//! #     limits: Limits::default(),
//! #     cancel: Cancel::default(),
//! #     clock: Arc::new(trace::FixedClock(7)),
//! #     version: "1".into(),
//! #     gate: Arc::new(AlwaysOpen),
//! #     workers: None,
//! # };
//!
//! let dir = tempfile::tempdir()?;
//! let state = StateDir::open(dir.path())?;
//! let outcome = run(&dag, &Arc::new(()), &state, &options, &mut Quiet)?;
//! assert!(matches!(outcome.ending, Ending::Done));
//! assert_eq!(outcome.artefact::<(), Text>("upper")?, Text("A LID".into()));
//!
//! let again = run(&dag, &Arc::new(()), &state, &options, &mut Quiet)?;
//! assert!(again.nodes.iter().all(|node| node.recalled || node.stage == "text"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use trace::{Clock, Digest};

use super::artefact::Note;
use super::attempt::{Attempt, Report, Said, Shelf, begin};
use super::cancel::{Cancel, Wish};
use super::errand::{Errand, Workers};
use super::failure::{Blame, StageError};
use super::gate::Gate;
use super::graph::{Dag, Node, Work};
use super::journal::{Committed, Did, Line};
use super::key::{InputDigest, Material};
use super::needs::{Patience, Resource};
use super::observe::{Artefact, Event, ObserveError, Observer, What};
use super::outcome::{Ending, NodeOutcome, Outcome};
use super::schedule::{After, Limits, Schedule, Slot, Status};
use super::stage::Made;
use super::state_dir::{Recall, StateDir, StateError};

/// How often the runner looks whether somebody wants it to stop.
const GLANCE: Duration = Duration::from_millis(50);

/// How to run a flow.
pub struct RunOptions {
    /// Most stages at once.
    pub limits: Limits,
    /// The wish to stop.
    pub cancel: Cancel,
    /// Tells the time of day, for the journal.
    pub clock: Arc<dyn Clock>,
    /// Version of the program, for the journal.
    pub version: String,
    /// Asked before every attempt.
    pub gate: Arc<dyn Gate>,
    /// Who does the stages that compute; this process, if nobody else.
    pub workers: Option<Arc<dyn Workers>>,
}

/// Why a run could not go on at all.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The state directory.
    #[error(transparent)]
    State(#[from] StateError),
    /// The record of the run.
    #[error(transparent)]
    Observe(#[from] ObserveError),
}

/// Runs a flow to its end, or as far as it goes.
///
/// # Errors
/// [`RunError`] when the run cannot be recorded. A stage that gives up is not an error here: see
/// [`Ending::Failed`].
pub fn run<T: Send + Sync + 'static>(
    dag: &Dag<T>,
    tools: &Arc<T>,
    state: &StateDir,
    options: &RunOptions,
    observer: &mut dyn Observer,
) -> Result<Outcome, RunError> {
    let begun = state.journal.begin(dag.name(), &options.version, options.clock.now());
    let number = begun.map_err(state.journal_failed())?;
    let mut driver = Driver::new(dag, tools, state, options, observer, number);
    let result = driver.drive();
    let word = match &result {
        Ok(Ending::Done) => "done",
        Ok(Ending::Failed { .. }) => "failed",
        Ok(Ending::Interrupted(_)) => "interrupted",
        Err(_) => "broken off",
    };
    let nodes = driver.outcomes();
    let ended = state.journal.end(number, word, options.clock.now());
    let outcome = Outcome { ending: result?, nodes };
    // A failed run on a full disk is still a failed run: only a good ending must be on record.
    if matches!(outcome.ending, Ending::Done) {
        ended.map_err(state.journal_failed())?;
    }
    Ok(outcome)
}

struct Driver<'a, T> {
    dag: &'a Dag<T>,
    tools: &'a Arc<T>,
    state: &'a StateDir,
    options: &'a RunOptions,
    observer: &'a mut dyn Observer,
    number: i64,
    schedule: Schedule,
    desks: Vec<Desk>,
    began: Instant,
    sender: Sender<Report>,
    receiver: Receiver<Report>,
    first_failure: Option<(&'static str, StageError)>,
}

/// What is known of a node while the run goes on.
#[derive(Clone, Default)]
struct Desk {
    task: Option<Task>,
    shelf: Option<Shelf>,
    notes: Vec<Note>,
    recalled: bool,
    took: Duration,
}

/// A stage whose inputs are known.
#[derive(Clone)]
struct Task {
    material: Material,
    key: Digest,
}

impl<'a, T: Send + Sync + 'static> Driver<'a, T> {
    fn new(
        dag: &'a Dag<T>,
        tools: &'a Arc<T>,
        state: &'a StateDir,
        options: &'a RunOptions,
        observer: &'a mut dyn Observer,
        number: i64,
    ) -> Self {
        let schedule = Schedule::new(slots(dag), options.limits);
        let desks = vec![Desk::default(); dag.nodes().len()];
        let (sender, receiver) = channel();
        let began = Instant::now();
        let first_failure = None;
        Self {
            dag,
            tools,
            state,
            options,
            observer,
            number,
            schedule,
            desks,
            began,
            sender,
            receiver,
            first_failure,
        }
    }

    fn drive(&mut self) -> Result<Ending, RunError> {
        self.take_inputs()?;
        loop {
            let wish = self.options.cancel.wish();
            if wish == Wish::Go {
                while self.recall_ready()? {}
                self.start_ready()?;
            }
            let later = self.schedule.is_resting() || self.waits_for_another_run();
            let more = self.schedule.is_running() || (later && wish == Wish::Go);
            if wish == Wish::Abort || !more {
                return Ok(self.ending(wish));
            }
            match self.receiver.recv_timeout(GLANCE) {
                Ok(report) => self.take(report)?,
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
            }
            self.drop_overdue()?;
        }
    }

    fn ending(&mut self, wish: Wish) -> Ending {
        if let Some((stage, error)) = self.first_failure.take() {
            return Ending::Failed { stage, error };
        }
        let all_done = (0..self.desks.len()).all(|n| self.schedule.status(n) == Status::Done);
        if all_done { Ending::Done } else { Ending::Interrupted(wish) }
    }

    fn now(&self) -> Duration {
        self.began.elapsed()
    }

    fn take_inputs(&mut self) -> Result<(), RunError> {
        let dag = self.dag;
        for (n, node) in dag.nodes().iter().enumerate() {
            let Work::Given(given) = &node.work else { continue };
            let stored = given.clone().and_then(|bytes| {
                let digest = self.state.store.put(&bytes);
                let house = |e| StageError::from_error(&e).blamed_on(Blame::House);
                Ok((digest.map_err(house)?, bytes))
            });
            match stored {
                Ok((digest, bytes)) => {
                    self.keep(n, digest, Made { bytes, notes: vec![], shared: false }, true)?;
                }
                Err(error) => self.give_up(n, error)?,
            }
        }
        Ok(())
    }

    /// Takes results that are in the store already; true if there was one.
    fn recall_ready(&mut self) -> Result<bool, RunError> {
        let mut any = false;
        for n in self.schedule.ready() {
            if self.desk(n).task.is_some() {
                continue;
            }
            match self.task(n) {
                // Another run makes the very same: what it leaves is recalled.
                Ok(task) if !self.state.claim(&task.key) => {}
                Ok(task) => any |= self.recall(n, task)?,
                Err(error) => self.give_up(n, error)?,
            }
        }
        Ok(any)
    }

    /// Whether a stage could begin but for another run that is at the same work.
    fn waits_for_another_run(&self) -> bool {
        let unclaimed = |n: &usize| self.desks.get(*n).is_some_and(|d| d.task.is_none());
        self.schedule.ready().iter().any(unclaimed)
    }

    fn recall(&mut self, n: usize, task: Task) -> Result<bool, RunError> {
        let key = task.key.clone();
        self.desk(n).task = Some(task);
        match self.state.recall(&key)? {
            Recall::Known(Committed { output, notes }, bytes) => {
                self.journal(n, Did::Recalled, "")?;
                self.tell(n, What::Started)?;
                self.keep(n, output, Made { bytes, notes, shared: false }, true)?;
                return Ok(true);
            }
            Recall::Lost(why) => self.journal(n, Did::Lost, why)?,
            Recall::Unknown => {}
        }
        Ok(false)
    }

    /// What a ready stage's result depends on.
    fn task(&mut self, n: usize) -> Result<Task, StageError> {
        let dag = self.dag;
        let missing = || StageError::new("an input is missing");
        let node = dag.nodes().get(n).ok_or_else(missing)?;
        let Work::Stage(stage) = &node.work else { return Err(missing()) };
        let profile = stage.profile(self.tools)?;
        let mut inputs = Vec::new();
        for &i in &node.inputs {
            let shelf = self.desks.get(i).and_then(|d| d.shelf.as_ref()).ok_or_else(missing)?;
            inputs.push(InputDigest { name: shelf.kind.name.into(), digest: shelf.digest.clone() });
        }
        let material = Material::of(node.name, profile, inputs);
        Ok(Task { key: material.key(), material })
    }

    fn start_ready(&mut self) -> Result<(), RunError> {
        for n in self.schedule.startable(self.now()) {
            if self.desk(n).task.is_none() {
                continue;
            }
            let dag = self.dag;
            let Some(node) = dag.nodes().get(n) else { continue };
            let Work::Stage(stage) = &node.work else { continue };
            let attempt = self.schedule.start(n);
            self.journal(n, Did::Started, "")?;
            if attempt == 1 {
                self.tell(n, What::Started)?;
            }
            let shelf = |i: &usize| self.desks.get(*i).and_then(|d| d.shelf.clone());
            let inputs: Vec<_> = node.inputs.iter().filter_map(shelf).collect();
            let tools = Arc::clone(self.tools);
            let gate = Arc::clone(&self.options.gate);
            let resource = stage.resource();
            let elsewhere = self.elsewhere(n, resource, &inputs);
            let name = node.name;
            let work = Attempt { node: n, attempt, name, resource, inputs, gate, elsewhere };
            if let Err(error) = begin(work, Arc::clone(stage), tools, self.sender.clone()) {
                self.attempt_failed(n, error)?;
            }
        }
        Ok(())
    }

    /// What others are asked to do, and who: stages that compute. Whoever asks a service does so from
    /// here, where the purse, the pace and the record of calls are.
    fn elsewhere(
        &self,
        n: usize,
        resource: Resource,
        inputs: &[Shelf],
    ) -> Option<(Errand, Arc<dyn Workers>)> {
        let workers = self.options.workers.as_ref().filter(|_| resource == Resource::Cpu)?;
        let Task { material, key } = self.desks.get(n)?.task.as_ref()?;
        let inputs = inputs.iter().map(|shelf| shelf.digest.clone()).collect();
        let (stage, key, seed) = (material.stage.clone(), key.clone(), material.seed);
        Some((Errand { stage, key, seed, inputs }, Arc::clone(workers)))
    }

    fn take(&mut self, report: Report) -> Result<(), RunError> {
        let status = self.schedule.status(report.node);
        if !matches!(status, Status::Running { attempt, .. } if attempt == report.attempt) {
            return Ok(()); // an attempt that was given up as too slow
        }
        let (result, took) = match report.said {
            Said::Begun => {
                self.schedule.begun(report.node, self.now());
                return Ok(());
            }
            Said::KeptOut => {
                self.schedule.put_back(report.node);
                return Ok(());
            }
            Said::Ended { result, took } => (result, took),
        };
        self.desk(report.node).took += took;
        match result.and_then(|made| self.commit(report.node, made)) {
            Ok((digest, made)) => self.keep(report.node, digest, made, false),
            Err(error) => self.attempt_failed(report.node, error),
        }
    }

    /// Blob first, then row: a row never names bytes that are not there.
    fn commit(&mut self, n: usize, made: Made) -> Result<(Digest, Made), StageError> {
        let stored = |e: &dyn std::error::Error| {
            StageError::from_error(e)
                .hint("what was done before is kept: the same command goes on from there")
                .blamed_on(Blame::House)
        };
        let output = self.state.store.put(&made.bytes).map_err(|e| stored(&e))?;
        let Some(task) = self.desk(n).task.clone() else { return Ok((output, made)) };
        let own = Committed { output, notes: made.notes };
        let (result, bytes) = if made.shared {
            (own, made.bytes)
        } else {
            self.state.share(&task.key, own, made.bytes).map_err(|e| stored(&e))?
        };
        let (stage, at) = (self.name(n), self.options.clock.now());
        let line =
            Line { run: self.number, stage, key: &task.key, did: Did::Finished, word: "", at };
        let committed = self.state.journal.commit(&line, &task.material, &result, bytes.len());
        committed.map_err(|e| stored(&e))?;
        Ok((result.output, Made { bytes, notes: result.notes, shared: true }))
    }

    fn keep(
        &mut self,
        n: usize,
        digest: Digest,
        made: Made,
        recalled: bool,
    ) -> Result<(), RunError> {
        let Some(kind) = self.dag.nodes().get(n).map(|node| node.artefact) else { return Ok(()) };
        let (bytes, notes) = (Arc::new(made.bytes), made.notes);
        let shelf = Shelf::new(kind, digest.clone(), Arc::clone(&bytes));
        let desk = self.desk(n);
        (desk.shelf, desk.notes, desk.recalled) = (Some(shelf), notes.clone(), recalled);
        self.schedule.done(n);
        self.release(n);
        let output = Artefact { kind, digest, bytes: bytes.len() as u64 };
        self.tell(n, What::Finished { output, bytes, notes, recalled })
    }

    fn attempt_failed(&mut self, n: usize, error: StageError) -> Result<(), RunError> {
        match self.schedule.failed(n, error.again, self.now()) {
            After::Retry(pause) => {
                self.journal(n, Did::Retried, &error.line())?;
                self.tell(n, What::Retry { error, pause })
            }
            After::GaveUp => self.give_up(n, error),
        }
    }

    fn give_up(&mut self, n: usize, error: StageError) -> Result<(), RunError> {
        match self.instead(n, &error) {
            Some(made) => self.go_without(n, &error, made),
            None => self.fail(n, error),
        }
    }

    fn instead(&self, n: usize, error: &StageError) -> Option<Made> {
        let stage = match &self.dag.nodes().get(n)?.work {
            Work::Stage(stage) if error.blame != Blame::House => stage,
            _ => return None,
        };
        stage.instead(error)
    }

    /// The run goes on with what stands in place of a result. No row names it, so that the next run
    /// tries again.
    fn go_without(&mut self, n: usize, error: &StageError, made: Made) -> Result<(), RunError> {
        self.journal(n, Did::Failed, &error.line())?;
        match self.state.store.put(&made.bytes) {
            Ok(digest) => self.keep(n, digest, made, false),
            Err(e) => self.fail(n, StageError::from_error(&e).blamed_on(Blame::House)),
        }
    }

    fn fail(&mut self, n: usize, mut error: StageError) -> Result<(), RunError> {
        self.schedule.give_up(n);
        if let Err(e) = self.journal(n, Did::Failed, &error.line()) {
            error.causes.push(format!("and the run record could not be written: {e}"));
        }
        self.first_failure.get_or_insert((self.name(n), error.clone()));
        self.tell(n, What::Failed(error))
    }

    fn release(&mut self, n: usize) {
        if let Some(task) = self.desks.get(n).and_then(|d| d.task.as_ref()) {
            self.state.release(&task.key);
        }
    }

    fn drop_overdue(&mut self) -> Result<(), RunError> {
        for n in self.schedule.overdue(self.now()) {
            let (patience, resource) = profile_of(self.dag, n);
            let limit = patience.timeout.as_secs_f64();
            let error = StageError::new(format!("took longer than {limit} s and was given up"));
            // A computation that was slow once will be slow again. What a service was asked last is
            // still under way: asking once more beside it could be paid for twice.
            let error = match resource {
                Resource::Network => error.hint(
                    "what was asked last may have been charged; every answer that came is kept, and the same command goes on from there",
                ),
                Resource::Cpu => error,
            };
            self.attempt_failed(n, error)?;
        }
        Ok(())
    }

    fn tell(&mut self, n: usize, what: What) -> Result<(), RunError> {
        let dag = self.dag;
        let Some(node) = dag.nodes().get(n) else { return Ok(()) };
        let shelf = |i: &usize| self.desks.get(*i).and_then(|d| d.shelf.as_ref());
        let inputs = node.inputs.iter().filter_map(shelf).map(Shelf::artefact).collect();
        let desk = self.desks.get(n);
        let task = desk.and_then(|d| d.task.as_ref());
        let own = desk.and_then(|d| d.shelf.as_ref()).map(|s| s.digest.clone());
        let key =
            if matches!(node.work, Work::Given(_)) { own } else { task.map(|t| t.key.clone()) };
        let identity = task.and_then(|t| t.material.identity.clone());
        let event = Event { node: n, stage: node.name, key, identity, inputs, what };
        Ok(self.observer.notice(&event)?)
    }

    fn journal(&mut self, n: usize, did: Did, word: &str) -> Result<(), StateError> {
        let nothing = Digest::of(b"");
        let stage = self.name(n);
        let task = self.desks.get(n).and_then(|d| d.task.as_ref());
        let key = task.map_or(&nothing, |t| &t.key);
        let line = Line { run: self.number, stage, key, did, word, at: self.options.clock.now() };
        self.state.journal.write(&line).map_err(self.state.journal_failed())
    }

    fn name(&self, n: usize) -> &'static str {
        self.dag.nodes().get(n).map_or("", |node| node.name)
    }

    fn desk(&mut self, n: usize) -> &mut Desk {
        if n >= self.desks.len() {
            self.desks.resize(n + 1, Desk::default());
        }
        &mut self.desks[n]
    }

    fn outcomes(&self) -> Vec<NodeOutcome> {
        let one = |(desk, node): (&Desk, &Node<T>)| NodeOutcome {
            stage: node.name,
            key: desk.task.as_ref().map(|t| t.key.clone()),
            identity: desk.task.as_ref().and_then(|t| t.material.identity.clone()),
            output: desk.shelf.as_ref().map(|s| (s.digest.clone(), Arc::clone(&s.bytes))),
            notes: desk.notes.clone(),
            recalled: desk.recalled,
            took: desk.took,
        };
        self.desks.iter().zip(self.dag.nodes()).map(one).collect()
    }
}

impl<T> Drop for Driver<'_, T> {
    /// What this run did not come to, another may.
    fn drop(&mut self) {
        for desk in &self.desks {
            if let (Some(task), None) = (&desk.task, &desk.shelf) {
                self.state.release(&task.key);
            }
        }
    }
}

fn profile_of<T>(dag: &Dag<T>, n: usize) -> (Patience, Resource) {
    match dag.nodes().get(n).map(|node| &node.work) {
        Some(Work::Stage(stage)) => (stage.patience(), stage.resource()),
        _ => (Patience::default(), Resource::Cpu),
    }
}

fn slots<T>(dag: &Dag<T>) -> Vec<Slot> {
    let slot = |(n, node): (usize, &Node<T>)| {
        let (patience, resource) = profile_of(dag, n);
        Slot { inputs: node.inputs.clone(), resource, patience, status: Status::Waiting }
    };
    dag.nodes().iter().enumerate().map(slot).collect()
}
