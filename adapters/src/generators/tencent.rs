//! Tencent Cloud's hosted Hunyuan3D, `ai3d`.
//!
//! Source: `TencentCloud/tencentcloud-sdk-python` (`ai3d/v20250513`). Paid, in credits that a finished
//! job reports; every step is a signed `POST`, errors come with status 200, and a job's number and
//! its files are good for a day. It has not been called by us.

use std::sync::Arc;
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use secrecy::{ExposeSecret as _, SecretString};
use serde_json::{Value, json};
use trace::Clock;

use super::answer::{Asked, shortened};
use super::tc3::Signing;
use super::{Ask, Charges, FileAddress, Generator, JobHandle, JobState, Submitted, is_safe_id};
use crate::net::address::same_origin;
use crate::net::redact;
use crate::transport::Request;
use crate::{AdapterError, Photo, Response, Transport};

const PROVIDER: &str = "tencent";
/// The service's address.
pub const BASE: &str = "https://ai3d.tencentcloudapi.com";
const SERVICE: &str = "ai3d";
const VERSION: &str = "2025-05-13";
/// Most characters of a photo in base64.
const MAX_PHOTO: usize = 6_000_000;
/// Shortest and longest side of a photo, pixels.
const SIDES: std::ops::RangeInclusive<u32> = 128..=5000;

/// An account at Tencent Cloud.
pub struct Tencent {
    /// The service's address, [`BASE`] unless something stands in.
    pub base: String,
    /// Whose key it is.
    pub id: SecretString,
    /// The key that signs.
    pub key: SecretString,
    /// Such as `ap-guangzhou`, where the account wants one.
    pub region: Option<String>,
    /// `3.0` or `3.1`.
    pub model: String,
    /// Faces wanted, 3,000 to 1,500,000.
    pub faces: u32,
    /// The time that signatures are made with.
    pub clock: Arc<dyn Clock>,
}

impl Tencent {
    fn request(&self, step: &str, action: &str, body: &Value) -> Request {
        let url = format!("{}/", self.base.trim_end_matches('/'));
        let host = redact::host(&url);
        let mut request = Request::post_json(format!("{PROVIDER}.{step}"), url, body);
        let seconds = self.clock.now() / 1_000_000_000;
        let timestamp = seconds.to_string();
        let signing =
            Signing { service: SERVICE, host: &host, action, body: &request.body, seconds };
        let (id, key) = (self.id.expose_secret(), self.key.expose_secret());
        let authorization = signing.authorization(id, key);
        let told = [("action", action), ("version", VERSION), ("timestamp", timestamp.as_str())];
        let region = self.region.as_deref().map(|region| ("region", region));
        let told = told.into_iter().chain(region);
        request.headers.extend(told.map(|(name, value)| (format!("x-tc-{name}"), value.into())));
        let request = request.with_secret("authorization", Some(authorization.into()));
        request.within(Duration::from_secs(60), 1 << 20)
    }

    fn body(&self, ask: &Ask<'_>) -> Result<Value, AdapterError> {
        Ok(json!({
            "Model": self.model,
            "ImageBase64": picture(ask.photo)?,
            // The mesh alone, without a texture; it comes as GLB where no format is named.
            "GenerateType": "Geometry",
            "FaceCount": self.faces,
        }))
    }
}

impl Generator for Tencent {
    fn identity(&self) -> String {
        format!("{PROVIDER}/1 {} faces {}, not repeatable", self.model, self.faces)
    }

    fn charges(&self) -> Charges {
        Charges::Money
    }

    fn own_server(&self) -> Option<&str> {
        (!same_origin(&self.base, BASE)).then_some(&self.base)
    }

    fn submit(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<Submitted, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "submit" };
        let request = self.request("submit", "SubmitHunyuanTo3DProJob", &self.body(ask)?);
        let answer = told(asked, &transport.send(&request)?)?;
        let id = asked.text(&answer, "/Response/JobId", "a new job must have a `JobId`")?;
        if !is_safe_id(id) {
            return Err(asked.broke("a `JobId` must be letters, digits, - and _", id));
        }
        Ok(Submitted::Job(JobHandle::new(id)))
    }

    fn poll(&self, transport: &dyn Transport, job: &JobHandle) -> Result<JobState, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "status" };
        let body = json!({ "JobId": job.id });
        let request = self.request("status", "QueryHunyuanTo3DProJob", &body);
        let answer = match told(asked, &transport.send(&request)?) {
            Err(AdapterError::Service { status: Some(404), .. }) => return Ok(JobState::Gone),
            answer => answer?,
        };
        match asked.text(&answer, "/Response/Status", "a job must have a `Status`")? {
            "WAIT" | "RUN" => Ok(JobState::Running),
            "DONE" => file(asked, &answer),
            "FAIL" => Ok(JobState::Failed(why(&answer))),
            other => Err(asked.broke("a status must be WAIT, RUN, FAIL or DONE", other)),
        }
    }
}

/// A photo in base64, within the service's limits.
fn picture(photo: &Photo) -> Result<String, AdapterError> {
    let refused = |rule: String, found: String| {
        Err(AdapterError::Photo { path: "photo".into(), rule, found })
    };
    let [width, height] = photo.size;
    if !SIDES.contains(&width) || !SIDES.contains(&height) {
        let (least, most) = (*SIDES.start(), *SIDES.end());
        let rule = format!("Tencent takes a photo of {least} to {most} pixels a side");
        return refused(rule, format!("{width} x {height} as it would be sent"));
    }
    let text = STANDARD.encode(&photo.bytes);
    if text.len() > MAX_PHOTO {
        let rule = format!("Tencent takes a photo of at most {MAX_PHOTO} bytes in base64");
        return refused(rule, format!("{} as it would be sent", text.len()));
    }
    Ok(text)
}

/// The answer, unless it is an error.
fn told(asked: Asked<'_>, response: &Response) -> Result<Value, AdapterError> {
    let answer = asked.json(response)?;
    let Some(error) = answer.pointer("/Response/Error").filter(|e| !e.is_null()) else {
        return Ok(answer);
    };
    let word = |key| error.get(key).and_then(Value::as_str).unwrap_or_default();
    let (code, message) = (word("Code"), word("Message"));
    let found = shortened(&format!("{code} {message}"));
    let (provider, step) = (asked.provider.into(), asked.step.into());
    let (rule, status) = ("the answer must be without an error", in_http(code));
    Err(AdapterError::Service { provider, step, rule, found, status })
}

/// What a code says in HTTP's words, by its family in the vendor's list; none where it does not say
/// whether anything was done.
fn in_http(code: &str) -> Option<u16> {
    match code.split('.').next().unwrap_or_default() {
        "AuthFailure" | "UnauthorizedOperation" => Some(401),
        "ResourceNotFound" => Some(404),
        "LimitExceeded" | "RequestLimitExceeded" | "ResourceInsufficient" => Some(429),
        "InvalidAction"
        | "InvalidParameter"
        | "InvalidParameterValue"
        | "InvalidRequest"
        | "MissingParameter"
        | "NoSuchProduct"
        | "NoSuchVersion"
        | "OperationDenied"
        | "ResourceUnavailable"
        | "UnknownParameter"
        | "UnsupportedOperation"
        | "UnsupportedProtocol"
        | "UnsupportedRegion" => Some(400),
        "InternalError" => Some(500),
        _ => None,
    }
}

/// The address of a finished job's GLB.
fn file(asked: Asked<'_>, answer: &Value) -> Result<JobState, AdapterError> {
    let files = answer.pointer("/Response/ResultFile3Ds").and_then(Value::as_array);
    let text = |file: &Value, key: &str| Some(file.get(key)?.as_str()?.to_owned());
    let is_glb = |file: &&Value| text(file, "Type").is_some_and(|t| t.eq_ignore_ascii_case("glb"));
    let address = files.into_iter().flatten().filter(is_glb).find_map(|file| text(file, "Url"));
    let rule = "a finished job must have a file of the type GLB";
    let address = address.ok_or_else(|| asked.broke(rule, shortened(&answer.to_string())))?;
    Ok(JobState::At(FileAddress(address)))
}

/// Why a job failed.
fn why(answer: &Value) -> String {
    let word = |key| answer.pointer(key).and_then(Value::as_str).filter(|w| !w.is_empty());
    let told = [word("/Response/ErrorCode"), word("/Response/ErrorMessage")];
    let told = told.into_iter().flatten().collect::<Vec<_>>().join(" ");
    shortened(if told.is_empty() { "it does not say why" } else { &told })
}

#[cfg(test)]
#[path = "tencent_tests.rs"]
mod tests;
