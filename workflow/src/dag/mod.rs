//! The runner: a typed graph of stages, a store of what they made, and the order they run in.
//!
//! The store decides what is done, the schedule only decides what runs next. A stage's result is
//! found again under its key, the digest of everything it depends on; so a run that was killed
//! goes on where it stopped, and a changed input repeats only what depends on it. Nothing in here
//! knows what a photo or a mesh is.

pub mod address;
pub mod artefact;
mod attempt;
#[cfg(feature = "remote")]
pub mod bucket;
pub mod cancel;
pub mod depot;
pub mod errand;
pub mod gate;
pub mod graph;
pub mod journal;
pub mod key;
pub mod observe;
pub mod plan;
pub mod run;
pub mod schedule;
pub mod stage;
pub mod state_dir;
pub mod store;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod toy;

pub use address::Address;
pub use artefact::{Artefact, CodecError, Note, Text};
pub use cancel::{Cancel, Wish};
pub use depot::{Depot, DepotError, FolderDepot, Found};
pub use errand::{Answer, Done, Errand, ErrandError, Workers};
pub use gate::{AlwaysOpen, Entry, Gate, Place};
pub use graph::{Dag, Handle};
pub use observe::{Event, InGraphOrder, ObserveError, Observer, Quiet};
pub use plan::{PlannedStage, Reason, plan};
pub use run::{Ending, Outcome, RunError, RunOptions, run};
pub use schedule::{Limits, Resource};
pub use stage::{Again, Blame, Patience, Stage, StageError};
pub use state_dir::{StateDir, StateError};
