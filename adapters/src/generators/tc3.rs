//! Tencent Cloud's signature of a request, `TC3-HMAC-SHA256`.
//!
//! Source: the vendor's own clients (`tencentcloud-sdk-python`). What is signed is the body, the
//! host, the action and the second in which it is signed; the service takes a signature for five
//! minutes.

use chrono::DateTime;
use hmac::{Hmac, Mac as _};
use sha2::{Digest as _, Sha256};

const SCHEME: &str = "TC3-HMAC-SHA256";
const END: &str = "tc3_request";
const SIGNED: &str = "content-type;host;x-tc-action";

/// A request to be signed: JSON, posted to a host's root.
#[derive(Clone, Copy, Debug)]
pub(super) struct Signing<'a> {
    /// The service's name in its scope, such as `ai3d`.
    pub(super) service: &'a str,
    /// Host, with its port where that is not the usual one.
    pub(super) host: &'a str,
    /// What is asked for.
    pub(super) action: &'a str,
    /// The body.
    pub(super) body: &'a [u8],
    /// When, in seconds since 1970.
    pub(super) seconds: u64,
}

impl Signing<'_> {
    /// The value of `authorization`: who signs, with the secret `id`, and the signature, made with
    /// the secret `key`.
    pub(super) fn authorization(&self, id: &str, key: &str) -> String {
        let moment = i64::try_from(self.seconds).ok().and_then(|s| DateTime::from_timestamp(s, 0));
        let date = moment.unwrap_or_default().format("%Y-%m-%d").to_string();
        let scope = format!("{date}/{}/{END}", self.service);
        let canonical = hex(&Sha256::digest(self.canonical()));
        let text = format!("{SCHEME}\n{}\n{scope}\n{canonical}", self.seconds);
        let first = format!("TC3{key}").into_bytes();
        let steps = [date.as_str(), self.service, END, text.as_str()];
        let signature = hex(&steps.into_iter().fold(first, |key, step| keyed(&key, step)));
        format!("{SCHEME} Credential={id}/{scope}, SignedHeaders={SIGNED}, Signature={signature}")
    }

    /// The request as both sides write it down before they sign.
    fn canonical(&self) -> String {
        let (host, action) = (self.host, self.action.to_ascii_lowercase());
        let body = hex(&Sha256::digest(self.body));
        format!(
            "POST\n/\n\ncontent-type:application/json\nhost:{host}\nx-tc-action:{action}\n\n\
             {SIGNED}\n{body}"
        )
    }
}

fn keyed(key: &[u8], text: &str) -> Vec<u8> {
    // HMAC takes a key of any length, so that there always is one.
    let mac = Hmac::<Sha256>::new_from_slice(key);
    let code = mac.map(|mac| mac.chain_update(text).finalize().into_bytes().to_vec());
    code.unwrap_or_default()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signing() -> Signing<'static> {
        Signing {
            service: "ai3d",
            host: "ai3d.tencentcloudapi.com",
            action: "QueryHunyuanTo3DProJob",
            body: b"{\"JobId\":\"1357237233311637504\"}",
            seconds: 1_700_000_000,
        }
    }

    /// The expected values were computed with Python's `hmac` and `hashlib` alone.
    #[test]
    fn a_signature_is_the_one_another_program_computes() {
        let told = signing().authorization("AKIDexample", "a-key-of-ours");
        let expected = "TC3-HMAC-SHA256 \
            Credential=AKIDexample/2023-11-14/ai3d/tc3_request, \
            SignedHeaders=content-type;host;x-tc-action, \
            Signature=b536775f27ffe9ae723d8688c452cc3e71092f83016effd538defb2e89c9e78f";
        assert_eq!(told, expected);
        let long = "k".repeat(100);
        let local =
            Signing { host: "127.0.0.1:8123", body: b"{}", seconds: 951_782_399, ..signing() };
        let told = local.authorization("id", &long);
        assert!(told.starts_with("TC3-HMAC-SHA256 Credential=id/2000-02-28/"), "{told}");
        assert!(
            told.ends_with(
                "Signature=1a5308f87cd7f27bc162b7b87523c822d4b9d1c80c7a581d84204c271a7d43d7"
            ),
            "{told}"
        );
    }

    #[test]
    fn whatever_is_signed_changes_the_signature() {
        let sign = |signing: Signing<'_>| signing.authorization("id", "key");
        let first = sign(signing());
        assert_eq!(first, sign(signing()));
        let others = [
            Signing { host: "h", ..signing() },
            Signing { action: "SubmitHunyuanTo3DProJob", ..signing() },
            Signing { body: b"{}", ..signing() },
            Signing { seconds: 1_700_000_001, ..signing() },
            Signing { service: "other", ..signing() },
        ];
        assert!(others.into_iter().all(|other| sign(other) != first));
        assert!(signing().authorization("id", "another") != first);
    }
}
