//! Signatures: who made a trace or a statement, which a seal cannot say.
//!
//! Keys and signatures are Ed25519 in the files of minisign, so that `minisign -V` judges what is
//! signed here, and what `minisign -S` signs is judged here. Statements are signed in DSSE
//! envelopes, which tools of in-toto read. The same key, file and comment give the same bytes.
//!
//! ```
//! use trace::sign::{self, SecretKey};
//!
//! let key = SecretKey::draw()?;
//! let text = sign::sign(&key, b"a trace", "file:trace.mcap")?;
//! assert_eq!(sign::signer(&text)?, key.id());
//! assert_eq!(sign::verify(&key.public(), b"a trace", &text)?, "file:trace.mcap");
//! assert!(sign::verify(&key.public(), b"another", &text).is_err());
//! # Ok::<(), sign::SignError>(())
//! ```

pub mod dsse;
mod key;
mod minisig;

pub use key::{KeyId, PublicKey, SecretKey};
pub use minisig::{MOST, SUFFIX, sign, signer, verify};

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
    #[error("expected a comment without control characters, up to {} bytes", minisig::LONGEST)]
    Unfit,
    /// The operating system gave no random bytes.
    #[error("no random bytes for a key: {0}")]
    Random(String),
}

fn other(expected: &'static str, found: impl Into<String>) -> SignError {
    SignError::Format { expected, found: found.into() }
}
