//! The checks of the profile, group by group. A check has a letter and a number, such as C1; the
//! [profile](crate::profile) lists them all.
//!
//! `lint` looks at the robot at rest, `sweep` and `kinematic` move it without an engine, `dynamics`
//! in one, `sidecar` reads what the asset says of itself. Each answers with checks and never errs:
//! what could not be decided is unknown.

mod description;
pub mod dynamics;
pub mod kind;
pub mod kinematic;
pub mod lint;
mod right;
pub(crate) mod sidecar;
pub(crate) mod study;
pub mod sweep;
