//! The flight recorder: one MCAP file per run, readable by the usual viewers.
//!
//! A trace opens with its manifest, so that even a torn file says what it was. Every stage ends
//! with a flush and a sync, so a crash loses at most the stage it happened in. Given the same
//! times, the same calls give the same bytes. A seal at its end covers every bit before it. This is
//! the only room that knows MCAP.

pub mod clock;
pub mod digest;
pub mod event;
pub mod moment;
pub mod reader;
pub mod seal;
pub mod sign;
pub mod verify;
pub mod writer;

pub use clock::{Clock, FixedClock, SystemClock, Time};
pub use digest::Digest;
pub use event::{ArtefactRef, Happening, Manifest, StageEvent};
pub use reader::{Picture, Reading, read, read_bytes};
pub use writer::{Recorder, SceneLink, Severity, Transform};

/// Why a trace could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// The disk, with the file's name.
    #[error("{path}: {source}")]
    Io {
        /// The trace file.
        path: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// It is no file that is read.
    #[error("{path}: {why}")]
    Refused {
        /// The trace file.
        path: String,
        /// The rule it breaks.
        why: guard::files::Refused,
    },
    /// The MCAP library.
    #[error("{path}: {source}")]
    Mcap {
        /// The trace file.
        path: String,
        /// What the library said.
        source: mcap::McapError,
    },
    /// A message that could not be encoded.
    #[error("topic {topic}: cannot encode {what}: {found}")]
    Encode {
        /// Where it was to go.
        topic: String,
        /// Its type.
        what: &'static str,
        /// What went wrong.
        found: String,
    },
    /// Not a trace of ours.
    #[error("{path}: not a kinfold trace: expected {expected}, found {found}")]
    Foreign {
        /// The file.
        path: String,
        /// What a trace has there.
        expected: &'static str,
        /// What was there.
        found: String,
    },
}
