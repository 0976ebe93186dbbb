//! What a service asks of the house it stands in.

use std::collections::BTreeMap;

use object::condition::ConditionError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::house::Failure;

/// Takes jobs in and keeps what becomes of them. Everything is asked of it on threads that may wait, and for
/// somebody: whose token it is, by name.
pub trait Works: Send + Sync + 'static {
    /// What can be asked for here, and what may still be spent.
    ///
    /// # Errors
    /// [`Failure`] when it cannot be said.
    fn about(&self, who: &str) -> Result<About, Failure>;

    /// Begins to take a file in.
    ///
    /// # Errors
    /// [`Failure`] when there is no room for it.
    fn receive(&self, who: &str) -> Result<Box<dyn Incoming>, Failure>;

    /// Takes a job in; one that was asked for before is the same job. It survives whatever happens next.
    ///
    /// # Errors
    /// [`Refused`] with the reason.
    fn submit(&self, who: &str, order: JobOrder) -> Result<Submitted, Refused>;

    /// A job by its id; nothing where this one has no such job.
    ///
    /// # Errors
    /// [`Failure`] when it cannot be read.
    fn job(&self, who: &str, id: &str) -> Result<Option<Job>, Failure>;

    /// Jobs, the newest first: at most so many of those before the job `before`.
    ///
    /// # Errors
    /// [`Failure`] when they cannot be read.
    fn jobs(&self, who: &str, before: Option<&str>, most: usize) -> Result<Vec<Job>, Failure>;

    /// A file that a job left, by its digest; nothing where it left none of that digest.
    ///
    /// # Errors
    /// [`Failure`] when it cannot be read, or is another by now.
    fn artefact(&self, who: &str, id: &str, digest: &str) -> Result<Option<Vec<u8>>, Failure>;
}

/// A file that comes in.
pub trait Incoming: Send {
    /// Takes some more of it.
    ///
    /// # Errors
    /// What the disk says.
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<()>;

    /// Keeps it, under its digest. One that is dropped before leaves nothing.
    ///
    /// # Errors
    /// [`Failure`] when the disk refuses.
    fn keep(self: Box<Self>) -> Result<Kept, Failure>;
}

/// A file that was taken in.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Kept {
    /// Its digest: BLAKE3, 64 hexadecimal digits.
    pub digest: String,
    /// Its length.
    pub bytes: u64,
}

/// What a service makes, and what may be asked of it.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct About {
    /// The version of kinfold.
    pub version: String,
    /// Whose token this is.
    pub token: String,
    /// The formats that are written, by name.
    pub formats: Vec<String>,
    /// The tier from which an asset is accepted.
    pub tier: String,
    /// Whether somebody makes meshes for jobs that bring none.
    pub makes_meshes: bool,
    /// Whether somebody makes conditions for jobs that bring none.
    pub makes_conditions: bool,
    /// Most bytes of a file.
    pub most_bytes: u64,
    /// Most requests a second, over some time.
    pub most_requests: f64,
    /// Most jobs of this token that have no outcome yet.
    pub most_waiting: u64,
    /// Jobs of this token that have no outcome yet.
    pub waiting: u64,
    /// What this token's jobs may spend.
    pub budget: Budget,
}

/// What may be spent, and what was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Budget {
    /// Most requests that may cost; none where nobody limits them.
    pub most_calls: Option<u64>,
    /// How many were sent.
    pub calls: u64,
    /// Most that they may cost, in the currency of the service's prices.
    pub most_cost: Option<f64>,
    /// What they cost so far.
    pub cost: f64,
}

/// What is to be made. Files are named by their digests alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JobOrder {
    /// The photo; not needed where mesh and condition are given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub photo: Option<String>,
    /// A mesh, instead of a generator's: GLB, glTF with all in one file, OBJ, STL, PLY or USD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshOrder>,
    /// A condition, as in a condition file, instead of a vision-language model's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<Value>,
    /// Seed of everything random; the service's if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// How likely all of the asset must be right to be accepted, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_confidence: Option<f64>,
    /// What it is, such as `kettle`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub category: Option<String>,
    /// Licence of the photo, best as SPDX says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub license: Option<String>,
}

/// A mesh that was taken in.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshOrder {
    /// Its digest.
    pub digest: String,
    /// Whether it is an OBJ, the one format that does not say so itself.
    #[serde(default)]
    pub obj: bool,
}

/// A job that was taken in.
#[derive(Clone, Debug, PartialEq)]
pub struct Submitted {
    /// The job.
    pub job: Job,
    /// Whether it was not there before.
    pub is_new: bool,
}

/// Why a job is not taken in.
#[derive(Debug)]
pub enum Refused {
    /// Something in it cannot be used.
    Order(Failure),
    /// Its condition breaks a rule.
    Condition(ConditionError),
    /// Too many wait already.
    Full(Failure),
    /// The house cannot.
    House(Failure),
}

/// How far a job is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum JobState {
    /// Nobody works on it yet; `trouble` says what passing trouble it met, if it met one.
    Queued,
    /// Somebody works on it.
    Running,
    /// It is made, as it was asked for.
    Accepted,
    /// It is made, but below what was asked for; `reason` says why.
    Rejected,
    /// It cannot be made; `reason` says why.
    Failed,
}

impl JobState {
    /// Whether nothing more becomes of it.
    pub fn is_over(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }
}

/// A job and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Job {
    /// Its id: the same for the same question.
    pub id: String,
    /// How far it is.
    pub state: JobState,
    /// The stage that began last, of one that runs; or the one that failed.
    pub stage: Option<String>,
    /// How many stages are over, of one that runs.
    pub done: usize,
    /// How many stages there are.
    pub of: usize,
    /// The tier it reaches.
    pub tier: Option<String>,
    /// What a failure is a failure of: input, transient, budget, provider, model, geometry, verdict.
    pub class: Option<String>,
    /// Why it is not accepted.
    pub reason: Option<String>,
    /// The passing trouble that one that waits met last.
    pub trouble: Option<String>,
    /// How likely every part and joint is right, where the asset says.
    pub confidence: Option<f64>,
    /// Ids of the checks that count against it.
    pub failed_checks: Vec<String>,
    /// Requests that may have cost.
    pub calls: u64,
    /// What they cost, in the currency of the service's prices.
    pub cost: f64,
    /// The files it left: digests by path inside the asset.
    pub files: BTreeMap<String, String>,
}
