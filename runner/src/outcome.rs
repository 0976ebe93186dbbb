//! What a run came to.
//!
//! ```
//! use runner::{Ending, Outcome};
//!
//! let outcome = Outcome { ending: Ending::Done, nodes: vec![] };
//! assert_eq!(outcome.bytes("upper").unwrap_err().line(), "upper made nothing");
//! ```

use std::sync::Arc;
use std::time::Duration;

use trace::Digest;

use super::artefact::{Artefact, Note};
use super::cancel::Wish;
use super::failure::StageError;

/// What a run came to.
#[derive(Debug)]
pub struct Outcome {
    /// How it ended.
    pub ending: Ending,
    /// What became of each node, in graph order.
    pub nodes: Vec<NodeOutcome>,
}

impl Outcome {
    /// What a stage made.
    ///
    /// # Errors
    /// [`StageError`] when it made nothing, or nothing that can be read.
    pub fn artefact<T, A: Artefact<T>>(&self, stage: &str) -> Result<A, StageError> {
        A::decode(self.bytes(stage)?).map_err(|e| StageError::from_error(&e))
    }

    /// The bytes a stage made.
    ///
    /// # Errors
    /// [`StageError`] when it made nothing.
    pub fn bytes(&self, stage: &str) -> Result<&[u8], StageError> {
        let node = self.nodes.iter().find(|n| n.stage == stage);
        let output = node.and_then(|n| n.output.as_ref());
        let (_, bytes) = output.ok_or_else(|| StageError::new(format!("{stage} made nothing")))?;
        Ok(bytes)
    }
}

/// How a run ended.
#[derive(Debug)]
pub enum Ending {
    /// Every artefact is in the store.
    Done,
    /// A stage gave up.
    Failed {
        /// Its name.
        stage: &'static str,
        /// Why.
        error: StageError,
    },
    /// Somebody wanted it to stop; the same command goes on from here.
    Interrupted(Wish),
}

/// What became of a node.
#[derive(Clone, Debug)]
pub struct NodeOutcome {
    /// Stage or input.
    pub stage: &'static str,
    /// Key of its result.
    pub key: Option<Digest>,
    /// Who does the work.
    pub identity: Option<String>,
    /// Digest and bytes of its artefact.
    pub output: Option<(Digest, Arc<Vec<u8>>)>,
    /// Losses and doubts.
    pub notes: Vec<Note>,
    /// Whether the result was there already.
    pub recalled: bool,
    /// How long the work took this time.
    pub took: Duration,
}
