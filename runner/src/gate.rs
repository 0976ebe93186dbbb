//! The gate before every attempt: where runs that share a machine and a purse wait for each other.
//!
//! ```
//! use runner::{AlwaysOpen, Entry, Gate, Resource};
//!
//! assert!(matches!(AlwaysOpen.enter("articulate", Resource::Cpu), Entry::Open(_)));
//! ```

use std::any::Any;

use super::failure::StageError;
use super::needs::Resource;

/// A place to work in; given back when it is dropped.
pub type Place = Box<dyn Any + Send>;

/// Asked before every attempt of a stage, on the attempt's own thread, so that it may wait.
///
/// Promise: it answers at the latest when the runs are to stop, then with [`Entry::Closed`].
pub trait Gate: Send + Sync {
    /// Waits for a place.
    fn enter(&self, stage: &'static str, resource: Resource) -> Entry;
}

/// What the gate answers.
pub enum Entry {
    /// Come in.
    Open(Place),
    /// Nothing new begins any more.
    Closed,
    /// This stage does not begin, and its run fails with this.
    Refused(StageError),
}

/// Lets everybody in: for a run that has the machine to itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct AlwaysOpen;

impl Gate for AlwaysOpen {
    fn enter(&self, _stage: &'static str, _resource: Resource) -> Entry {
        Entry::Open(Box::new(()))
    }
}
