//! Who makes a mesh from a photo over a network or by a program, and the one driver of their jobs.
//!
//! [`Generated`] asks a [`Generator`]: submit, keep the job's number, look after it with growing
//! pauses until a hard deadline, fetch the file under guard, read it as any mesh.

pub mod answer;
pub mod comfy;
pub mod command;
pub mod driver;
pub mod gradio;
pub mod hosted;
pub mod hunyuan;
pub mod ledger;
pub mod meshy;
pub mod multipart;
pub mod stability;
mod tc3;
pub mod tencent;

#[cfg(test)]
mod bench;
#[cfg(test)]
mod damage_tests;
#[cfg(test)]
mod fake;
#[cfg(test)]
mod schema_tests;

pub use comfy::Comfy;
pub use command::Command;
pub use driver::{Generated, Patience};
pub use gradio::Gradio;
pub use hosted::Hosted;
pub use hunyuan::Hunyuan;
pub use ledger::{FolderLedger, Ledger, MemoryLedger};
pub use meshy::Meshy;
pub use stability::Stability;
pub use tencent::Tencent;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{AdapterError, Photo, Transport};

/// Speaks one service's protocol; the order of the steps is the driver's.
///
/// Promise: [`Generator::submit`] is the only step that may cost money, and asks for it last; no step
/// waits, and none sends the same request twice.
pub trait Generator: Send + Sync {
    /// Provider, model and every parameter that changes the mesh. Part of the stage key.
    fn identity(&self) -> String;

    /// Whether a submitted job costs money even if nobody fetches its result.
    fn charges(&self) -> Charges;

    /// A server of the user's own, whose files may be fetched from it though it is no public host.
    fn own_server(&self) -> Option<&str> {
        None
    }

    /// Asks for a mesh.
    ///
    /// # Errors
    /// [`AdapterError`]; nothing was started if it is a refusal.
    fn submit(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<Submitted, AdapterError>;

    /// Asks how a job is doing.
    ///
    /// # Errors
    /// [`AdapterError`] when that cannot be told; the job may go on all the same.
    fn poll(&self, transport: &dyn Transport, job: &JobHandle) -> Result<JobState, AdapterError>;
}

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Ask<'a> {
    /// The photo, without what cameras write into it besides the picture.
    pub photo: &'a Photo,
    /// Seed of the generation, where the service takes one.
    pub seed: u64,
}

/// Whether asking costs money.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Charges {
    /// A server of the user's own: asking twice costs time.
    Nothing,
    /// A service with a bill: asking twice costs twice.
    Money,
}

/// What came of asking.
#[derive(Clone, Debug, PartialEq)]
pub enum Submitted {
    /// A job that goes on by itself.
    Job(JobHandle),
    /// The mesh at once.
    File(Vec<u8>),
}

/// A job's number at its service: all that is needed to come back to it after a crash.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct JobHandle {
    /// The number.
    pub id: String,
    /// What later steps need besides.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub kept: BTreeMap<String, String>,
}

impl JobHandle {
    /// A job of which the number is all that is needed.
    pub fn new(id: impl Into<String>) -> Self {
        Self { id: id.into(), kept: BTreeMap::new() }
    }
}

/// How a job is doing.
#[derive(Clone, Debug, PartialEq)]
pub enum JobState {
    /// Waiting or at work.
    Running,
    /// A step further, under another number.
    Next(JobHandle),
    /// Done; the file came along.
    Inline(Vec<u8>),
    /// Done; the file lies at an address.
    At(FileAddress),
    /// Given up by the service, with its words; asking for a new job may help.
    Failed(String),
    /// Nothing is known of it, or no longer.
    Gone,
}

/// Where a file lies. Not shown: such addresses are often keys.
#[derive(Clone, PartialEq, Eq)]
pub struct FileAddress(pub String);

impl std::fmt::Debug for FileAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&crate::net::redact::url(&self.0))
    }
}

/// Whether a string can be a job's number and a piece of a path: it came from outside.
pub(crate) fn is_safe_id(id: &str) -> bool {
    let ok = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    (1..=128).contains(&id.len()) && id.chars().all(ok)
}
