//! Reads a URDF, MJCF, SDFormat or USD model from disk as a simulator would, whoever wrote it, and says what
//! holds and what does not: the verdict. The checks are those of the profile simready-urdf 1.0.
//!
//! [`check()`] is the door: it never panics and never errs. What could not be decided is `unknown`,
//! and unknown is a failure.

pub mod advice;
mod check;
pub mod checks;
pub mod geometry;
pub mod mass;
pub mod options;
pub mod profile;
pub mod read;
pub mod report;
pub mod robot;
pub mod verdict;

pub use check::{check, check_edition, undecided};
pub use options::{Asked, CheckOptions, Expected, Provenance};
pub use profile::subject::{Base, Judged, Subject};
pub use profile::{Severity, Tier};
pub use read::meshes::Outside;
pub use read::places::Places;
pub use robot::Robot;
pub use verdict::{Check, Status, Verdict};
