//! What the server asks of the house it stands in.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

/// Builds, checks and keeps what was built. Everything is asked of it on threads that may wait.
pub trait House: Send + Sync + 'static {
    /// Why nothing can be built here; nothing where it can.
    fn why_not(&self) -> Option<String>;

    /// How many stages a build goes through.
    fn stages(&self, order: &Order) -> usize;

    /// Builds an asset from the order's condition, telling of each stage. It ends soon
    /// after `stop` says so.
    ///
    /// # Errors
    /// [`Failure`], as a command line would tell it.
    fn build(
        &self,
        order: &Order,
        tell: Tell<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Outcome, Failure>;

    /// What was built last, as a page shows it; nothing where nothing was.
    ///
    /// # Errors
    /// [`Failure`] when it cannot be read.
    fn built(&self) -> Result<Option<Built>, Failure>;

    /// The files of what was built last.
    ///
    /// # Errors
    /// [`Failure`] when they cannot be listed.
    fn artefacts(&self) -> Result<Vec<Artefact>, Failure>;

    /// One of them by its name; nothing where there is none of that name.
    ///
    /// # Errors
    /// [`Failure`] when it cannot be read.
    fn artefact(&self, name: &str) -> Result<Option<Vec<u8>>, Failure>;

    /// Checks any model on this machine, as the command line does, to its verdict.
    ///
    /// # Errors
    /// [`Failure`] when it cannot be checked.
    fn check(&self, path: &str) -> Result<Value, Failure>;

    /// Whether somebody can be asked for a condition.
    fn can_draft(&self) -> bool;

    /// Asks for a condition of the photo and the mesh, as the text of a file.
    ///
    /// # Errors
    /// [`Failure`] when nobody can be asked, or nobody answers.
    fn draft(&self) -> Result<String, Failure>;
}

/// Told of each stage of a build.
pub type Tell<'a> = &'a (dyn Fn(&'static str, StageState) + Sync);

/// What is to be built.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Order {
    /// The condition that is built, as the text of a file: what stands on disk may be another by then.
    pub condition: String,
    /// Formats besides URDF, by name: `mjcf`, `usd`, `glb`.
    pub export: Vec<String>,
}

/// What became of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum StageState {
    /// It runs.
    Running,
    /// It ran.
    Done,
    /// Its result was there already.
    Kept,
    /// It failed.
    Failed,
}

/// How a build ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Outcome {
    /// As the command line's: 0 done, 3 below the tier asked for or something lost.
    pub exit: u8,
    /// The tier it reaches.
    pub tier: Option<String>,
    /// What a person should know, line by line.
    pub remarks: Vec<String>,
    /// Where it stands.
    pub out: String,
}

/// Why something cannot be done: what is wrong and what to do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Failure {
    /// The rule and what was found.
    pub message: String,
    /// What a person can do about it.
    pub hint: Option<String>,
}

impl Failure {
    /// A failure without advice.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None }
    }

    /// The same with advice.
    #[must_use]
    pub fn with_hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }
}

/// What was built, as a page shows it.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Built {
    /// The page's scene (`kinfold-page/1`): links, joints, checks.
    pub scene: Value,
    /// Its surfaces, packed as in a page: base64 of deflated bytes.
    pub geometry: String,
    /// What could be done about what was found.
    pub remedies: Vec<Remedy>,
}

/// A change of the condition that answers something that was found.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Remedy {
    /// The check by its id.
    pub check: String,
    /// Which of the check's findings, from 0.
    pub evidence: usize,
    /// In words, for a button.
    pub label: String,
    /// The part that is changed; none for the whole object.
    pub part: Option<String>,
    /// Which of its joints, where it has several.
    pub index: Option<usize>,
    /// Fields of `kinfold-condition/2` to set; null takes one away.
    pub set: Map<String, Value>,
}

/// A file of an asset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Artefact {
    /// Its path inside the asset's folder, with `/` between.
    pub name: String,
    /// Its length.
    pub bytes: u64,
}
