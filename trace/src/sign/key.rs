//! Keys, in the files of minisign: a comment line, and a line of base64.

use std::fmt;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use blake2::digest::consts::U32;
use blake2::{Blake2b, Digest as _};
use ed25519_dalek::{SigningKey, VerifyingKey};
use zeroize::Zeroizing;

use super::error::{SignError, other};
use super::id::{ID, KeyId};

/// Ed25519, as minisign's files name it.
pub(super) const ALGORITHM: [u8; 2] = *b"Ed";
/// How comments begin.
pub(super) const COMMENT: &str = "untrusted comment: ";
/// A secret key that lies open.
const OPEN: [u8; 2] = [0, 0];
/// A secret key under a password, by scrypt.
const UNDER_PASSWORD: [u8; 2] = *b"Sc";
/// The checksum of a secret key: BLAKE2b of 32 bytes.
const CHECKSUM: [u8; 2] = *b"B2";
/// Algorithm, derivation, checksum; salt and two limits of the derivation, bytes.
const HEAD: usize = 2 + 2 + 2 + 32 + 8 + 8;
/// Length of a secret key, bytes: head, number, seed and point, checksum.
const SECRET: usize = HEAD + ID + 64 + 32;
/// Length of a public key, bytes: algorithm, number, point.
const PUBLIC: usize = 2 + ID + 32;
/// What a secret key is called in errors.
const A_SECRET: &str = "a minisign secret key";
/// What a public key is called in errors.
const A_PUBLIC: &str = "a minisign public key";

/// A key that signs. It is wiped from memory when it goes, and never shown.
pub struct SecretKey {
    id: KeyId,
    key: SigningKey,
}

impl fmt::Debug for SecretKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SecretKey({})", self.id)
    }
}

impl SecretKey {
    /// Draws a new one.
    ///
    /// # Errors
    /// [`SignError::Random`] when the operating system has no random bytes.
    pub fn draw() -> Result<Self, SignError> {
        let (mut seed, mut id) = (Zeroizing::new([0; 32]), [0; ID]);
        let drawn = getrandom::fill(&mut *seed).and_then(|()| getrandom::fill(&mut id));
        drawn.map_err(|e| SignError::Random(e.to_string()))?;
        Ok(Self { id: KeyId(id), key: SigningKey::from_bytes(&seed) })
    }

    /// Reads a secret key's file.
    ///
    /// # Errors
    /// [`SignError`] when it is something else, damaged, or under a password.
    pub fn read(text: &str) -> Result<Self, SignError> {
        let bytes = Zeroizing::new(decoded(text, A_SECRET)?);
        if bytes.len() == PUBLIC {
            return Err(other(A_SECRET, "a public key"));
        }
        let bytes: &[u8; SECRET] = bytes
            .as_slice()
            .try_into()
            .map_err(|_| other(A_SECRET, format!("{} bytes instead of {SECRET}", bytes.len())))?;
        let (head, rest) = bytes.split_at(HEAD);
        let (body, checksum) = rest.split_at(ID + 64);
        let (algorithm, kinds) = head.split_at(2);
        if algorithm != ALGORITHM {
            return Err(other(A_SECRET, "a key of another algorithm"));
        }
        match kinds.split_at(2) {
            (kind, _) if kind == UNDER_PASSWORD => return Err(SignError::Protected),
            (kind, rest) if kind == OPEN && rest.starts_with(&CHECKSUM) => {}
            _ => return Err(other(A_SECRET, "a key of an unknown kind")),
        }
        // minisign leaves the checksum of an open key empty (seen of 0.11); its halves are looked at
        // below in any case.
        if checksum != sum(body).as_slice() && checksum != [0; 32] {
            return Err(other(A_SECRET, "a damaged one: its checksum is another"));
        }
        let (id, pair) = body.split_at(ID);
        let pair: &[u8; 64] = pair.try_into().map_err(|_| other(A_SECRET, "a damaged one"))?;
        let key = SigningKey::from_keypair_bytes(pair);
        let key =
            key.map_err(|_| other(A_SECRET, "one whose two halves do not belong together"))?;
        let id = id.try_into().map_err(|_| other(A_SECRET, "a damaged one"))?;
        Ok(Self { id: KeyId(id), key })
    }

    /// The text of its file, which `minisign` reads, too.
    pub fn to_text(&self) -> Zeroizing<String> {
        let mut body = Zeroizing::new(Vec::with_capacity(ID + 64));
        body.extend_from_slice(&self.id.0);
        body.extend_from_slice(&*Zeroizing::new(self.key.to_keypair_bytes()));
        let mut bytes = Zeroizing::new(Vec::with_capacity(SECRET));
        [ALGORITHM, OPEN, CHECKSUM].iter().for_each(|word| bytes.extend_from_slice(word));
        // No derivation: neither salt nor limits.
        bytes.resize(HEAD, 0);
        bytes.extend_from_slice(&body);
        bytes.extend_from_slice(&sum(&body));
        let line = Zeroizing::new(STANDARD.encode(&*bytes));
        Zeroizing::new(format!("{COMMENT}kinfold secret key {}\n{}\n", self.id, *line))
    }

    /// Its number.
    pub fn id(&self) -> KeyId {
        self.id
    }

    /// The key that judges what this one signs.
    pub fn public(&self) -> PublicKey {
        PublicKey { id: self.id, key: self.key.verifying_key() }
    }

    pub(super) fn key(&self) -> &SigningKey {
        &self.key
    }
}

/// A key that judges signatures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PublicKey {
    id: KeyId,
    key: VerifyingKey,
}

impl PublicKey {
    /// Reads a public key's file, or its one line of base64.
    ///
    /// # Errors
    /// [`SignError::Format`] when it is something else.
    pub fn read(text: &str) -> Result<Self, SignError> {
        let bytes = Zeroizing::new(decoded(text, A_PUBLIC)?);
        if bytes.len() == SECRET {
            return Err(other(A_PUBLIC, "a secret key"));
        }
        let bytes: &[u8; PUBLIC] = bytes
            .as_slice()
            .try_into()
            .map_err(|_| other(A_PUBLIC, format!("{} bytes instead of {PUBLIC}", bytes.len())))?;
        let (algorithm, rest) = bytes.split_at(2);
        if algorithm != ALGORITHM {
            return Err(other(A_PUBLIC, "a key of another algorithm"));
        }
        let (id, point) = rest.split_at(ID);
        let (id, point) = (id.try_into(), point.try_into());
        let (Ok(id), Ok(point)) = (id, point) else { return Err(other(A_PUBLIC, "a damaged one")) };
        match VerifyingKey::from_bytes(&point) {
            Ok(key) if !key.is_weak() => Ok(Self { id: KeyId(id), key }),
            _ => Err(other(A_PUBLIC, "a point that is no key")),
        }
    }

    /// The text of its file, which `minisign` reads, too.
    pub fn to_text(&self) -> String {
        let bytes = [&ALGORITHM[..], &self.id.0, self.key.as_bytes()].concat();
        format!("{COMMENT}kinfold public key {}\n{}\n", self.id, STANDARD.encode(bytes))
    }

    /// Its number.
    pub fn id(&self) -> KeyId {
        self.id
    }

    pub(super) fn key(&self) -> &VerifyingKey {
        &self.key
    }
}

/// The checksum of a secret key's number and halves.
fn sum(body: &[u8]) -> [u8; 32] {
    Blake2b::<U32>::new().chain_update(ALGORITHM).chain_update(body).finalize().into()
}

/// The bytes of a key's file: what its last line says.
fn decoded(text: &str, expected: &'static str) -> Result<Vec<u8>, SignError> {
    let mut lines = text.lines();
    let first = lines.next().unwrap_or_default();
    let line = match (first.strip_prefix(COMMENT.trim_end()), lines.next()) {
        (Some(_), Some(second)) => second,
        (Some(_), None) => return Err(other(expected, "a comment and nothing below it")),
        (None, None) => first,
        (None, Some(_)) => return Err(other(expected, kind(first))),
    };
    if lines.any(|line| !line.trim().is_empty()) {
        return Err(other(expected, "more than a comment and a key"));
    }
    STANDARD.decode(line.trim()).map_err(|_| other(expected, kind(line)))
}

/// What a file that is no key of minisign seems to be.
fn kind(line: &str) -> &'static str {
    if line.contains("OPENSSH PRIVATE KEY") || line.starts_with("ssh-") {
        "a key of OpenSSH"
    } else if line.contains("-----BEGIN") {
        "a key in PEM"
    } else {
        "no base64"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_comes_back_from_its_file_and_never_shows_itself() {
        let secret = SecretKey::draw().unwrap();
        let text = secret.to_text();
        let again = SecretKey::read(&text).unwrap();
        assert_eq!((again.id(), again.key().to_bytes()), (secret.id(), secret.key().to_bytes()));
        let public = PublicKey::read(&secret.public().to_text()).unwrap();
        assert_eq!(public, secret.public());
        let line = public.to_text().lines().nth(1).unwrap().to_owned();
        assert_eq!(PublicKey::read(&line).unwrap(), public, "its line alone is enough");
        let seed = STANDARD.encode(secret.key().to_bytes());
        assert!(!format!("{secret:?}").contains(&seed) && format!("{secret:?}").len() < 40);
        assert_ne!(SecretKey::draw().unwrap().id(), secret.id());
    }

    #[test]
    fn what_is_no_key_is_told_and_not_quoted() {
        let secret = SecretKey::draw().unwrap();
        let text = secret.to_text().to_string();
        let public = secret.public().to_text();
        let told = |error: SignError| error.to_string();
        assert!(told(SecretKey::read(&public).unwrap_err()).ends_with("found a public key"));
        assert!(told(PublicKey::read(&text).unwrap_err()).ends_with("found a secret key"));
        let bytes = STANDARD.decode(text.lines().nth(1).unwrap()).unwrap();
        let changed = |at: usize, word: &[u8]| {
            let mut bytes = bytes.clone();
            bytes[at..at + word.len()].copy_from_slice(word);
            format!("{COMMENT}x\n{}\n", STANDARD.encode(bytes))
        };
        let read = |text: &str| told(SecretKey::read(text).unwrap_err());
        assert_eq!(SecretKey::read(&changed(2, b"Sc")).unwrap_err(), SignError::Protected);
        assert!(read(&changed(2, b"Xx")).contains("unknown kind"));
        assert!(read(&changed(0, b"Xx")).contains("another algorithm"));
        assert!(read(&changed(HEAD + ID, &[0; 4])).contains("checksum"));
        let mut halves = bytes[HEAD..HEAD + ID + 64].to_vec();
        let file = |halves: &[u8], checksum: &[u8]| {
            let all = [&bytes[..HEAD], halves, checksum].concat();
            format!("{COMMENT}x\n{}\n", STANDARD.encode(all))
        };
        assert!(SecretKey::read(&file(&halves, &[0; 32])).is_ok(), "as minisign leaves it");
        halves[ID + 40] ^= 1;
        for checksum in [sum(&halves), [0; 32]] {
            assert!(read(&file(&halves, &checksum)).contains("do not belong together"));
        }
        let ssh =
            "-----BEGIN OPENSSH PRIVATE KEY-----\nc2VjcmV0\n-----END OPENSSH PRIVATE KEY-----\n";
        for (text, found) in [
            ("", "0 bytes"),
            ("untrusted comment: x", "nothing below"),
            (ssh, "a key of OpenSSH"),
            ("-----BEGIN PRIVATE KEY-----\nMC4C\n", "in PEM"),
            ("untrusted comment: x\n%%%\n", "no base64"),
            ("untrusted comment: x\nAAAA\nAAAA\n", "more than"),
        ] {
            assert!(read(text).contains(found), "{text}: {}", read(text));
            assert!(!read(text).contains("c2VjcmV0"));
        }
        let weak = format!(
            "{COMMENT}x\n{}\n",
            STANDARD.encode([&b"Ed12345678\x01"[..], &[0; 31]].concat())
        );
        assert!(told(PublicKey::read(&weak).unwrap_err()).contains("no key"));
    }
}
