//! What is recorded: the run's manifest and what happened to each stage.
//!
//! ```
//! use trace::{ArtefactRef, Digest, Happening, StageEvent};
//!
//! let lid = ArtefactRef { name: "lid.glb".into(), digest: Digest::of(b"a lid"), bytes: 5 };
//! let event: StageEvent = serde_json::from_value(serde_json::json!({
//!     "stage": "render-views", "event": "finished", "key": "k", "inputs": [lid],
//! }))?;
//! assert_eq!((event.event, event.inputs[0].bytes), (Happening::Finished, 5));
//! assert!(event.outputs.is_empty() && event.previous.is_none());
//! # Ok::<(), serde_json::Error>(())
//! ```

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::digest::Digest;

/// What a run was asked to do; the first thing in its trace.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Manifest {
    /// Digest over everything below: the same question has the same name.
    pub run_id: String,
    /// Name of the flow, such as `image-to-urdf`.
    pub flow: String,
    /// Version of the program.
    pub version: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Digest of each input, by name.
    pub inputs: BTreeMap<String, Digest>,
    /// Parameters and adapters, by name.
    pub parameters: BTreeMap<String, serde_json::Value>,
}

/// What happened to a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Happening {
    /// Its inputs are ready and its work begins.
    Started,
    /// It is done; its outputs are stored.
    Finished,
    /// It gave up.
    Failed,
}

/// An artefact by name and digest.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ArtefactRef {
    /// File name, such as `condition.json`.
    pub name: String,
    /// Digest of its bytes.
    pub digest: Digest,
    /// Length in bytes.
    pub bytes: u64,
}

/// One line of the flight log, on the topic `/stage`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StageEvent {
    /// Name of the stage.
    pub stage: String,
    /// What happened.
    pub event: Happening,
    /// Digest of (stage, code version, parameters, seed, input digests): the key of its result.
    pub key: String,
    /// Who did the work: adapter, solver or model, with version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identity: Option<String>,
    /// What it was given.
    pub inputs: Vec<ArtefactRef>,
    /// What it made; empty until it finished.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outputs: Vec<ArtefactRef>,
    /// Digests of the calls to the world outside that were made for it, as they stand on `/calls`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub calls: Vec<Digest>,
    /// Why it failed, or what it lost; one sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Digest of the event before this one in the file, of the manifest for the first: the record is
    /// a chain. Set by the recorder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub previous: Option<Digest>,
}
