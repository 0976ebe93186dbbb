//! DSSE envelopes (`secure-systems-lab/dsse` 1.0.2): a statement and its signatures in one JSON.
//!
//! Signed is the statement together with its type (PAE), so that nothing signed as one type passes
//! as another.
//!
//! ```
//! use trace::sign::{SecretKey, dsse};
//!
//! let key = SecretKey::draw()?;
//! let envelope = dsse::seal(&key, dsse::IN_TOTO, b"{}");
//! assert_eq!(dsse::open(&key.public(), dsse::IN_TOTO, &envelope)?, b"{}");
//! assert!(dsse::open(&key.public(), "text/plain", &envelope).is_err());
//! # Ok::<(), trace::sign::SignError>(())
//! ```

use base64::Engine as _;
use base64::engine::general_purpose::{STANDARD, URL_SAFE};
use ed25519_dalek::{Signature, Signer as _};
use guard::text::{brief, shown};
use serde::{Deserialize, Serialize};

use super::error::{SignError, other};
use super::key::{PublicKey, SecretKey};

/// The type of in-toto's statements.
pub const IN_TOTO: &str = "application/vnd.in-toto+json";
/// Most signatures of an envelope that are looked at: a guess, far above what anybody needs.
const MOST: usize = 64;
/// Most characters of a key's name that a message has: those of minisign have 16.
const LONGEST_ID: usize = 64;
/// What an envelope is called in errors.
const AN_ENVELOPE: &str = "a DSSE envelope";

#[derive(Deserialize, Serialize)]
struct Envelope {
    #[serde(rename = "payloadType")]
    payload_type: String,
    payload: String,
    signatures: Vec<Signed>,
}

#[derive(Deserialize, Serialize)]
struct Signed {
    #[serde(default, skip_serializing_if = "String::is_empty")]
    keyid: String,
    sig: String,
}

/// The envelope of a statement, signed; the same bytes for the same key and statement.
pub fn seal(key: &SecretKey, payload_type: &str, payload: &[u8]) -> Vec<u8> {
    let signature = key.key().sign(&encoded(payload_type, payload)).to_bytes();
    let signed = Signed { keyid: key.id().to_string(), sig: STANDARD.encode(signature) };
    let envelope = Envelope {
        payload_type: payload_type.to_owned(),
        payload: STANDARD.encode(payload),
        signatures: vec![signed],
    };
    // Strings alone: there is nothing in it that cannot be written.
    let mut text = serde_json::to_vec(&envelope).unwrap_or_default();
    text.push(b'\n');
    text
}

/// The statement in an envelope, if one of its signatures is the key's and it is of that type.
///
/// # Errors
/// [`SignError`] that says what is wrong with it.
pub fn open(key: &PublicKey, payload_type: &str, envelope: &[u8]) -> Result<Vec<u8>, SignError> {
    let envelope: Envelope =
        serde_json::from_slice(envelope).map_err(|e| other(AN_ENVELOPE, e.to_string()))?;
    if envelope.payload_type != payload_type {
        return Err(other(AN_ENVELOPE, "one of another type of payload"));
    }
    let payload = decoded(&envelope.payload)?;
    let covered = encoded(payload_type, &payload);
    let signatures = &envelope.signatures;
    if signatures.is_empty() || signatures.len() > MOST {
        let found = format!("one with {} signatures, expected 1 to {MOST}", signatures.len());
        return Err(other(AN_ENVELOPE, found));
    }
    for signed in signatures {
        let signature = Signature::from_slice(&decoded(&signed.sig)?);
        let signature = signature.map_err(|_| other(AN_ENVELOPE, "a signature that is cut off"))?;
        if key.key().verify_strict(&covered, &signature).is_ok() {
            return Ok(payload);
        }
    }
    // What an envelope says of its keys is a hint: nothing is decided by it.
    let own = key.id().to_string();
    match signatures.iter().find(|s| s.keyid == own || s.keyid.is_empty()) {
        Some(_) => Err(SignError::Forged),
        None => {
            let named = |s: &Signed| shown(&brief(&s.keyid, LONGEST_ID)).into_owned();
            let all = signatures.iter().map(named);
            let signed = all.take(3).collect::<Vec<_>>().join(", ");
            Err(SignError::OtherKey { signed, given: key.id() })
        }
    }
}

/// What is signed of a statement: PAE, "pre-authentication encoding".
fn encoded(payload_type: &str, payload: &[u8]) -> Vec<u8> {
    let head =
        format!("DSSEv1 {} {payload_type} {} ", payload_type.len(), payload.len()).into_bytes();
    [head, payload.to_vec()].concat()
}

/// Either alphabet of base64, as the specification has it.
fn decoded(text: &str) -> Result<Vec<u8>, SignError> {
    let bytes = STANDARD.decode(text).or_else(|_| URL_SAFE.decode(text));
    bytes.map_err(|_| other(AN_ENVELOPE, "no base64"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_signed_is_the_specifications_example() {
        // protocol.md of DSSE, "Test Vectors".
        let encoded = encoded("http://example.com/HelloWorld", b"hello world");
        assert_eq!(encoded, b"DSSEv1 29 http://example.com/HelloWorld 11 hello world");
    }

    #[test]
    fn a_statement_comes_out_of_its_envelope_for_its_key_and_type_alone() {
        let (key, stranger) = (SecretKey::draw().unwrap(), SecretKey::draw().unwrap());
        let envelope = seal(&key, IN_TOTO, b"{}");
        assert_eq!(envelope, seal(&key, IN_TOTO, b"{}"), "same bytes");
        let judged =
            |key: &SecretKey, kind: &str, text: &str| open(&key.public(), kind, text.as_bytes());
        let text = String::from_utf8(envelope).unwrap();
        assert_eq!(judged(&key, IN_TOTO, &text).unwrap(), b"{}");
        assert!(matches!(judged(&stranger, IN_TOTO, &text), Err(SignError::OtherKey { .. })));
        assert!(
            judged(&key, "text/plain", &text).unwrap_err().to_string().contains("another type")
        );
        // {} and []
        let other = judged(&key, IN_TOTO, &text.replace("e30=", "W10="));
        assert_eq!(other, Err(SignError::Forged));
        let retyped = text.replace("in-toto", "in-tofu");
        assert_eq!(judged(&key, "application/vnd.in-tofu+json", &retyped), Err(SignError::Forged));
        // Another key's signature beside it does no harm, and a borrowed number no good.
        let strange = String::from_utf8(seal(&stranger, IN_TOTO, b"{}")).unwrap();
        let signed = |text: &str| {
            let value: serde_json::Value = serde_json::from_str(text).unwrap();
            value["signatures"][0].clone()
        };
        let mut both: serde_json::Value = serde_json::from_str(&strange).unwrap();
        both["signatures"].as_array_mut().unwrap().push(signed(&text));
        assert_eq!(judged(&key, IN_TOTO, &both.to_string()).unwrap(), b"{}");
        let borrowed = strange.replace(&stranger.id().to_string(), &key.id().to_string());
        assert_eq!(judged(&key, IN_TOTO, &borrowed), Err(SignError::Forged));
    }

    #[test]
    fn an_envelope_that_is_one_long_text_is_not_quoted_whole() {
        let key = SecretKey::draw().unwrap().public();
        let told = |text: &str| open(&key, "t", text.as_bytes()).unwrap_err().to_string();
        let long = "long ".repeat(100_000);
        let other = format!(
            r#"{{"payloadType":"t","payload":"","signatures":[{{"keyid":"{long}","sig":"{}=="}}]}}"#,
            "A".repeat(86)
        );
        for envelope in [format!("\"{long}\""), format!("[\"\",\"\",\"{long}\"]"), other] {
            let told = told(&envelope);
            assert!(told.contains("long long") && told.len() < 400, "{} bytes", told.len());
        }
    }

    #[test]
    fn what_is_no_envelope_is_told() {
        let key = SecretKey::draw().unwrap().public();
        let told = |text: &str| open(&key, "t", text.as_bytes()).unwrap_err().to_string();
        assert!(told("").starts_with("expected a DSSE envelope"));
        let none = r#"{"payloadType":"t","payload":"","signatures":[]}"#;
        assert!(told(none).contains("one with 0 signatures"));
        let short = r#"{"payloadType":"t","payload":"","signatures":[{"sig":"AAAA"}]}"#;
        assert!(told(short).contains("cut off"));
        let twice = r#"{"payloadType":"t","payloadType":"u","payload":"","signatures":[]}"#;
        assert!(told(twice).contains("duplicate field"));
        let steering =
            r#"{"payloadType":"t","payload":"","signatures":[{"keyid":"\u001b[2J","sig":"SIG"}]}"#;
        let zeros = "A".repeat(86) + "==";
        assert!(!told(&steering.replace("SIG", &zeros)).contains('\u{1b}'));
    }
}
