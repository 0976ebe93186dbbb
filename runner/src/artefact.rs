//! What stages hand to each other: a value that is also a file.
//!
//! ```
//! use runner::{Artefact, Text};
//!
//! let text = Text("a lid".into());
//! let bytes = Artefact::<()>::encode(&text)?;
//! assert_eq!(<Text as Artefact<()>>::decode(&bytes)?, text);
//! assert!(<Text as Artefact<()>>::decode(&[0xff]).is_err());
//! # Ok::<(), runner::CodecError>(())
//! ```

use serde::{Deserialize, Serialize};

/// A value that survives as bytes.
///
/// Promise: `decode(encode(x))` behaves exactly like `x` for every stage downstream, and equal
/// values give equal bytes. The runner always hands on the decoded bytes, so a run that found a
/// result in the store and a run that just made it go on from the same thing.
///
/// `T` is what the stages of a flow reach the outside through: whoever writes the flow may so say how
/// values of other crates become files in it.
pub trait Artefact<T>: Send + Sync + Sized + 'static {
    /// Name of the artefact in plans and reasons, such as `condition`.
    const NAME: &'static str;
    /// Media type of its bytes.
    const MEDIA_TYPE: &'static str;
    /// File name in a trace.
    const FILE_NAME: &'static str;

    /// The value as bytes.
    ///
    /// # Errors
    /// [`CodecError`] when the value has no such form.
    fn encode(&self) -> Result<Vec<u8>, CodecError>;

    /// The value behind some bytes.
    ///
    /// # Errors
    /// [`CodecError`] when they are not what [`Artefact::encode`] writes.
    fn decode(bytes: &[u8]) -> Result<Self, CodecError>;

    /// Losses and doubts a person should know of.
    fn notes(&self) -> Vec<Note> {
        Vec::new()
    }
}

/// Something a person should know about a result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// One sentence.
    pub message: String,
    /// Whether something asked for is missing.
    pub loss: bool,
}

/// Why a value and its bytes do not match.
#[derive(Debug, thiserror::Error)]
#[error("{what}: {found}")]
pub struct CodecError {
    /// The artefact.
    pub what: &'static str,
    /// What went wrong.
    pub found: String,
}

impl CodecError {
    /// An error of artefact `A`.
    pub fn of<T, A: Artefact<T>>(found: impl std::fmt::Display) -> Self {
        Self { what: A::NAME, found: found.to_string() }
    }
}

/// JSON bytes of a value, for [`Artefact::encode`].
///
/// # Errors
/// [`CodecError`] for values JSON cannot hold.
pub fn to_json<T, A: Artefact<T>>(value: &impl Serialize) -> Result<Vec<u8>, CodecError> {
    serde_json::to_vec(value).map_err(CodecError::of::<T, A>)
}

/// The value in JSON bytes, for [`Artefact::decode`].
///
/// # Errors
/// [`CodecError`] for anything else.
pub fn from_json<T, A: Artefact<T>, V: for<'a> Deserialize<'a>>(
    bytes: &[u8],
) -> Result<V, CodecError> {
    serde_json::from_slice(bytes).map_err(CodecError::of::<T, A>)
}

/// Plain text, the simplest artefact.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text(pub String);

impl<T> Artefact<T> for Text {
    const NAME: &'static str = "text";
    const MEDIA_TYPE: &'static str = "text/plain";
    const FILE_NAME: &'static str = "text.txt";

    fn encode(&self) -> Result<Vec<u8>, CodecError> {
        Ok(self.0.clone().into_bytes())
    }

    fn decode(bytes: &[u8]) -> Result<Self, CodecError> {
        String::from_utf8(bytes.to_vec()).map(Self).map_err(CodecError::of::<T, Self>)
    }
}
