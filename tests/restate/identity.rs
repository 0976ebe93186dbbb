//! Whom a worker obeys: requests that carry Restate's signature, by a key that was given to it.

use std::path::PathBuf;
use std::process::Command;

use base64::Engine as _;
use base64::engine::general_purpose::{STANDARD, URL_SAFE_NO_PAD};
use ed25519_dalek::{Signer as _, SigningKey};
use serde_json::{Value, json};
use trace::Clock as _;

use super::{Server, obeying, words};
use crate::batch::{Batch, same};
use crate::kinfold::{Said, program};

/// A key of Restate's, as people make it.
struct Identity(SigningKey);

impl Identity {
    fn of(seed: u8) -> Self {
        Self(SigningKey::from_bytes(&[seed; 32]))
    }

    /// The public key as Restate says it.
    fn public(&self) -> String {
        format!("publickeyv1_{}", base58(self.0.verifying_key().as_bytes()))
    }

    /// The secret key's file, as RFC 8410 has it.
    fn pem(&self, batch: &Batch) -> PathBuf {
        let head = [
            0x30, 0x2e, 0x02, 0x01, 0, 0x30, 0x05, 0x06, 0x03, 0x2b, 0x65, 0x70, 0x04, 0x22, 4,
            0x20,
        ];
        let der = STANDARD.encode([&head[..], &self.0.to_bytes()].concat());
        batch.write(
            "identity.pem",
            format!("-----BEGIN PRIVATE KEY-----\n{der}\n-----END PRIVATE KEY-----\n"),
        );
        batch.path("identity.pem")
    }

    /// A token for a path, from so many seconds ago to so many from now.
    fn token(&self, path: &str, (from, to): (i64, i64)) -> String {
        let now = i64::try_from(trace::SystemClock::default().now() / 1_000_000_000).unwrap();
        let claims = json!({ "aud": path, "iat": now + from, "nbf": now + from, "exp": now + to });
        let head = json!({ "typ": "JWT", "alg": "EdDSA", "kid": self.public() });
        let signed = format!("{}.{}", part(&head), part(&claims));
        let signature = self.0.sign(signed.as_bytes()).to_bytes();
        format!("{signed}.{}", URL_SAFE_NO_PAD.encode(signature))
    }
}

fn part(value: &Value) -> String {
    URL_SAFE_NO_PAD.encode(value.to_string())
}

/// Bitcoin's alphabet, as Restate has it.
fn base58(bytes: &[u8]) -> String {
    let alphabet = b"123456789ABCDEFGHJKLMNPQRSTUVWXYZabcdefghijkmnopqrstuvwxyz";
    let mut digits: Vec<u32> = Vec::new();
    for byte in bytes {
        let mut carry = u32::from(*byte);
        for digit in &mut digits {
            carry += *digit << 8;
            (*digit, carry) = (carry % 58, carry / 58);
        }
        while carry > 0 {
            digits.push(carry % 58);
            carry /= 58;
        }
    }
    let zeros = bytes.iter().take_while(|b| **b == 0).count();
    digits.resize(digits.len() + zeros, 0);
    digits.iter().rev().map(|digit| char::from(alphabet[*digit as usize])).collect()
}

/// What a worker answers to a request with these headers; `None` without curl.
fn asked(address: &str, path: &str, headers: &[String]) -> Option<String> {
    let mut command = Command::new("curl");
    command.args(["--silent", "--http2-prior-knowledge", "--max-time", "20", "--noproxy", "*"]);
    command.args(["--output", "-", "--write-out", "\n%{http_code}"]);
    for header in headers {
        command.args(["-H", header]);
    }
    if path.starts_with("/invoke") {
        // A refusal comes before a body would: some clients take that for no answer.
        command.args(["--request", "POST"]);
    }
    let Ok(said) = command.arg(format!("http://{address}{path}")).output() else {
        eprintln!("SKIPPED: no curl to ask a worker");
        return None;
    };
    String::from_utf8_lossy(&said.stdout).lines().last().map(str::to_owned)
}

#[test]
fn a_worker_obeys_only_what_is_signed_with_its_key() {
    let (own, other) = (Identity::of(1), Identity::of(2));
    let folder = tempfile::tempdir().unwrap();
    let (_worker, address) = obeying(folder.path(), &[&own.public()]);
    let signed = |token: String| {
        vec!["x-restate-signature-scheme: v1".to_owned(), format!("x-restate-jwt-v1: {token}")]
    };
    let now = (-60, 60);
    let invoke = "/invoke/kinfold.articulate/make";
    let nothing =
        format!("{}.{}.", part(&json!({ "alg": "none" })), part(&json!({ "aud": "/discover" })));
    let good = own.token("/discover", now);
    let mut bent = good.clone().into_bytes();
    let last = bent.len() - 5;
    bent[last] = if bent[last] == b'A' { b'B' } else { b'A' };
    let cases = [
        ("/discover", signed(good.clone()), "200"),
        ("/health", signed(own.token("/health", now)), "200"),
        ("/discover", vec![], "401"),
        ("/health", vec![], "401"),
        (invoke, vec![], "401"),
        ("/discover", vec!["x-restate-signature-scheme: unsigned".into()], "401"),
        ("/discover", vec!["x-restate-signature-scheme: v1".into()], "401"),
        (
            "/discover",
            vec!["x-restate-signature-scheme: v2".into(), format!("x-restate-jwt-v1: {good}")],
            "401",
        ),
        ("/discover", signed(other.token("/discover", now)), "401"),
        (invoke, signed(other.token(invoke, now)), "401"),
        (invoke, signed(good.clone()), "401"),
        ("/discover", signed(own.token("/discover", (-120, -60))), "401"),
        ("/discover", signed(own.token("/discover", (60, 120))), "401"),
        ("/discover", signed(nothing), "401"),
        ("/discover", signed(String::from_utf8(bent).unwrap()), "401"),
        ("/discover", signed("x".repeat(5000)), "401"),
    ];
    for (path, mut headers, expected) in cases {
        headers.push("accept: application/vnd.restate.endpointmanifest.v4+json".into());
        let Some(found) = asked(&address, path, &headers) else { return };
        assert_eq!(found, expected, "{path} {headers:?}");
    }
}

#[test]
fn a_batch_on_restate_that_signs_reaches_workers_that_know_its_key() {
    let (own, other) = (Identity::of(3), Identity::of(4));
    let (there, here) = (Batch::of(2), Batch::of(2));
    let Some(server) = Server::signing(Some(own.pem(&there))) else { return };
    let store = there.path("shared");
    let (_stranger, address) = obeying(&store, &[&other.public()]);
    let arguments = server.arguments(&store, &format!("http://{address}"));
    let refused = Said::from(there.batch(&words(&arguments)).output().unwrap());
    assert_eq!(refused.code, Some(1), "{refused:?}");
    // A key that is changed: the new one stands beside the old.
    let (_worker, address) = obeying(&store, &[&other.public(), &own.public()]);
    let arguments = server.arguments(&store, &format!("http://{address}"));
    let (said, _) = there.ran(&words(&arguments));
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(here.ran(&[]).0.code, Some(0));
    same(&here.assets(), &there.assets());
}

#[test]
fn a_key_that_is_none_is_told_before_anything_is_served() {
    for key in ["publickeyv1_", "publickeyv1_0OIl", "publickeyv1_abc"] {
        let args = ["worker", "--listen", "127.0.0.1:0", "--store", "s", "--identity-key", key];
        let said = Said::from(program().args(args).output().unwrap());
        assert_eq!(said.code, Some(2), "{key}: {said:?}");
        assert!(said.err.contains("expected a public key of Restate"), "{}", said.err);
    }
}
