//! Stages that are done elsewhere: digests go there and digests come back, the bytes stand in the
//! shared store.
//!
//! ```
//! use runner::{Answer, Errand, FolderDepot};
//! use trace::Digest;
//!
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
//! let dir = tempfile::tempdir()?;
//! let depot = FolderDepot::open(&dir.path().join("shared"), "worker")?;
//! let (stage, inputs) = ("upper".into(), vec![Digest::of(b"a lid")]);
//! let errand = Errand { stage, key: Digest::of(b"of another version"), seed: None, inputs };
//! assert!(matches!(dag.perform(&errand, &(), &depot)?, Answer::Strange(_)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use trace::Digest;

use super::artefact::Note;
use super::depot::{Depot, DepotError};
use super::failure::{Blame, StageError};
use super::graph::{Dag, Kind, Node, Work};
use super::inputs::Value;
use super::journal::Committed;
use super::key::{InputDigest, Material};
use super::needs::{Patience, Resource};
use super::stage::AnyStage;
use super::store::Found;

/// A stage that somebody else is to do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Errand {
    /// Its name.
    pub stage: String,
    /// The key of its result, as whoever asks has it.
    pub key: Digest,
    /// The seed, where it matters.
    pub seed: Option<u64>,
    /// Its inputs in order.
    pub inputs: Vec<Digest>,
}

/// What there is to say about an errand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Answer {
    /// It is done: the result stands in the shared store.
    Made {
        /// Digest of the artefact.
        output: Digest,
        /// Its losses and doubts.
        notes: Vec<Note>,
        /// How long the work took.
        seconds: f64,
    },
    /// These inputs are not in the shared store, or not whole.
    Missing(Vec<Digest>),
    /// It has this key here: another version of the program, or another articulator.
    Strange(Digest),
    /// The stage gave up.
    Failed {
        /// The rule and what was found.
        message: String,
        /// What lies behind it, outermost first.
        causes: Vec<String>,
        /// What a person can do about it.
        hint: Option<String>,
    },
}

impl Answer {
    /// A stage's own failure.
    pub fn failed(error: StageError) -> Self {
        let StageError { message, causes, hint, .. } = error;
        Self::Failed { message, causes, hint }
    }
}

/// What came of an errand.
#[derive(Clone, Debug)]
pub struct Done {
    /// The result that stands in the shared store.
    pub result: Committed,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// How long the work took.
    pub took: Duration,
}

/// An input by digest, with its bytes.
pub type Input = (Digest, Arc<Vec<u8>>);

/// Others who do the work of stages that compute.
///
/// Promise: what is returned stands in the shared store, whole, under the errand's key. May wait as
/// long as it takes; how long a stage may take is counted there.
pub trait Workers: Send + Sync {
    /// Has an errand done.
    ///
    /// # Errors
    /// [`StageError`] of the stage, or one that passes when nobody could be asked.
    fn perform(&self, errand: &Errand, inputs: &[Input]) -> Result<Done, StageError>;
}

/// A stage that computes, and its place in the flow.
type Computing<'a, T> = (&'a Node<T>, &'a Arc<dyn AnyStage<T>>);

/// Why a worker could not even try.
#[derive(Debug, thiserror::Error)]
pub enum ErrandError {
    /// The shared store.
    #[error(transparent)]
    Depot(#[from] DepotError),
    /// The worker's own disk.
    #[error("{0}")]
    House(String),
}

impl<T> Dag<T> {
    /// The stages that compute, with their patience: those that others can do.
    pub fn computing(&self) -> Vec<(&'static str, Patience)> {
        let computes = |node: &Node<T>| match &node.work {
            Work::Stage(stage) if stage.resource() == Resource::Cpu => {
                Some((node.name, stage.patience()))
            }
            _ => None,
        };
        self.nodes().iter().filter_map(computes).collect()
    }

    /// Does an errand: recalls its result from the shared store, or makes it and puts it there.
    ///
    /// # Errors
    /// [`ErrandError`] when it could not be tried; another try may help.
    pub fn perform(
        &self,
        errand: &Errand,
        tools: &T,
        depot: &dyn Depot,
    ) -> Result<Answer, ErrandError> {
        let Some((node, stage)) = self.computing_stage(&errand.stage) else {
            return Ok(Answer::Strange(Digest::of(b"")));
        };
        let profile = match stage.profile(tools) {
            Ok(profile) => profile,
            Err(error) => return told(error),
        };
        let sources = node.inputs.iter().filter_map(|&i| self.nodes().get(i));
        let kinds: Vec<_> = sources.map(|source| source.artefact).collect();
        let name = |(kind, digest): (&Kind, &Digest)| InputDigest {
            name: kind.name.into(),
            digest: digest.clone(),
        };
        let inputs = kinds.iter().zip(&errand.inputs).map(name).collect();
        let key = Material::of(node.name, profile, inputs).key();
        if key != errand.key || kinds.len() != errand.inputs.len() {
            return Ok(Answer::Strange(key));
        }
        if let Some(Committed { output, notes }) = depot.result(&key)?
            && matches!(depot.blob(&output)?, Found::Whole(_))
        {
            return Ok(Answer::Made { output, notes, seconds: 0.0 });
        }
        let (mut values, mut missing) = (Vec::new(), Vec::new());
        for (kind, digest) in kinds.iter().zip(&errand.inputs) {
            match depot.blob(digest)? {
                Found::Whole(bytes) => values.push((kind.decode)(&bytes)),
                Found::Absent | Found::Damaged => missing.push(digest.clone()),
            }
        }
        if !missing.is_empty() {
            return Ok(Answer::Missing(missing));
        }
        match values.into_iter().collect::<Result<Vec<_>, _>>() {
            Ok(values) => made(&**stage, &values, tools, (&key, depot)),
            Err(error) => told(StageError::from_error(&error)),
        }
    }

    fn computing_stage(&self, name: &str) -> Option<Computing<'_, T>> {
        self.nodes().iter().find_map(|node| match &node.work {
            Work::Stage(stage) if node.name == name && stage.resource() == Resource::Cpu => {
                Some((node, stage))
            }
            _ => None,
        })
    }
}

/// Runs the stage and brings what it made to the shared store; the first one's result stands.
fn made<T>(
    stage: &dyn AnyStage<T>,
    values: &[Value],
    tools: &T,
    (key, depot): (&Digest, &dyn Depot),
) -> Result<Answer, ErrandError> {
    let began = Instant::now();
    let tried = catch_unwind(AssertUnwindSafe(|| stage.run(values, tools)));
    let made = match tried.unwrap_or_else(|panic| Err(StageError::of_panic(&*panic))) {
        Ok(made) => made,
        Err(error) => return told(error),
    };
    let seconds = began.elapsed().as_secs_f64();
    let own = Committed { output: Digest::of(&made.bytes), notes: made.notes };
    depot.put_blob(&own.output, &made.bytes)?;
    let mut stands = depot.put_result(key, &own)?;
    if stands.output != own.output && !matches!(depot.blob(&stands.output)?, Found::Whole(_)) {
        stands = own;
    }
    Ok(Answer::Made { output: stands.output, notes: stands.notes, seconds })
}

/// A failure of the stage is an answer; one of this machine is not.
fn told(error: StageError) -> Result<Answer, ErrandError> {
    match error.blame {
        Blame::House => Err(ErrandError::House(error.line())),
        Blame::Work | Blame::Budget => Ok(Answer::failed(error)),
    }
}

#[cfg(test)]
mod tests;
