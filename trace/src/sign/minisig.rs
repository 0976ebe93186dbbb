//! A signature beside a file, as `minisign` writes and reads it.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use blake2::{Blake2b512, Digest as _};
use ed25519_dalek::{Signature, Signer as _};

use super::error::{LONGEST, SignError, other};
use super::id::{ID, KeyId};
use super::key::{ALGORITHM, COMMENT, PublicKey, SecretKey};

/// What is added to a file's name for its signature's.
pub const SUFFIX: &str = ".minisig";
/// Most bytes of a signature's file that are read: minisign's comments have up to 1 KiB and 8 KiB.
pub const MOST: u64 = 16 << 10;
/// Ed25519 over the BLAKE2b-512 of a file, as minisign's files name it.
const HASHED: [u8; 2] = *b"ED";
/// How the comment begins that the signature covers.
const TRUSTED: &str = "trusted comment: ";
/// What a signature is called in errors.
const A_SIGNATURE: &str = "a minisign signature";

/// Signs a file's bytes; gives the text of the signature's file. The comment is covered by it.
///
/// # Errors
/// [`SignError::Unfit`] for a comment that does not fit on a line.
pub fn sign(key: &SecretKey, bytes: &[u8], comment: &str) -> Result<String, SignError> {
    // A tab parts minisign's own words.
    if comment.len() > LONGEST || comment.chars().any(|c| c.is_control() && c != '\t') {
        return Err(SignError::Unfit);
    }
    let comment = comment.trim();
    let signature = key.key().sign(&hashed(bytes)).to_bytes();
    let all = key.key().sign(&[&signature[..], comment.as_bytes()].concat()).to_bytes();
    let id = key.id();
    let line = STANDARD.encode([&HASHED[..], &id.0, &signature].concat());
    let all = STANDARD.encode(all);
    Ok(format!("{COMMENT}signature with kinfold key {id}\n{line}\n{TRUSTED}{comment}\n{all}\n"))
}

/// Whether a signature is a key's over these bytes; gives its trusted comment.
///
/// # Errors
/// [`SignError`] that says what is wrong with it.
pub fn verify(key: &PublicKey, bytes: &[u8], text: &str) -> Result<String, SignError> {
    let parts = Parts::read(text)?;
    if parts.id != key.id() {
        return Err(SignError::OtherKey { signed: parts.id.to_string(), given: key.id() });
    }
    let judged = key.key().verify_strict(&hashed(bytes), &parts.signature);
    judged.map_err(|_| SignError::Forged)?;
    let covered = [&parts.signature.to_bytes()[..], parts.comment.as_bytes()].concat();
    let judged = key.key().verify_strict(&covered, &parts.over_all);
    judged.map_err(|_| SignError::Comment)?;
    Ok(parts.comment.to_owned())
}

/// The key that a signature names; whether it is that key's, [`verify`] says.
///
/// # Errors
/// [`SignError::Format`] when it is no signature.
pub fn signer(text: &str) -> Result<KeyId, SignError> {
    Parts::read(text).map(|parts| parts.id)
}

fn hashed(bytes: &[u8]) -> [u8; 64] {
    Blake2b512::digest(bytes).into()
}

/// What stands in a signature's file.
struct Parts<'a> {
    id: KeyId,
    signature: Signature,
    comment: &'a str,
    over_all: Signature,
}

impl<'a> Parts<'a> {
    fn read(text: &'a str) -> Result<Self, SignError> {
        let mut lines = text.lines();
        let mut next = || lines.next().ok_or_else(|| other(A_SIGNATURE, "fewer than four lines"));
        let (first, line, comment, over_all) = (next()?, next()?, next()?, next()?);
        let comment = comment.strip_prefix(TRUSTED).map(str::trim_end);
        let (Some(_), Some(comment)) = (first.strip_prefix(COMMENT.trim_end()), comment) else {
            return Err(other(A_SIGNATURE, "lines that do not begin as its comments do"));
        };
        if lines.any(|line| !line.trim().is_empty()) {
            return Err(other(A_SIGNATURE, "more than four lines"));
        }
        let bytes: [u8; 2 + ID + 64] = decoded(line)?;
        let (algorithm, rest) = bytes.split_at(2);
        if algorithm == ALGORITHM {
            return Err(other(A_SIGNATURE, "one in the old form, which `minisign -S -l` makes"));
        }
        if algorithm != HASHED {
            return Err(other(A_SIGNATURE, "one of another algorithm"));
        }
        let (id, signature) = rest.split_at(ID);
        let (Ok(id), Ok(signature)) = (id.try_into(), Signature::from_slice(signature)) else {
            return Err(other(A_SIGNATURE, "a damaged one"));
        };
        let over_all = Signature::from_bytes(&decoded(over_all)?);
        Ok(Self { id: KeyId(id), signature, comment, over_all })
    }
}

fn decoded<const N: usize>(line: &str) -> Result<[u8; N], SignError> {
    let bytes = STANDARD.decode(line.trim()).map_err(|_| other(A_SIGNATURE, "no base64"))?;
    let length = bytes.len();
    let found = || other(A_SIGNATURE, format!("{length} bytes in a line instead of {N}"));
    bytes.try_into().map_err(|_| found())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key() -> SecretKey {
        SecretKey::draw().unwrap()
    }

    #[test]
    fn a_signature_holds_for_its_bytes_its_key_and_its_comment() {
        let (key, stranger) = (key(), key());
        let text = sign(&key, b"a trace", "file:trace.mcap\thashed").unwrap();
        assert_eq!(text, sign(&key, b"a trace", "file:trace.mcap\thashed").unwrap(), "same bytes");
        let judged = |key: &SecretKey, bytes: &[u8], text: &str| verify(&key.public(), bytes, text);
        assert_eq!(judged(&key, b"a trace", &text).unwrap(), "file:trace.mcap\thashed");
        assert_eq!(
            judged(&key, b"a trace", &text.replace('\n', "\r\n")).unwrap(),
            "file:trace.mcap\thashed"
        );
        assert_eq!(judged(&key, b"a tracf", &text), Err(SignError::Forged));
        let wrong = judged(&stranger, b"a trace", &text).unwrap_err();
        assert!(matches!(wrong, SignError::OtherKey { .. }), "{wrong}");
        let other = text.replace("trace.mcap", "other.mcap");
        assert_eq!(judged(&key, b"a trace", &other), Err(SignError::Comment));
    }

    #[test]
    fn a_key_that_takes_anothers_number_is_found_out() {
        let (key, stranger) = (key(), key());
        let text = sign(&stranger, b"a trace", "x").unwrap();
        let line = text.lines().nth(1).unwrap();
        let mut bytes = STANDARD.decode(line).unwrap();
        bytes[2..2 + ID].copy_from_slice(&key.id().0);
        let forged = text.replace(line, &STANDARD.encode(bytes));
        assert_eq!(verify(&key.public(), b"a trace", &forged), Err(SignError::Forged));
    }

    #[test]
    fn what_is_cut_off_or_in_disorder_is_told() {
        let key = key();
        let text = sign(&key, b"a trace", "x").unwrap();
        let judged = |text: &str| verify(&key.public(), b"a trace", text);
        for end in 0..text.len() - 1 {
            assert!(judged(&text[..end]).is_err(), "cut off at {end}");
        }
        let lines: Vec<_> = text.lines().collect();
        let swapped = [lines[0], lines[3], lines[2], lines[1]].join("\n");
        assert!(judged(&swapped).unwrap_err().to_string().contains("64 bytes in a line"));
        assert!(judged(&format!("{text}x\n")).unwrap_err().to_string().contains("more than four"));
        let mut old = STANDARD.decode(lines[1]).unwrap();
        old[..2].copy_from_slice(b"Ed");
        let old = judged(&text.replace(lines[1], &STANDARD.encode(&old))).unwrap_err();
        assert!(old.to_string().contains("minisign -S -l"), "{old}");
        assert_eq!(sign(&key, b"", "a\nb"), Err(SignError::Unfit));
        assert_eq!(sign(&key, b"", &"a".repeat(LONGEST + 1)), Err(SignError::Unfit));
    }
}
