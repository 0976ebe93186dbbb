//! A local server with which a person sees, steers and corrects one object: parts, points, axes and
//! ranges, and then builds it.
//!
//! It serves one page and an API under `/api/…` ([`openapi()`] describes it), on the loopback interface
//! alone. Every question needs the token that stands in the page's address, and none from another
//! origin is answered. What a person does is written at once into an ordinary condition file
//! ([`object::ConditionFile`]); `make` with that file gives what the page showed. Labels and joints are
//! asked of [`model`] here; whatever else there is to do, building above all, does a [`House`].
//!
//!
//! The same crate serves many objects to programs, without a page: [`service`].
//!
//! ```
//! let document = studio::openapi();
//! assert_eq!(document["openapi"], "3.1.0");
//! assert!(document["paths"]["/api/labels"]["post"].is_object());
//! ```

mod desk;
mod house;
mod http;
mod openapi;
mod paper;
pub mod question;
mod screen;
pub mod service;
mod works;

pub use desk::{Articulated, Desk, DeskError};
pub use house::{Artefact, Built, Failure, House, Order, Outcome, Remedy, StageState, Tell};
pub use http::{Setup, Stop, Token, serve};
pub use openapi::openapi;
pub use paper::{Paper, PaperError};
pub use screen::MOST_FACES;
pub use works::{
    About, Budget, Incoming, Job, JobOrder, JobState, Kept, MeshOrder, Refused, Submitted, Works,
};

/// A picture of the object.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Its bytes, as they lie on disk.
    pub bytes: Vec<u8>,
    /// Its media type, such as `image/png`.
    pub media_type: String,
}
