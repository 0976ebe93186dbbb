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
mod error;
mod id;
mod key;
mod minisig;

pub use error::SignError;
pub use id::KeyId;
pub use key::{PublicKey, SecretKey};
pub use minisig::{MOST, SUFFIX, sign, signer, verify};
