//! What a stage is: a plain function with a name, a version and a patience.
//!
//! ```
//! use std::sync::Arc;
//!
//! use runner::{Stage, StageError, Text};
//!
//! struct Upper;
//!
//! impl Stage<()> for Upper {
//!     type Input = Arc<Text>;
//!     type Output = Text;
//!     const NAME: &'static str = "upper";
//!
//!     fn code(&self) -> String {
//!         "1".into()
//!     }
//!
//!     fn run(&self, text: Arc<Text>, _: &()) -> Result<Text, StageError> {
//!         Ok(Text(text.0.to_uppercase()))
//!     }
//! }
//!
//! let made = Upper.run(Arc::new(Text("a lid".into())), &())?;
//! assert_eq!(made, Text("A LID".into()));
//! # Ok::<(), StageError>(())
//! ```

use super::artefact::{Artefact, Note};
use super::failure::StageError;
use super::inputs::{Inputs, Value};
use super::needs::{Patience, Resource};

/// One step of a flow: a function from artefacts to an artefact.
///
/// Promise: the same inputs, tools of the same identity and the same seed give the same output,
/// byte for byte. Clock, network and disk are reached through the tools `T` only.
pub trait Stage<T>: Send + Sync + 'static {
    /// The artefacts it reads: `Arc<A>`, or a tuple of them.
    type Input: Inputs<T>;
    /// The artefact it makes.
    type Output: Artefact<T>;
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
