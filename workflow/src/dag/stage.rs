//! What a stage is: a plain function with a name, a version and a patience.

use std::any::Any;
use std::sync::Arc;
use std::time::Duration;

use super::artefact::{Artefact, Note};
use super::graph::Inputs;
use super::schedule::Resource;

/// A decoded artefact on its way from one stage to another.
pub type Value = Arc<dyn Any + Send + Sync>;

/// One step of a flow: a function from artefacts to an artefact.
///
/// Promise: the same inputs, tools of the same identity and the same seed give the same output,
/// byte for byte. Clock, network and disk are reached through the tools `T` only.
pub trait Stage<T>: Send + Sync + 'static {
    /// The artefacts it reads: `Arc<A>`, or a tuple of them.
    type Input: Inputs;
    /// The artefact it makes.
    type Output: Artefact;
    /// Its name, such as `render-views`.
    const NAME: &'static str;

    /// Version of its code: a change means that old results are not its results.
    fn code(&self) -> String;

    /// Parameters its result depends on.
    fn params(&self, _tools: &T) -> serde_json::Value {
        serde_json::Value::Null
    }

    /// The seed, if its result depends on it.
    fn seed(&self, _tools: &T) -> Option<u64> {
        None
    }

    /// Who does the work: adapter, solver or model, with version.
    ///
    /// # Errors
    /// [`StageError`] when that cannot be told, for example because a file is missing.
    fn identity(&self, _tools: &T) -> Result<Option<String>, StageError> {
        Ok(None)
    }

    /// What it occupies while it runs.
    fn resource(&self) -> Resource {
        Resource::Cpu
    }

    /// How long and how often it may try.
    fn patience(&self) -> Patience {
        Patience::default()
    }

    /// Does the work.
    ///
    /// # Errors
    /// [`StageError`], saying whether another try may help.
    fn run(&self, input: Self::Input, tools: &T) -> Result<Self::Output, StageError>;

    /// What stands in place of the result where the stage gave up and the flow can do without it;
    /// none where it cannot. It is told and handed on like a result, and kept as none: the next run
    /// tries again. Nobody asks where the house is at fault.
    fn instead(&self, _error: &StageError) -> Option<Self::Output> {
        None
    }
}

/// How long a stage may take and how often it may try.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// Longest time of one attempt.
    pub timeout: Duration,
    /// Most attempts, at least 1.
    pub attempts: u32,
    /// Pause before the second attempt; doubles each time.
    pub pause: Duration,
}

impl Default for Patience {
    /// Ten minutes, one attempt.
    fn default() -> Self {
        Self { timeout: Duration::from_secs(600), attempts: 1, pause: Duration::from_secs(1) }
    }
}

/// Whether another attempt may help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Again {
    /// The same inputs will fail the same way.
    Never,
    /// The cause may pass; wait at least so long where the other side said so.
    Later(Option<Duration>),
}

/// What a failure is a failure of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blame {
    /// The stage's own work, on these inputs.
    #[default]
    Work,
    /// What may be spent is spent; the work was not begun.
    Budget,
    /// The house: its disk or its record. Any other work would fail the same way.
    House,
}

/// Why a stage gave up.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{message}")]
pub struct StageError {
    /// The rule and what was found.
    pub message: String,
    /// What lies behind it, outermost first.
    pub causes: Vec<String>,
    /// What a person can do about it.
    pub hint: Option<String>,
    /// Whether to try again.
    pub again: Again,
    /// What it is a failure of.
    pub blame: Blame,
}

impl StageError {
    /// An error that the same inputs will meet again.
    pub fn new(message: impl Into<String>) -> Self {
        let (causes, hint, again) = (Vec::new(), None, Again::Never);
        Self { message: message.into(), causes, hint, again, blame: Blame::Work }
    }

    /// The same for an error of another room, with its chain of causes.
    pub fn from_error(error: &dyn std::error::Error) -> Self {
        let mut causes: Vec<String> = Vec::new();
        let mut source = error.source();
        while let Some(cause) = source {
            causes.push(cause.to_string());
            source = cause.source();
        }
        Self { causes: without_repeats(&error.to_string(), causes), ..Self::new(error.to_string()) }
    }

    /// The same error with a word before it, such as the file it is about.
    #[must_use]
    pub fn about(mut self, subject: impl std::fmt::Display) -> Self {
        self.message = format!("{subject}: {}", self.message);
        self
    }

    /// The same error with advice.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The same error, worth another attempt.
    #[must_use]
    pub fn later(mut self, after: Option<Duration>) -> Self {
        self.again = Again::Later(after);
        self
    }

    /// The same error, of something other than the work.
    #[must_use]
    pub fn blamed_on(mut self, blame: Blame) -> Self {
        self.blame = blame;
        self
    }

    /// An error of the disk: the house's if it is full or may not be written, whoever meets it.
    pub fn from_io(error: &std::io::Error) -> Self {
        let blame = if is_of_the_house(error) { Blame::House } else { Blame::Work };
        Self::from_error(error).blamed_on(blame)
    }

    /// Message and causes in one line.
    pub fn line(&self) -> String {
        let mut parts = vec![self.message.clone()];
        parts.extend(self.causes.iter().cloned());
        parts.join(": ")
    }
}

/// Whether an error of the disk would meet any other file, too.
pub fn is_of_the_house(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{QuotaExceeded, ReadOnlyFilesystem, StorageFull};
    matches!(error.kind(), StorageFull | ReadOnlyFilesystem | QuotaExceeded)
}

/// Drops causes whose words stand in the message already, as `#[error("...: {source}")]` leads to.
fn without_repeats(message: &str, causes: Vec<String>) -> Vec<String> {
    let mut said = message.to_string();
    let mut kept = Vec::new();
    for cause in causes {
        if !said.contains(&cause) {
            said.push_str(&cause);
            kept.push(cause);
        }
    }
    kept
}

/// What one attempt of a stage made.
#[derive(Clone, Debug)]
pub struct Made {
    /// The artefact's bytes.
    pub bytes: Vec<u8>,
    /// Its losses and doubts.
    pub notes: Vec<Note>,
    /// Whether it stands in the shared store already.
    pub shared: bool,
}

/// What the key, plan and schedule want to know of a stage.
#[derive(Clone, Debug)]
pub struct Profile {
    /// See [`Stage::code`].
    pub code: String,
    /// See [`Stage::params`].
    pub params: serde_json::Value,
    /// See [`Stage::seed`].
    pub seed: Option<u64>,
    /// See [`Stage::identity`].
    pub identity: Option<String>,
}

/// A stage with its types forgotten, as the graph holds it.
pub(super) trait AnyStage<T>: Send + Sync {
    fn profile(&self, tools: &T) -> Result<Profile, StageError>;
    fn resource(&self) -> Resource;
    fn patience(&self) -> Patience;
    fn run(&self, values: &[Value], tools: &T) -> Result<Made, StageError>;
    fn instead(&self, error: &StageError) -> Option<Made>;
}

impl<T, S: Stage<T>> AnyStage<T> for S {
    fn profile(&self, tools: &T) -> Result<Profile, StageError> {
        let (code, params, seed) = (self.code(), self.params(tools), Stage::seed(self, tools));
        Ok(Profile { code, params, seed, identity: self.identity(tools)? })
    }

    fn resource(&self) -> Resource {
        Stage::resource(self)
    }

    fn patience(&self) -> Patience {
        Stage::patience(self)
    }

    fn run(&self, values: &[Value], tools: &T) -> Result<Made, StageError> {
        let input = S::Input::of(values).ok_or_else(|| {
            StageError::new(format!("{} was handed artefacts of another type", S::NAME))
        })?;
        let output = Stage::run(self, input, tools)?;
        let bytes = output.encode().map_err(|e| StageError::from_error(&e))?;
        Ok(Made { bytes, notes: output.notes(), shared: false })
    }

    fn instead(&self, error: &StageError) -> Option<Made> {
        let output = Stage::instead(self, error)?;
        Some(Made { bytes: output.encode().ok()?, notes: output.notes(), shared: false })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("lid.glb: {source}")]
    struct Outer {
        source: std::io::Error,
    }

    #[test]
    fn a_cause_that_the_message_tells_already_is_not_told_twice() {
        let source = std::io::Error::other("the disk is full");
        let error = StageError::from_error(&Outer { source });
        assert_eq!(error.line(), "lid.glb: the disk is full");
        assert_eq!(error.about("mesh").line(), "mesh: lid.glb: the disk is full");
    }
}
