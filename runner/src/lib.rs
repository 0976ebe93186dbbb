//! The runner: a typed graph of stages, a store of what they made, and the order they run in.
//!
//! The store decides what is done, the schedule only decides what runs next. A stage's result is
//! stored under its key, the digest of everything it depends on. So a run that was killed goes on
//! where it stopped, and a changed input repeats only what depends on it. Nothing in here knows
//! what a photo or a mesh is.
//!
//! A flow is written with [`graph`], [`stage`] and [`artefact`]. [`mod@run`] runs it, [`mod@plan`] says what
//! would run. [`state_dir`] keeps results on this machine, [`depot`] shares them with others, and
//! [`errand`] has stages done there. [`ours`] knows which folders are ours and who writes in them.

pub mod address;
pub mod artefact;
mod attempt;
#[cfg(feature = "remote")]
pub mod bucket;
pub mod cancel;
pub mod depot;
pub mod errand;
pub mod failure;
pub mod gate;
pub mod graph;
pub mod inputs;
pub mod journal;
pub mod key;
pub mod needs;
pub mod observe;
mod opening;
pub mod ours;
pub mod outcome;
pub mod plan;
pub mod restate;
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
pub use depot::{Depot, DepotError, FolderDepot};
pub use errand::{Answer, Done, Errand, ErrandError, Workers};
pub use failure::{Again, Blame, StageError};
pub use gate::{AlwaysOpen, Entry, Gate, Place};
pub use graph::Dag;
pub use inputs::Handle;
pub use needs::{Patience, Resource};
pub use observe::{Event, InGraphOrder, ObserveError, Observer, Quiet};
pub use outcome::{Ending, NodeOutcome, Outcome};
pub use plan::{PlannedStage, Reason, plan};
pub use run::{RunError, RunOptions, run};
pub use schedule::Limits;
pub use stage::Stage;
pub use state_dir::{StateDir, StateError};
pub use store::Found;
