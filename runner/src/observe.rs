//! Who watches a run: progress as it comes, a trace in the order of the graph.
//!
//! ```
//! use runner::{Event, ObserveError, Observer, StateDir};
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
//! struct Names(Vec<&'static str>);
//!
//! impl Observer for Names {
//!     fn notice(&mut self, event: &Event) -> Result<(), ObserveError> {
//!         self.0.push(event.stage);
//!         Ok(())
//!     }
//! }
//!
//! let dir = tempfile::tempdir()?;
//! let (state, mut names) = (StateDir::open(dir.path())?, Names(vec![]));
//! runner::run(&dag, &Arc::new(()), &state, &options, &mut names)?;
//! assert_eq!(names.0.last(), Some(&"upper"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use trace::{Digest, TraceError};

use super::artefact::Note;
use super::failure::StageError;
use super::graph::Kind;

/// What happened to a node of the graph.
#[derive(Clone, Debug)]
pub struct Event {
    /// Index of the node.
    pub node: usize,
    /// Name of the stage or input.
    pub stage: &'static str,
    /// Key of its result, for an input the digest of its bytes; none if it failed before.
    pub key: Option<Digest>,
    /// Who does the work.
    pub identity: Option<String>,
    /// What it was given.
    pub inputs: Vec<Artefact>,
    /// What happened.
    pub what: What,
}

/// What happened.
#[derive(Clone, Debug)]
pub enum What {
    /// It begins: the first attempt, or its result is about to be taken from the store.
    Started,
    /// An attempt failed, another follows after the pause.
    Retry {
        /// Why it failed.
        error: StageError,
        /// Until the next attempt.
        pause: Duration,
    },
    /// Its artefact is in the store.
    Finished {
        /// The artefact.
        output: Artefact,
        /// Its bytes.
        bytes: Arc<Vec<u8>>,
        /// Its losses and doubts.
        notes: Vec<Note>,
        /// Whether it was there already.
        recalled: bool,
    },
    /// It gave up.
    Failed(StageError),
}

/// An artefact by name, kind and content.
#[derive(Clone, Debug)]
pub struct Artefact {
    /// Name and types.
    pub kind: Kind,
    /// Digest of its bytes.
    pub digest: Digest,
    /// Their number.
    pub bytes: u64,
}

/// The watcher could not keep up its record; the run stops rather than go on unrecorded.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ObserveError(pub String);

impl From<TraceError> for ObserveError {
    fn from(error: TraceError) -> Self {
        Self(format!("the trace cannot be written: {error}"))
    }
}

/// Whoever is told what happens.
pub trait Observer {
    /// Takes note of an event.
    ///
    /// # Errors
    /// [`ObserveError`] when the note cannot be kept.
    fn notice(&mut self, event: &Event) -> Result<(), ObserveError>;
}

/// Nobody.
#[derive(Debug, Default)]
pub struct Quiet;

impl Observer for Quiet {
    fn notice(&mut self, _event: &Event) -> Result<(), ObserveError> {
        Ok(())
    }
}

/// Two watchers, the first told first.
pub struct Both<'a>(pub &'a mut dyn Observer, pub &'a mut dyn Observer);

impl Observer for Both<'_> {
    fn notice(&mut self, event: &Event) -> Result<(), ObserveError> {
        self.0.notice(event)?;
        self.1.notice(event)
    }
}

/// Tells events in the order of the graph, whatever finished first, and leaves out retries: so a
/// record of two runs that made the same things is the same.
pub struct InGraphOrder<'a> {
    inner: &'a mut dyn Observer,
    next: usize,
    held: BTreeMap<usize, Vec<Event>>,
}

impl<'a> InGraphOrder<'a> {
    /// Passes on to `inner`.
    pub fn new(inner: &'a mut dyn Observer) -> Self {
        Self { inner, next: 0, held: BTreeMap::new() }
    }

    /// Passes on what is still held back because something before it never finished.
    ///
    /// # Errors
    /// [`ObserveError`] of the inner observer.
    pub fn release(&mut self) -> Result<(), ObserveError> {
        for (_, events) in std::mem::take(&mut self.held) {
            events.iter().try_for_each(|e| self.inner.notice(e))?;
        }
        Ok(())
    }

    fn pass(&mut self, event: &Event) -> Result<(), ObserveError> {
        self.inner.notice(event)?;
        if matches!(event.what, What::Finished { .. } | What::Failed(_)) {
            self.next = event.node + 1;
            let waiting = self.held.remove(&self.next).unwrap_or_default();
            waiting.iter().try_for_each(|e| self.pass(e))?;
        }
        Ok(())
    }
}

impl Observer for InGraphOrder<'_> {
    fn notice(&mut self, event: &Event) -> Result<(), ObserveError> {
        if matches!(event.what, What::Retry { .. }) {
            return Ok(());
        }
        if event.node <= self.next {
            return self.pass(event);
        }
        self.held.entry(event.node).or_default().push(event.clone());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default)]
    struct Names(Vec<String>);

    impl Observer for Names {
        fn notice(&mut self, event: &Event) -> Result<(), ObserveError> {
            let word = match event.what {
                What::Started => "started",
                What::Retry { .. } => "retry",
                What::Finished { .. } => "finished",
                What::Failed(_) => "failed",
            };
            self.0.push(format!("{} {word}", event.node));
            Ok(())
        }
    }

    fn event(node: usize, what: What) -> Event {
        Event { node, stage: "x", key: None, identity: None, inputs: vec![], what }
    }

    fn failed() -> What {
        What::Failed(StageError::new("no"))
    }

    #[test]
    fn events_come_out_in_graph_order_whatever_finished_first() {
        let mut names = Names::default();
        let mut ordered = InGraphOrder::new(&mut names);
        let pause = Duration::ZERO;
        let retry = What::Retry { error: StageError::new("no"), pause };
        let order = [
            (0, What::Started),
            (2, What::Started),
            (1, What::Started),
            (2, failed()),
            (0, retry),
            (0, failed()),
            (1, failed()),
        ];
        for (node, what) in order {
            ordered.notice(&event(node, what)).unwrap();
        }
        ordered.release().unwrap();
        let expected = ["0 started", "0 failed", "1 started", "1 failed", "2 started", "2 failed"];
        assert_eq!(names.0, expected);
    }

    #[test]
    fn what_waits_for_something_that_never_came_is_told_at_the_end() {
        let mut names = Names::default();
        let mut ordered = InGraphOrder::new(&mut names);
        ordered.notice(&event(3, What::Started)).unwrap();
        ordered.notice(&event(3, failed())).unwrap();
        ordered.release().unwrap();
        assert_eq!(names.0, ["3 started", "3 failed"]);
    }
}
