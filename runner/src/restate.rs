//! Stages as services of Restate: how they are called, and the worker that serves them.
//!
//! ```
//! assert_eq!(runner::restate::service("articulate"), "kinfold.articulate");
//! ```

#[cfg(feature = "restate")]
#[allow(missing_docs, reason = "the SDK's macro writes a client without any")]
pub mod worker;

/// The handler of every stage's service.
pub const HANDLER: &str = "make";

/// The name of the service that does a stage.
pub fn service(stage: &str) -> String {
    format!("kinfold.{stage}")
}
