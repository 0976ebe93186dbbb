//! Meshy's hosted image-to-3D.
//!
//! Source: `meshy-dev/meshy-mcp-server` (the vendor's own client). Paid; the finished file lies at a
//! signed address for a few days.

use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use secrecy::SecretString;
use serde_json::{Value, json};

use super::answer::{Asked, shortened};
use super::{Ask, Charges, FileAddress, Generator, JobHandle, JobState, Submitted, is_safe_id};
use crate::transport::{Method, Request};
use crate::{AdapterError, Transport};

const PROVIDER: &str = "meshy";
/// The service's address.
pub const BASE: &str = "https://api.meshy.ai";

/// An account at Meshy.
#[derive(Clone, Debug)]
pub struct Meshy {
    /// The service's address, [`BASE`] unless a test stands in.
    pub base: String,
    /// The account's key.
    pub key: SecretString,
    /// Such as `meshy-6`.
    pub model: String,
    /// Faces wanted, 100 to 300,000.
    pub faces: u32,
}

impl Meshy {
    fn request(&self, step: &str, path: &str, body: Option<&Value>) -> Request {
        use secrecy::ExposeSecret as _;
        let url = format!("{}/openapi/v1/image-to-3d{path}", self.base.trim_end_matches('/'));
        let step = format!("meshy.{step}");
        let request = match body {
            Some(body) => Request::post_json(step, url, body),
            None => Request::new(step, Method::Get, url),
        };
        let key = SecretString::from(format!("Bearer {}", self.key.expose_secret()));
        request.with_secret("authorization", Some(key)).within(Duration::from_secs(60), 1 << 20)
    }

    fn body(&self, ask: &Ask<'_>) -> Value {
        let picture = STANDARD.encode(&ask.photo.bytes);
        json!({
            "image_url": format!("data:{};base64,{picture}", ask.photo.media_type),
            "ai_model": self.model,
            "should_texture": false,
            "should_remesh": true,
            "topology": "triangle",
            "target_polycount": self.faces,
            "target_formats": ["glb"],
        })
    }
}

impl Generator for Meshy {
    fn identity(&self) -> String {
        format!("{PROVIDER}/1 {} faces {}, not repeatable", self.model, self.faces)
    }

    fn charges(&self) -> Charges {
        Charges::Money
    }

    fn own_server(&self) -> Option<&str> {
        (self.base != BASE).then_some(&self.base)
    }

    fn submit(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<Submitted, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "submit" };
        let answer =
            asked.json(&transport.send(&self.request("submit", "", Some(&self.body(ask))))?)?;
        let id = asked.text(&answer, "/result", "a new job must have a `result`")?;
        if !is_safe_id(id) {
            return Err(asked.broke("a job's number must be letters, digits, - and _", id));
        }
        Ok(Submitted::Job(JobHandle::new(id)))
    }

    fn poll(&self, transport: &dyn Transport, job: &JobHandle) -> Result<JobState, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "status" };
        let response = transport.send(&self.request("status", &format!("/{}", job.id), None))?;
        if response.status == 404 {
            return Ok(JobState::Gone);
        }
        let answer = asked.json(&response)?;
        match asked.text(&answer, "/status", "a job must have a `status`")? {
            "PENDING" | "IN_PROGRESS" => Ok(JobState::Running),
            "SUCCEEDED" => {
                let rule = "a finished job must have `model_urls.glb`";
                let address = asked.text(&answer, "/model_urls/glb", rule)?;
                Ok(JobState::At(FileAddress(address.into())))
            }
            ended @ ("FAILED" | "CANCELED") => {
                let words = answer.pointer("/task_error/message").and_then(Value::as_str);
                Ok(JobState::Failed(shortened(words.unwrap_or(ended))))
            }
            other => Err(asked.broke("a status must be one of Meshy's five", other)),
        }
    }
}
