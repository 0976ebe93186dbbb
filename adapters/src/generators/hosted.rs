//! Hosted services whose jobs are JSON: fal, Tripo, Replicate. What differs between them is data.
//!
//! Sources: `fal-ai/fal-js` (`queue.ts`), `tryAGI/Tripo` (version 3, after the vendor's pages),
//! Replicate's `openapi.json`. None of them has been called by us.

use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use secrecy::{ExposeSecret as _, SecretString};
use serde_json::{Map, Value, json};

use super::answer::{Asked, shortened};
use super::multipart::{Field, form};
use super::{Ask, Charges, FileAddress, Generator, JobHandle, JobState, Submitted, is_safe_id};
use crate::net::address::same_origin;
use crate::transport::{Method, Request};
use crate::{AdapterError, Transport};

/// How one service speaks.
#[derive(Debug, PartialEq, Eq)]
pub struct Dialect {
    /// Its name.
    pub name: &'static str,
    /// The version of its protocol; meshes of another one are other meshes.
    version: u32,
    /// Its address.
    pub base: &'static str,
    /// What stands before the key in `authorization`.
    pub scheme: &'static str,
    /// Path that takes a job; `{model}` is filled in.
    submit: &'static str,
    /// Where the answer has the job's number.
    id: &'static str,
    /// Path of a job; `{app}` and `{id}` are filled in.
    status: &'static str,
    /// Path of a finished job's result, where that is another.
    result: Option<&'static str>,
    /// Where a job has its status.
    state: &'static str,
    /// Statuses of a job that goes on.
    running: &'static [&'static str],
    /// Statuses of a job that has its mesh.
    done: &'static [&'static str],
    /// Statuses of a job that ended without one.
    ended: &'static [&'static str],
    /// Where a job says why.
    why: &'static [&'static str],
    /// Where a result has the address of its GLB, the first that is there.
    files: &'static [&'static str],
}

/// fal's queue.
pub const FAL: Dialect = Dialect {
    name: "fal",
    version: 1,
    base: "https://queue.fal.run",
    scheme: "Key ",
    submit: "/{model}",
    id: "/request_id",
    status: "/{app}/requests/{id}/status",
    result: Some("/{app}/requests/{id}"),
    state: "/status",
    running: &["IN_QUEUE", "IN_PROGRESS"],
    done: &["COMPLETED"],
    ended: &[],
    why: &["/error", "/detail"],
    files: &["/model_glb/url", "/model_mesh/url", "/model_urls/glb/url"],
};

/// Tripo's API, version 3.
pub const TRIPO: Dialect = Dialect {
    name: "tripo",
    version: 3,
    base: "https://openapi.tripo3d.ai/v3",
    scheme: "Bearer ",
    submit: "/generation/image-to-model",
    id: "/data/task_id",
    status: "/tasks/{id}",
    result: None,
    state: "/data/status",
    running: &["queued", "running"],
    done: &["success"],
    ended: &["failed", "cancelled"],
    why: &["/data/error_message", "/message", "/data/status"],
    files: &["/data/output/model_url", "/data/output/model_urls/0"],
};

/// Replicate's models.
pub const REPLICATE: Dialect = Dialect {
    name: "replicate",
    version: 1,
    base: "https://api.replicate.com/v1",
    scheme: "Bearer ",
    submit: "/models/{model}/predictions",
    id: "/id",
    status: "/predictions/{id}",
    result: None,
    state: "/status",
    running: &["starting", "processing"],
    done: &["succeeded"],
    ended: &["failed", "canceled", "aborted"],
    why: &["/error", "/status"],
    files: &["/output/model_file", "/output/mesh", "/output/glb", "/output/0", "/output"],
};

/// An account at such a service.
#[derive(Clone, Debug)]
pub struct Hosted {
    /// How it speaks.
    pub dialect: &'static Dialect,
    /// Its address, the dialect's own unless something stands in.
    pub base: String,
    /// The account's key.
    pub key: SecretString,
    /// Model or endpoint, such as `fal-ai/trellis-2`.
    pub model: String,
    /// The key of the input under which the photo goes, where models differ in it.
    pub image_key: String,
    /// Further inputs of the model.
    pub input: Map<String, Value>,
}

impl Hosted {
    fn request(&self, step: &str, path: &str, body: Option<&Value>) -> Request {
        let url = format!("{}{path}", self.base.trim_end_matches('/'));
        let step = format!("{}.{step}", self.dialect.name);
        let request = match body {
            Some(body) => Request::post_json(step, url, body),
            None => Request::new(step, Method::Get, url),
        };
        self.keyed(request)
    }

    fn keyed(&self, request: Request) -> Request {
        let key = format!("{}{}", self.dialect.scheme, self.key.expose_secret());
        let request = request.with_secret("authorization", Some(key.into()));
        request.within(Duration::from_secs(60), 4 << 20)
    }

    /// A path with the job's number in it. fal drops what stands behind the first two pieces of a
    /// model's name.
    fn path(&self, template: &str, id: &str) -> String {
        let app: Vec<_> = self.model.split('/').take(2).collect();
        template
            .replace("{app}", &app.join("/"))
            .replace("{id}", id)
            .replace("{model}", &self.model)
    }

    fn body(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<Value, AdapterError> {
        let mut input = self.input.clone();
        if self.dialect.name == TRIPO.name {
            let token = self.uploaded(transport, ask)?;
            input.insert("input".into(), token.into());
            input.insert("model".into(), self.model.clone().into());
            input.insert("texture".into(), false.into());
            input.insert("model_seed".into(), (ask.seed % (1 << 31)).into());
            return Ok(Value::Object(input));
        }
        let picture = STANDARD.encode(&ask.photo.bytes);
        let address = format!("data:{};base64,{picture}", ask.photo.media_type);
        input.insert(self.image_key.clone(), address.into());
        input.insert("seed".into(), (ask.seed % (1 << 31)).into());
        let input = Value::Object(input);
        Ok(if self.dialect.name == REPLICATE.name { json!({ "input": input }) } else { input })
    }

    /// The token of an uploaded photo.
    fn uploaded(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<String, AdapterError> {
        let (media_type, body) = form(&[Field::Png("file", &ask.photo.bytes)]);
        let url = format!("{}/files", self.base.trim_end_matches('/'));
        let mut request = Request::new("tripo.upload", Method::Post, url);
        request.headers.push(("content-type".into(), media_type));
        request.body = body;
        let asked = Asked { provider: self.dialect.name, step: "upload" };
        let answer = asked.json(&transport.send(&self.keyed(request))?)?;
        let rule = "an upload must have a `data.file_token`";
        asked.text(&answer, "/data/file_token", rule).map(str::to_owned)
    }

    /// The mesh's address in a result.
    fn file(&self, asked: Asked<'_>, result: &Value) -> Result<JobState, AdapterError> {
        let mut places = self.dialect.files.iter().filter_map(|p| result.pointer(p)?.as_str());
        let rule = "a finished job must have the address of a GLB";
        let address = places.find(|a| a.starts_with("http"));
        let address = address.ok_or_else(|| asked.broke(rule, shortened(&result.to_string())))?;
        Ok(JobState::At(FileAddress(address.into())))
    }

    fn result(&self, transport: &dyn Transport, job: &JobHandle) -> Result<JobState, AdapterError> {
        let asked = Asked { provider: self.dialect.name, step: "result" };
        let Some(template) = self.dialect.result else { return Ok(JobState::Gone) };
        let request = self.request("result", &self.path(template, &job.id), None);
        let response = transport.send(&request)?;
        // A job that broke is `COMPLETED` at fal; its result is an error.
        if matches!(response.status, 400 | 422) {
            return Ok(JobState::Failed(super::answer::words(&response)));
        }
        self.file(asked, &asked.json(&response)?)
    }
}

impl Generator for Hosted {
    fn identity(&self) -> String {
        let Self { dialect, model, image_key, input, .. } = self;
        let input = Value::Object(input.clone());
        let Dialect { name, version, .. } = dialect;
        format!("{name}/{version} {model} {image_key} {input}, not repeatable")
    }

    fn charges(&self) -> Charges {
        Charges::Money
    }

    fn own_server(&self) -> Option<&str> {
        (!same_origin(&self.base, self.dialect.base)).then_some(&self.base)
    }

    fn submit(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<Submitted, AdapterError> {
        let asked = Asked { provider: self.dialect.name, step: "submit" };
        let body = self.body(transport, ask)?;
        let request = self.request("submit", &self.path(self.dialect.submit, ""), Some(&body));
        let answer = asked.json(&transport.send(&request)?)?;
        let id = asked.text(&answer, self.dialect.id, "a new job must have a number")?;
        if !is_safe_id(id) {
            return Err(asked.broke("a job's number must be letters, digits, - and _", id));
        }
        Ok(Submitted::Job(JobHandle::new(id)))
    }

    fn poll(&self, transport: &dyn Transport, job: &JobHandle) -> Result<JobState, AdapterError> {
        let asked = Asked { provider: self.dialect.name, step: "status" };
        let dialect = self.dialect;
        let request = self.request("status", &self.path(dialect.status, &job.id), None);
        let response = transport.send(&request)?;
        if response.status == 404 {
            return Ok(JobState::Gone);
        }
        let answer = asked.json(&response)?;
        let state = asked.text(&answer, dialect.state, "a job must have a `status`")?;
        if dialect.running.contains(&state) {
            return Ok(JobState::Running);
        }
        if dialect.ended.contains(&state) {
            let why = dialect.why.iter().find_map(|p| answer.pointer(p).filter(|v| !v.is_null()));
            let why = why.map(|v| v.as_str().map_or_else(|| v.to_string(), String::from));
            return Ok(JobState::Failed(shortened(&why.unwrap_or_else(|| state.to_owned()))));
        }
        if !dialect.done.contains(&state) {
            return Err(asked.broke("a status must be one the service is known to use", state));
        }
        match dialect.result {
            Some(_) => self.result(transport, job),
            None => self.file(asked, &answer),
        }
    }
}
