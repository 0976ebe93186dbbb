//! Gradio servers of the user's own: TRELLIS, TRELLIS.2, SF3D, SPAR3D and whoever speaks so.
//!
//! Sources: `microsoft/TRELLIS` and `TRELLIS.2` (`app.py`), Gradio's own routes. A picture is
//! uploaded, functions of the app are called one after the other under one session, and the last
//! one's answer names a file on the server. What a function keeps for the next one stays on the
//! server, under the session.

use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use trace::Digest;

use super::answer::{Asked, shortened};
use super::multipart::{Field, form};
use super::{Ask, Charges, FileAddress, Generator, JobHandle, JobState, Submitted, is_safe_id};
use crate::transport::{Method, Request};
use crate::{AdapterError, Response, Transport};

const PROVIDER: &str = "gradio";

/// Longest time one function may take; its answer comes as a stream that ends when it is done.
const DEADLINE: Duration = Duration::from_secs(900);

/// One function of an app.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Call {
    /// Its name in the app's API.
    pub function: String,
    /// Its arguments; the texts `{image}` and `{seed}` are filled in.
    #[serde(default)]
    pub data: Vec<Value>,
}

impl Call {
    fn new(function: &str, data: Value) -> Self {
        let data = data.as_array().cloned().unwrap_or_default();
        Self { function: function.into(), data }
    }
}

/// Apps whose functions are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum App {
    /// TRELLIS.
    Trellis,
    /// TRELLIS.2, which wants 24 GB of video memory.
    Trellis2,
}

impl App {
    /// The functions to call, in order.
    pub fn calls(self) -> Vec<Call> {
        match self {
            // Its session's folder is made by `start_session` alone.
            Self::Trellis => vec![
                Call::new("start_session", json!([])),
                Call::new(
                    "image_to_3d",
                    json!(["{image}", [], "{seed}", 7.5, 12, 3.0, 12, "stochastic"]),
                ),
                Call::new("extract_glb", json!([0.95, 1024])),
            ],
            Self::Trellis2 => vec![
                Call::new("start_session", json!([])),
                Call::new(
                    "image_to_3d",
                    json!([
                        "{image}", "{seed}", "1024", 7.5, 0.7, 12, 5.0, 7.5, 0.5, 12, 3.0, 1.0,
                        0.0, 12, 3.0
                    ]),
                ),
                Call::new("extract_glb", json!([100_000, 1024])),
            ],
        }
    }
}

/// A Gradio server.
#[derive(Clone, Debug)]
pub struct Gradio {
    /// Its address, such as `http://127.0.0.1:7860`.
    pub base: String,
    /// What to call, in order; the last answer names the mesh.
    pub calls: Vec<Call>,
}

/// How far a job has come: which function was called, under which session, with what.
struct Place {
    call: usize,
    session: String,
    path: String,
    seed: u64,
}

impl Place {
    fn handle(&self, event: &str) -> JobHandle {
        let Self { call, session, path, seed } = self;
        let kept = [("call", call.to_string()), ("session", session.clone())];
        let given = [("path", path.clone()), ("seed", seed.to_string())];
        let kept = kept.into_iter().chain(given).map(|(name, value)| (name.to_owned(), value));
        JobHandle { id: event.to_owned(), kept: kept.collect() }
    }

    fn of(job: &JobHandle) -> Option<Self> {
        let kept = |name| job.kept.get(name).cloned();
        let number = |name| kept(name)?.parse().ok();
        let (call, seed) = (number("call")? as usize, number("seed")?);
        Some(Self { call, session: kept("session")?, path: kept("path")?, seed })
    }
}

impl Gradio {
    fn url(&self, path: &str) -> String {
        format!("{}/gradio_api/{path}", self.base.trim_end_matches('/'))
    }

    /// The place of the photo on the server.
    fn uploaded(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<String, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "upload" };
        let (media_type, body) = form(&[Field::Png("files", &ask.photo.bytes)]);
        let mut request = Request::new("gradio.upload", Method::Post, self.url("upload"));
        request.headers.push(("content-type".into(), media_type));
        request.body = body;
        let answer = asked.json(&transport.send(&request)?)?;
        asked.text(&answer, "/0", "an upload must give a path").map(str::to_owned)
    }

    /// Begins the call of a function.
    fn called(&self, transport: &dyn Transport, place: &Place) -> Result<JobHandle, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "call" };
        let Some(Call { function, data }) = self.calls.get(place.call) else {
            return Err(asked.broke("an app must have a function to call", "none"));
        };
        let data: Vec<_> = data.iter().map(|v| filled(v, &place.path, place.seed)).collect();
        let body = json!({ "data": data, "session_hash": place.session });
        let url = self.url(&format!("call/{function}"));
        let step = if place.call == 0 { "gradio.submit" } else { "gradio.call" };
        let answer = asked.json(&transport.send(&Request::post_json(step, url, &body))?)?;
        let event = asked.text(&answer, "/event_id", "a call must have an `event_id`")?;
        if !is_safe_id(event) {
            return Err(asked.broke("an `event_id` must be letters, digits, - and _", event));
        }
        Ok(place.handle(event))
    }

    /// The file the last function names: its own path on this server, whatever host it names.
    fn file(&self, asked: Asked<'_>, data: &Value) -> Result<JobState, AdapterError> {
        let rule = "the last function must give a GLB file";
        let path = glb_path(data).ok_or_else(|| asked.broke(rule, shortened(&data.to_string())))?;
        Ok(JobState::At(FileAddress(self.url(&format!("file={}", escaped(path))))))
    }
}

impl Generator for Gradio {
    fn identity(&self) -> String {
        let calls = json!(self.calls).to_string();
        let host = crate::net::redact::host(&self.base);
        format!("{PROVIDER}/1 {host} {calls}, not repeatable")
    }

    fn charges(&self) -> Charges {
        Charges::Nothing
    }

    fn own_server(&self) -> Option<&str> {
        Some(&self.base)
    }

    fn submit(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<Submitted, AdapterError> {
        let path = self.uploaded(transport, ask)?;
        let words = json!([path, ask.seed]).to_string();
        let session = Digest::of(words.as_bytes()).short().to_owned();
        let place = Place { call: 0, session, path, seed: ask.seed };
        Ok(Submitted::Job(self.called(transport, &place)?))
    }

    fn poll(&self, transport: &dyn Transport, job: &JobHandle) -> Result<JobState, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "result" };
        let Some(place) = Place::of(job) else { return Ok(JobState::Gone) };
        let Some(call) = self.calls.get(place.call) else { return Ok(JobState::Gone) };
        let url = self.url(&format!("call/{}/{}", call.function, job.id));
        let request = Request::new("gradio.result", Method::Get, url).within(DEADLINE, 16 << 20);
        let response = transport.send(&request)?;
        if response.status == 404 {
            return Ok(JobState::Gone);
        }
        let data = match ended(asked, &response)? {
            Ended::Complete(data) => data,
            Ended::Error(words) => return Ok(JobState::Failed(words)),
        };
        if place.call + 1 == self.calls.len() {
            return self.file(asked, &data);
        }
        let next = Place { call: place.call + 1, ..place };
        Ok(JobState::Next(self.called(transport, &next)?))
    }
}

/// How a function ended.
enum Ended {
    Complete(Value),
    Error(String),
}

/// Reads a stream of server-sent events to its `complete` or `error`.
fn ended(asked: Asked<'_>, response: &Response) -> Result<Ended, AdapterError> {
    if !response.is_success() {
        return Err(asked.refused(response));
    }
    let text = String::from_utf8_lossy(&response.body);
    let mut event = "";
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("event:") {
            event = name.trim();
        }
        let Some(data) = line.strip_prefix("data:").map(str::trim) else { continue };
        match event {
            "complete" => {
                let data = serde_json::from_str(data);
                return data.map(Ended::Complete).map_err(|e| {
                    asked.broke(
                        "an event's data must be JSON",
                        format!("{} ({e})", shortened(data_words(&text))),
                    )
                });
            }
            "error" => return Ok(Ended::Error(error_words(data))),
            _ => {}
        }
    }
    let found = shortened(data_words(&text));
    Err(asked.broke("the stream must end with `complete` or `error`", found))
}

/// The end of a stream, where what is wrong with it stands.
fn data_words(text: &str) -> &str {
    text.trim_end().lines().last().unwrap_or("nothing")
}

fn error_words(data: &str) -> String {
    let value: Value = serde_json::from_str(data).unwrap_or(Value::Null);
    let told = value.get("error").and_then(Value::as_str).or(value.as_str());
    shortened(told.unwrap_or("it does not say why"))
}

/// The first path of a GLB file anywhere in a function's answer.
fn glb_path(value: &Value) -> Option<&str> {
    match value {
        Value::Array(items) => items.iter().find_map(glb_path),
        Value::Object(map) => {
            let own = map.get("path").and_then(Value::as_str).filter(|p| p.ends_with(".glb"));
            own.or_else(|| map.values().find_map(glb_path))
        }
        Value::String(text) if text.ends_with(".glb") && !text.contains("://") => Some(text),
        _ => None,
    }
}

fn filled(value: &Value, path: &str, seed: u64) -> Value {
    match value.as_str() {
        Some("{image}") => json!({ "path": path, "meta": { "_type": "gradio.FileData" } }),
        // Gradio's sliders end at the largest 32-bit number.
        Some("{seed}") => (seed % (1 << 31)).into(),
        _ => value.clone(),
    }
}

/// A path as part of an address.
pub(super) fn escaped(path: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-._~/".contains(&b);
    path.bytes()
        .map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") })
        .collect()
}
