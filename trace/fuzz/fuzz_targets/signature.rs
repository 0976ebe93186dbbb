//! Any bytes as keys, signatures and envelopes: an error that may be shown, never a crash, and never a
//! signature of ours: nobody here has the secret key.
//!
//! The first byte says what the rest is.
#![no_main]

use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;
use trace::sign::{self, PublicKey, SecretKey, SignError, dsse};

/// A key whose secret half was thrown away, with the number of the one that signed the seeds.
const NOBODYS: &str = "RWS3mCkeBfN2V3nUbQY45SYvijbc/z7XOY+QE9HDyE+xwNGdH2sThCwP";

fn judge() -> Option<&'static PublicKey> {
    static KEY: OnceLock<Option<PublicKey>> = OnceLock::new();
    KEY.get_or_init(|| PublicKey::read(NOBODYS).ok()).as_ref()
}

fn may_be_shown(error: &SignError) {
    let told = error.to_string();
    assert!(!told.contains('\u{1b}') && told.len() < 4000, "{told:?}");
}

fuzz_target!(|bytes: &[u8]| {
    let [what, rest @ ..] = bytes else { return };
    if what % 4 == 3 {
        let opened = judge().map(|key| dsse::open(key, dsse::IN_TOTO, rest));
        assert!(!matches!(opened, Some(Ok(_))), "an envelope passed");
        return opened.and_then(Result::err).iter().for_each(may_be_shown);
    }
    let Ok(text) = std::str::from_utf8(rest) else { return };
    let error = match what % 4 {
        0 => match SecretKey::read(text) {
            Ok(key) => {
                let signed = sign::sign(&key, b"a trace", "by hand");
                let judged = signed.and_then(|s| sign::verify(&key.public(), b"a trace", &s));
                assert_eq!(judged.as_deref(), Ok("by hand"));
                None
            }
            Err(e) => Some(e),
        },
        1 => PublicKey::read(text).err(),
        _ => {
            let _ = sign::signer(text).is_ok();
            let judged = judge().map(|key| sign::verify(key, b"a trace", text));
            assert!(!matches!(judged, Some(Ok(_))), "a signature passed");
            judged.and_then(Result::err)
        }
    };
    error.iter().for_each(may_be_shown);
});
