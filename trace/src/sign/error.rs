//! Why a key or a signature is not taken.

use guard::text::brief;

use super::id::KeyId;

/// Most characters of what was found that a message has.
const TOLD: usize = 200;

/// Longest trusted comment, bytes, as in minisign.
pub(super) const LONGEST: usize = 8192;

/// Why a key or a signature is not taken. It names no file: whoever asked knows which; and it never
/// quotes a key.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SignError {
    /// Something else, or something damaged.
    #[error("expected {expected}, found {found}")]
    Format {
        /// What should stand there.
        expected: &'static str,
        /// What does.
        found: String,
    },
    /// A secret key that needs a password.
    #[error("the secret key is protected by a password; expected one without")]
    Protected,
    /// Signed with another key than the one given.
    #[error("signed with key {signed}, not with {given}")]
    OtherKey {
        /// The key that the signature names.
        signed: String,
        /// The key that was given.
        given: KeyId,
    },
    /// The signature is not this key's over these bytes.
    #[error("the signature is not of these bytes")]
    Forged,
    /// The trusted comment is not the one that was signed.
    #[error("the trusted comment was changed")]
    Comment,
    /// A comment that does not fit on a line.
    #[error("expected a comment without control characters, up to {} bytes", LONGEST)]
    Unfit,
    /// The operating system gave no random bytes.
    #[error("no random bytes for a key: {0}")]
    Random(String),
}

/// What was found may be a stranger's text of any length: its beginning is told.
pub(super) fn other(expected: &'static str, found: impl Into<String>) -> SignError {
    SignError::Format { expected, found: brief(&found.into(), TOLD).into_owned() }
}
