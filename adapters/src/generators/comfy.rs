//! `ComfyUI` servers of the user's own, with a workflow of the user's own.
//!
//! Source: `comfyanonymous/ComfyUI` (`server.py`). The workflow is one saved in API format; the
//! photo and the seed are put into the nodes that are named, and the first GLB among the outputs is
//! the mesh.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use trace::Digest;

use super::answer::{Asked, shortened, words};
use super::multipart::{Field, form};
use super::{Ask, Charges, FileAddress, Generator, JobHandle, JobState, Submitted, is_safe_id};
use crate::transport::{Method, Request};
use crate::{AdapterError, Transport};

const PROVIDER: &str = "comfyui";

/// A workflow: the file it lies in, or the graph itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Workflow {
    /// A file beside the configuration.
    File(String),
    /// Nodes by their ids.
    Graph(Map<String, Value>),
}

/// A `ComfyUI` server.
#[derive(Clone, Debug)]
pub struct Comfy {
    /// Its address, such as `http://127.0.0.1:8188`.
    pub base: String,
    /// Nodes by their ids.
    pub graph: Map<String, Value>,
    /// The node that takes the photo, under `image`.
    pub image_node: String,
    /// The node that takes the seed, under `seed`; none if there is none.
    pub seed_node: Option<String>,
}

impl Comfy {
    fn url(&self, path: &str) -> String {
        format!("{}/{path}", self.base.trim_end_matches('/'))
    }

    /// The photo's name on the server.
    fn uploaded(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<String, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "upload" };
        let image = Field::Png("image", &ask.photo.bytes);
        let fields = [image, Field::Text("type", "input"), Field::Text("overwrite", "true")];
        let (media_type, body) = form(&fields);
        let mut request = Request::new("comfyui.upload", Method::Post, self.url("upload/image"));
        request.headers.push(("content-type".into(), media_type));
        request.body = body;
        let answer = asked.json(&transport.send(&request)?)?;
        asked.text(&answer, "/name", "an upload must give a `name`").map(str::to_owned)
    }

    /// The graph with photo and seed in their nodes.
    fn filled(&self, photo: &str, seed: u64) -> Result<Value, AdapterError> {
        let mut graph = self.graph.clone();
        let mut put = |node: &str, key: &str, value: Value| {
            let inputs = graph.get_mut(node).and_then(|n| n.get_mut("inputs"));
            let inputs =
                inputs.and_then(Value::as_object_mut).ok_or_else(|| AdapterError::Format {
                    path: format!("workflow node {node}"),
                    expected: "a node with `inputs`",
                    found: "none".into(),
                })?;
            inputs.insert(key.into(), value);
            Ok::<_, AdapterError>(())
        };
        put(&self.image_node, "image", photo.into())?;
        if let Some(node) = &self.seed_node {
            put(node, "seed", (seed % (1 << 32)).into())?;
        }
        Ok(Value::Object(graph))
    }

    /// The first GLB among a job's outputs.
    fn file(&self, asked: Asked<'_>, outputs: &Value) -> Result<JobState, AdapterError> {
        let rule = "a finished workflow must give a GLB file";
        let entry = glb_entry(outputs);
        let entry = entry.ok_or_else(|| asked.broke(rule, shortened(&outputs.to_string())))?;
        let text = |key: &str| entry.get(key).and_then(Value::as_str).unwrap_or_default();
        let query = ["filename", "subfolder", "type"]
            .map(|key| format!("{key}={}", super::gradio::escaped(text(key))));
        Ok(JobState::At(FileAddress(self.url(&format!("view?{}", query.join("&"))))))
    }
}

impl Generator for Comfy {
    fn identity(&self) -> String {
        let graph = Value::Object(self.graph.clone()).to_string();
        let host = crate::net::redact::host(&self.base);
        format!(
            "{PROVIDER}/1 {host} workflow {}, not repeatable",
            Digest::of(graph.as_bytes()).short()
        )
    }

    fn charges(&self) -> Charges {
        Charges::Nothing
    }

    fn own_server(&self) -> Option<&str> {
        Some(&self.base)
    }

    fn submit(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<Submitted, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "submit" };
        let photo = self.uploaded(transport, ask)?;
        let graph = self.filled(&photo, ask.seed)?;
        let client = Digest::of(graph.to_string().as_bytes()).short().to_owned();
        let body = json!({ "prompt": graph, "client_id": client });
        let request = Request::post_json("comfyui.submit", self.url("prompt"), &body);
        let answer = asked.json(&transport.send(&request)?)?;
        let id = asked.text(&answer, "/prompt_id", "a new job must have a `prompt_id`")?;
        if !is_safe_id(id) {
            return Err(asked.broke("a `prompt_id` must be letters, digits, - and _", id));
        }
        Ok(Submitted::Job(JobHandle::new(id)))
    }

    fn poll(&self, transport: &dyn Transport, job: &JobHandle) -> Result<JobState, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "status" };
        let request =
            Request::new("comfyui.status", Method::Get, self.url(&format!("history/{}", job.id)));
        let response = transport.send(&request)?;
        let answer = asked.json(&response)?;
        let Some(entry) = answer.get(&job.id) else {
            let rule = "the history must have the job's status, or nothing yet";
            let empty = answer.as_object().is_some_and(Map::is_empty);
            return if empty {
                Ok(JobState::Running)
            } else {
                Err(asked.broke(rule, words(&response)))
            };
        };
        if entry.pointer("/status/status_str").and_then(Value::as_str) == Some("error") {
            let messages = entry.pointer("/status/messages").unwrap_or(&Value::Null);
            return Ok(JobState::Failed(shortened(&why(messages))));
        }
        self.file(asked, entry.get("outputs").unwrap_or(&Value::Null))
    }
}

/// What the server says of a workflow that failed.
fn why(messages: &Value) -> String {
    let told = messages.as_array().into_iter().flatten();
    let told = told.filter_map(|m| m.pointer("/1/exception_message")?.as_str()).next_back();
    told.map_or_else(|| "it does not say why".to_owned(), str::to_owned)
}

/// The first entry anywhere in some outputs whose file name ends with `.glb`.
fn glb_entry(value: &Value) -> Option<&Map<String, Value>> {
    match value {
        Value::Array(items) => items.iter().find_map(glb_entry),
        Value::Object(map) => {
            let name = map.get("filename").and_then(Value::as_str);
            let own = name.is_some_and(|n| n.to_ascii_lowercase().ends_with(".glb"));
            if own { Some(map) } else { map.values().find_map(glb_entry) }
        }
        _ => None,
    }
}
