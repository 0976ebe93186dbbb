//! Hunyuan3D's own `api_server`, 2.0 and 2.1, on a machine of the user's.
//!
//! Source: `Tencent-Hunyuan/Hunyuan3D-2` and `Hunyuan3D-2.1`, `api_server.py`. The server answers
//! nothing while it generates, reports every failure as 404, and calls a job it lost "processing"
//! for ever; the whole request is handed to its pipeline, so only keys it knows may be sent.

use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::answer::{Asked, shortened};
use super::driver::glb_bytes;
use super::{Ask, Charges, Generator, JobHandle, JobState, Submitted, is_safe_id};
use crate::files::MAX_MESH_BYTES;
use crate::transport::{Method, Request};
use crate::{AdapterError, Transport};

const PROVIDER: &str = "hunyuan3d";

/// A Hunyuan3D server.
#[derive(Clone, Debug, PartialEq)]
pub struct Hunyuan {
    /// Its address, such as `http://127.0.0.1:8081`.
    pub base: String,
    /// How it is asked.
    pub manner: Manner,
    /// Octree resolution of the surface, 64 to 512.
    pub octree_resolution: u32,
    /// Steps of the diffusion, 1 to 20 on version 2.1.
    pub steps: u32,
}

/// How a server is asked for a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Manner {
    /// One long request; sure, and nothing is left behind.
    Wait,
    /// A job, looked after; survives a broken connection.
    Queue,
}

impl Hunyuan {
    /// A server with the settings of version 2.1's own defaults.
    pub fn new(base: impl Into<String>) -> Self {
        Self { base: base.into(), manner: Manner::Wait, octree_resolution: 256, steps: 5 }
    }

    fn url(&self, path: &str) -> String {
        format!("{}{path}", self.base.trim_end_matches('/'))
    }

    fn body(&self, ask: &Ask<'_>) -> Value {
        json!({
            "image": STANDARD.encode(&ask.photo.bytes),
            "texture": false,
            "type": "glb",
            // Version 2.1 takes 32 bits.
            "seed": ask.seed % (1 << 32),
            "octree_resolution": self.octree_resolution,
            "num_inference_steps": self.steps,
        })
    }
}

impl Generator for Hunyuan {
    fn identity(&self) -> String {
        let Self { octree_resolution, steps, .. } = self;
        format!("{PROVIDER}/1 octree {octree_resolution} steps {steps}, not repeatable")
    }

    fn charges(&self) -> Charges {
        Charges::Nothing
    }

    fn submit(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<Submitted, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "submit" };
        let send = |path, time| {
            let request = Request::post_json("hunyuan.submit", self.url(path), &self.body(ask));
            transport.send(&request.within(Duration::from_secs(time), MAX_MESH_BYTES))
        };
        if self.manner == Manner::Queue {
            let answer = asked.json(&send("/send", 60)?)?;
            let id = asked.text(&answer, "/uid", "a new job must have a `uid`")?;
            if !is_safe_id(id) {
                return Err(asked.broke("a `uid` must be letters, digits, - and _", id));
            }
            return Ok(Submitted::Job(JobHandle::new(id)));
        }
        let response = send("/generate", 900)?;
        if !response.is_success() {
            return Err(asked.refused(&response));
        }
        glb_bytes(asked, response).map(Submitted::File)
    }

    fn poll(&self, transport: &dyn Transport, job: &JobHandle) -> Result<JobState, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "status" };
        let url = self.url(&format!("/status/{}", job.id));
        let request = Request::new("hunyuan.status", Method::Get, url);
        // While it generates the server is silent: a look may take as long as the work.
        let request = request.within(Duration::from_secs(600), MAX_MESH_BYTES / 3 * 4 + 4096);
        let response = transport.send(&request)?;
        let told: Option<Value> = serde_json::from_slice(&response.body).ok();
        let word = |key| told.as_ref().and_then(|t| t.pointer(key)).and_then(Value::as_str);
        if word("/status") == Some("error") {
            let words = word("/message").unwrap_or("without a word");
            return Ok(JobState::Failed(shortened(words)));
        }
        let answer = asked.json(&response)?;
        match asked.text(&answer, "/status", "a job must have a `status`")? {
            "processing" | "texturing" => Ok(JobState::Running),
            "completed" => {
                let rule = "a completed job must hold `model_base64`";
                let file = asked.text(&answer, "/model_base64", rule)?;
                let file = STANDARD.decode(file);
                let file =
                    file.map_err(|e| asked.broke("`model_base64` must be base64", e.to_string()))?;
                Ok(JobState::Inline(file))
            }
            other => Err(asked.broke("a status must be processing, texturing or completed", other)),
        }
    }
}
