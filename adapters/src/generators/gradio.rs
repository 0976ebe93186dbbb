//! Gradio servers of the user's own: TRELLIS, TRELLIS.2, SF3D, SPAR3D and whoever speaks so.
//!
//! Sources: `microsoft/TRELLIS` and `TRELLIS.2` (`app.py`), Gradio's own routes. A picture is
//! uploaded, functions of the app are called one after the other under one session, and the last
//! one's answer names a file on the server. Where version 5 and later answer nothing, the server's
//! `/config` says what its addresses begin with. What a function keeps for the next one stays on the
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

/// What addresses begin with since Gradio 5 (its routes).
const PREFIX: &str = "/gradio_api";

/// Longest wait for what a server says of itself, and most bytes of it: an app of hundreds of
/// fields has some hundred kB.
const WITHIN: Duration = Duration::from_secs(30);
const MOST_CONFIG: u64 = 8 << 20;

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
    /// What the server's addresses begin with.
    prefix: String,
    /// Whether functions are called through its queue, as before version 5: `/call` there forgets
    /// what one function keeps for the next.
    queues: bool,
}

impl Place {
    fn handle(&self, event: &str) -> JobHandle {
        let Self { call, session, path, seed, prefix, queues } = self;
        let kept = [("call", call.to_string()), ("session", session.clone())];
        let where_to = [("prefix", prefix.clone()), ("queues", queues.to_string())];
        let given = [("path", path.clone()), ("seed", seed.to_string())];
        let kept = kept
            .into_iter()
            .chain(where_to)
            .chain(given)
            .map(|(name, value)| (name.to_owned(), value));
        JobHandle { id: event.to_owned(), kept: kept.collect() }
    }

    fn of(job: &JobHandle) -> Option<Self> {
        let kept = |name| job.kept.get(name).cloned();
        let number = |name| kept(name)?.parse().ok();
        let (call, seed) = (number("call")? as usize, number("seed")?);
        let prefix = kept("prefix").unwrap_or_else(|| PREFIX.to_owned());
        let queues = kept("queues").is_some_and(|word| word == "true");
        Some(Self { call, session: kept("session")?, path: kept("path")?, seed, prefix, queues })
    }
}

impl Gradio {
    fn url(&self, prefix: &str, path: &str) -> String {
        format!("{}{prefix}/{path}", self.base.trim_end_matches('/'))
    }

    /// The place of the photo on the server, before any function is called.
    fn uploaded(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<Place, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "upload" };
        let (media_type, body) = form(&[Field::Png("files", &ask.photo.bytes)]);
        let upload = |prefix: &str| {
            let url = self.url(prefix, "upload");
            let mut request = Request::new("gradio.upload", Method::Post, url);
            request.headers.push(("content-type".into(), media_type.clone()));
            request.body = body.clone();
            transport.send(&request)
        };
        let (mut prefix, mut queues) = (PREFIX.to_owned(), false);
        let mut response = upload(&prefix)?;
        if response.status == 404 {
            let server = Configured::of(&self.base, transport)?;
            (prefix, queues) = (server.prefix, server.queues);
            response = upload(&prefix)?;
        }
        let answer = asked.json(&response)?;
        let path = asked.text(&answer, "/0", "an upload must give a path")?.to_owned();
        let words = json!([path, ask.seed]).to_string();
        let session = Digest::of(words.as_bytes()).short().to_owned();
        Ok(Place { call: 0, session, path, seed: ask.seed, prefix, queues })
    }

    /// Begins the call of a function.
    fn called(&self, transport: &dyn Transport, place: &Place) -> Result<JobHandle, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "call" };
        let Some(Call { function, data }) = self.calls.get(place.call) else {
            return Err(asked.broke("an app must have a function to call", "none"));
        };
        let data: Vec<_> = data.iter().map(|v| filled(v, &place.path, place.seed)).collect();
        let (path, body) = if place.queues {
            let server = Configured::of(&self.base, transport)?;
            let Some(known) = server.functions.iter().find(|f| f.name == *function) else {
                let rule = "an app must have the functions that are called";
                return Err(asked.broke(rule, format!("no `{function}`, only {}", server.told())));
            };
            ("queue/join".to_owned(), known.queued(data, &place.session))
        } else {
            (format!("call/{function}"), json!({ "data": data, "session_hash": place.session }))
        };
        let url = self.url(&place.prefix, &path);
        let step = if place.call == 0 { "gradio.submit" } else { "gradio.call" };
        let answer = asked.json(&transport.send(&Request::post_json(step, url, &body))?)?;
        let event = asked.text(&answer, "/event_id", "a call must have an `event_id`")?;
        if !is_safe_id(event) {
            return Err(asked.broke("an `event_id` must be letters, digits, - and _", event));
        }
        Ok(place.handle(event))
    }

    /// The file the last function names: its own path on this server, whatever host it names.
    fn file(&self, asked: Asked<'_>, prefix: &str, data: &Value) -> Result<JobState, AdapterError> {
        let rule = "the last function must give a GLB file";
        let path = glb_path(data).ok_or_else(|| asked.broke(rule, shortened(&data.to_string())))?;
        Ok(JobState::At(FileAddress(self.url(prefix, &format!("file={}", escaped(path))))))
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
        let place = self.uploaded(transport, ask)?;
        Ok(Submitted::Job(self.called(transport, &place)?))
    }

    fn poll(&self, transport: &dyn Transport, job: &JobHandle) -> Result<JobState, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "result" };
        let Some(place) = Place::of(job) else { return Ok(JobState::Gone) };
        let Some(call) = self.calls.get(place.call) else { return Ok(JobState::Gone) };
        let path = match place.queues {
            // The event is named for the record alone: each question there has one answer.
            true => format!("queue/data?session_hash={}&event_id={}", place.session, job.id),
            false => format!("call/{}/{}", call.function, job.id),
        };
        let url = self.url(&place.prefix, &path);
        let request = Request::new("gradio.result", Method::Get, url).within(DEADLINE, 16 << 20);
        let response = transport.send(&request)?;
        if response.status == 404 {
            return Ok(JobState::Gone);
        }
        let data = match ended(asked, &response, place.queues)? {
            Ended::Complete(data) => data,
            Ended::Error(words) => return Ok(JobState::Failed(words)),
        };
        if place.call + 1 == self.calls.len() {
            return self.file(asked, &place.prefix, &data);
        }
        let next = Place { call: place.call + 1, ..place };
        Ok(JobState::Next(self.called(transport, &next)?))
    }
}

/// What a server says of itself under `/config`.
pub(crate) struct Configured {
    /// What its addresses begin with: nothing before version 5, which brought a prefix.
    prefix: String,
    /// Whether it is of before version 5.
    queues: bool,
    /// The functions that can be called.
    functions: Vec<Function>,
}

/// A function of an app.
struct Function {
    name: String,
    number: u64,
    /// For each of its inputs whether the server keeps it itself.
    kept: Vec<bool>,
}

impl Function {
    /// The body of a call through the queue, in which what the server keeps has an empty place.
    fn queued(&self, data: Vec<Value>, session: &str) -> Value {
        let mut given = data.into_iter();
        let places = self.kept.iter();
        let placed = places.map(|kept| if *kept { None } else { given.next() });
        let mut data: Vec<Value> = placed.map(Option::unwrap_or_default).collect();
        data.extend(given);
        json!({ "data": data, "fn_index": self.number, "session_hash": session })
    }
}

impl Configured {
    /// Asks a server.
    pub(crate) fn of(base: &str, transport: &dyn Transport) -> Result<Self, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "config" };
        let url = format!("{}/config", base.trim_end_matches('/'));
        let request = Request::new("gradio.config", Method::Get, url);
        let answer = asked.json(&transport.send(&request.within(WITHIN, MOST_CONFIG))?)?;
        let Some(functions) = answer.get("dependencies").and_then(Value::as_array) else {
            return Err(asked.broke("a Gradio server lists its `dependencies`", "none"));
        };
        let components = answer.get("components").and_then(Value::as_array);
        let of_state = components.into_iter().flatten().filter(|c| c["type"] == "state");
        let states: Vec<&Value> = of_state.map(|c| &c["id"]).collect();
        let function = |(k, of): (usize, &Value)| {
            let inputs = of["inputs"].as_array().into_iter().flatten();
            Some(Function {
                name: of["api_name"].as_str()?.trim_start_matches('/').to_owned(),
                number: of["id"].as_u64().unwrap_or(k as u64),
                kept: inputs.map(|id| states.contains(&id)).collect(),
            })
        };
        let functions = functions.iter().enumerate().filter_map(function).collect();
        let version = answer.get("version").and_then(Value::as_str).unwrap_or_default();
        let major = version.split('.').next().and_then(|number| number.parse::<u32>().ok());
        let prefix = answer.get("api_prefix").and_then(Value::as_str).unwrap_or_default();
        let prefix = prefix.trim_end_matches('/').to_owned();
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "/_-".contains(c);
        if !(prefix.is_empty() || prefix.starts_with('/') && !prefix.starts_with("//"))
            || !prefix.chars().all(is_plain)
        {
            return Err(asked.broke("`api_prefix` must be a path of letters and digits", prefix));
        }
        Ok(Self { prefix, queues: major.is_some_and(|number| number < 5), functions })
    }

    /// Of the functions to call the first that the server does not have.
    pub(crate) fn lacks<'c>(&self, calls: &'c [Call]) -> Option<&'c str> {
        let has = |call: &Call| self.functions.iter().any(|f| f.name == call.function);
        calls.iter().find(|call| !has(call)).map(|call| call.function.as_str())
    }

    /// The functions it has, told.
    pub(crate) fn told(&self) -> String {
        let names: Vec<_> = self.functions.iter().map(|f| f.name.as_str()).collect();
        shortened(&names.join(", "))
    }
}

/// How a function ended.
enum Ended {
    Complete(Value),
    Error(String),
}

/// Reads a stream of server-sent events to its `complete` or `error`, or, of a queue, to how the last
/// of its events ended: a session has one at a time.
fn ended(asked: Asked<'_>, response: &Response, queues: bool) -> Result<Ended, AdapterError> {
    if !response.is_success() {
        return Err(asked.refused(response));
    }
    let text = String::from_utf8_lossy(&response.body);
    if queues {
        let last = text.lines().rev().find_map(|line| message(line.strip_prefix("data:")?));
        let found = || shortened(data_words(&text));
        return last.ok_or_else(|| asked.broke("a queue must say how a function ended", found()));
    }
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

/// How a queue says that an event ended, if that is what it says.
fn message(data: &str) -> Option<Ended> {
    let said: Value = serde_json::from_str(data).ok()?;
    match said["msg"].as_str()? {
        "process_completed" if said["success"] == true => {
            Some(Ended::Complete(said["output"]["data"].clone()))
        }
        "process_completed" => Some(Ended::Error(error_words(&said["output"].to_string()))),
        "unexpected_error" => {
            let words = said["message"].as_str().unwrap_or("it does not say why");
            Some(Ended::Error(shortened(words)))
        }
        _ => None,
    }
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
