//! GLB file ↔ mesh: generators' files as they really are, judged before any geometry is touched.
//!
//! [`read`] bakes every node's transform, joins all primitives in the order of the file, unpacks
//! Draco, meshopt and quantised data, and turns glTF's y-up frame into the object frame. Faces come
//! out in index order, degenerate ones included, so labels per triangle keep their meaning. All
//! counts, ranges and nestings are checked first; no bytes, however hostile, make it panic.

mod accessor;
mod buffers;
mod container;
mod document;
mod paint;
mod primitive;
mod scene;
#[cfg(test)]
mod tests;
mod write;

pub use container::{MAX_JSON, MAX_JSON_DEPTH};
pub use document::{MAX_MESHES, MAX_NODE_DEPTH, MAX_NODES};
pub use paint::{MAX_IMAGE_SIDE, MAX_PIXELS, linear_of_srgb};
pub use write::{BinaryChunk, write};

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

use crate::mesh::{Mesh, MeshError};

/// Most bytes compressed geometry may unpack to (512 MiB).
pub const MAX_DECODED_BYTES: usize = 512 << 20;
/// What a file may unpack to whatever its size, bytes, and how much more per byte of it: Draco comes
/// to some 30, a flat grid to some 1000, what is left out (accessors without a view) has no bound.
const UNPACKED_ANYWAY: usize = 16 << 20;
const UNPACKED_PER_BYTE: usize = 2000;
/// How long one compressed primitive may take, seconds: at any size, and more for each MiB of it. A
/// sound one takes well below a second per MiB; a guess with room for a busy machine.
const DECODING: [f64; 2] = [20.0, 10.0];
const MIB: f64 = 1_048_576.0;
/// Stack of a decoder, bytes: what the main thread has on Linux.
const STACK: usize = 8 << 20;

/// Most bytes that a file of so many may unpack to.
fn most_unpacked(file: usize) -> usize {
    MAX_DECODED_BYTES.min(UNPACKED_ANYWAY.saturating_add(file.saturating_mul(UNPACKED_PER_BYTE)))
}

/// Why bytes are not a GLB file we can take a surface from.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GlbError {
    /// Header or chunks break a rule.
    #[error("GLB: {rule}, found {found}")]
    Container {
        /// The rule.
        rule: &'static str,
        /// What the file has.
        found: String,
    },
    /// The JSON chunk does not parse as glTF.
    #[error("GLB: the JSON chunk must be glTF: {0}")]
    Json(String),
    /// Something in the file breaks a rule.
    #[error("GLB: {place}: {rule}, found {found}")]
    Rule {
        /// Where in the file.
        place: String,
        /// The rule.
        rule: &'static str,
        /// What the file has.
        found: String,
    },
    /// An index that names nothing.
    #[error("GLB: {place} uses {what} {index}, but the file has {count}")]
    Reference {
        /// Who refers.
        place: String,
        /// To what.
        what: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// The file cannot be read without an extension we do not follow.
    #[error("GLB: the file needs the extension `{0}`, which kinfold does not read")]
    Extension(String),
    /// A URI that leaves the file.
    #[error("GLB: all data must be inside the file, found the URI `{0}`")]
    External(String),
    /// A compressed stream that does not unpack.
    #[error("GLB: {place}: the {codec} data does not decode: {reason}")]
    Codec {
        /// Where in the file.
        place: String,
        /// Which codec.
        codec: &'static str,
        /// What the codec says.
        reason: String,
    },
    /// The surface is not a mesh: empty, too large, without extent.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl GlbError {
    fn rule(place: impl Into<String>, rule: &'static str, found: impl Into<String>) -> Self {
        Self::Rule { place: place.into(), rule, found: found.into() }
    }

    fn reference(place: impl Into<String>, what: &'static str, index: usize, count: usize) -> Self {
        Self::Reference { place: place.into(), what, index, count }
    }
}

/// A mesh and what of its file did not make it in.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The surface, object frame.
    pub mesh: Mesh,
    /// What was left out (animations, skins, points and lines, unreadable textures), in plain words.
    pub notes: Vec<String>,
}

/// Reads a GLB file into the object frame.
///
/// # Errors
/// [`GlbError`], the first broken rule.
pub fn read(bytes: &[u8]) -> Result<Mesh, GlbError> {
    Ok(read_noted(bytes)?.mesh)
}

/// Like [`read`], and says what of the file was left out.
///
/// # Errors
/// [`GlbError`], the first broken rule.
pub fn read_noted(bytes: &[u8]) -> Result<Reading, GlbError> {
    let container = container::Container::parse(bytes)?;
    let document = document::Document::parse(container.json)?;
    let buffers = buffers::Buffers::load(&document, container.bin, bytes.len())?;
    scene::read(accessor::Accessors { document: &document, buffers: &buffers })
}

/// Runs a decoder we did not write. The Draco decoder is young: should a hostile stream make it
/// panic, the file is refused like any other broken one, and the caller's process lives on.
fn guarded<T, E: Display>(
    place: &str,
    codec: &'static str,
    decode: impl FnOnce() -> Result<T, E>,
) -> Result<T, GlbError> {
    let failed = |reason| GlbError::Codec { place: place.into(), codec, reason };
    match catch_unwind(AssertUnwindSafe(decode)) {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(error)) => Err(failed(error.to_string())),
        Err(_) => Err(failed("the decoder gave up".into())),
    }
}

/// The same with a deadline that grows with the bytes to decode. What is too slow is given up and
/// refused; its thread ends with it or with the program, whichever is first, for nothing can stop
/// it: a checker's process is ended, and a run that cannot read its mesh ends by itself.
fn timed<T: Send + 'static, E: Display>(
    place: &str,
    codec: &'static str,
    bytes: usize,
    decode: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> Result<T, GlbError> {
    let deadline = Duration::from_secs_f64(DECODING[0] + DECODING[1] * bytes as f64 / MIB);
    within(place, codec, deadline, decode)
}

fn within<T: Send + 'static, E: Display>(
    place: &str,
    codec: &'static str,
    deadline: Duration,
    decode: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> Result<T, GlbError> {
    let (sender, receiver) = std::sync::mpsc::sync_channel(1);
    let here = place.to_owned();
    let work = move || {
        // Nobody may be waiting any more.
        let _ = sender.send(guarded(&here, codec, decode));
    };
    let failed = |reason: String| GlbError::Codec { place: place.into(), codec, reason };
    let thread = std::thread::Builder::new().name(codec.into()).stack_size(STACK);
    let started = thread.spawn(work);
    started.map_err(|e| failed(format!("no thread could be started: {e}")))?;
    receiver.recv_timeout(deadline).unwrap_or_else(|_| {
        Err(failed(format!("it takes longer than the {} s it may", deadline.as_secs_f64())))
    })
}
