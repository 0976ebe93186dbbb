//! Stability's hosted SF3D and SPAR3D: one request, the mesh in its answer.
//!
//! Source: the vendor's v2beta specification. Paid; failures are not charged, but an answer that is
//! lost may be.

use std::time::Duration;

use secrecy::{ExposeSecret as _, SecretString};
use serde::{Deserialize, Serialize};

use super::answer::Asked;
use super::driver::glb_bytes;
use super::multipart::{Field, form};
use super::{Ask, Charges, Generator, JobHandle, JobState, Submitted};
use crate::files::MAX_MESH_BYTES;
use crate::net::address::same_origin;
use crate::transport::{Method, Request};
use crate::{AdapterError, Transport};

const PROVIDER: &str = "stability";
/// The service's address.
pub const BASE: &str = "https://api.stability.ai";

/// Its models.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// SF3D.
    #[serde(rename = "stable-fast-3d")]
    Fast,
    /// SPAR3D.
    #[serde(rename = "stable-point-aware-3d")]
    PointAware,
}

impl Model {
    fn path(self) -> &'static str {
        match self {
            Self::Fast => "stable-fast-3d",
            Self::PointAware => "stable-point-aware-3d",
        }
    }
}

/// An account at Stability.
#[derive(Clone, Debug)]
pub struct Stability {
    /// The service's address, [`BASE`] unless something stands in.
    pub base: String,
    /// The account's key.
    pub key: SecretString,
    /// Which of its models.
    pub model: Model,
}

impl Generator for Stability {
    fn identity(&self) -> String {
        format!("{PROVIDER}/1 {}, not repeatable", self.model.path())
    }

    fn charges(&self) -> Charges {
        Charges::Money
    }

    fn own_server(&self) -> Option<&str> {
        (!same_origin(&self.base, BASE)).then_some(&self.base)
    }

    fn submit(&self, transport: &dyn Transport, ask: &Ask<'_>) -> Result<Submitted, AdapterError> {
        let asked = Asked { provider: PROVIDER, step: "submit" };
        let seed = (ask.seed % (1 << 32)).to_string();
        let mut fields = vec![Field::Png("image", &ask.photo.bytes), Field::Text("remesh", "none")];
        if self.model == Model::PointAware {
            fields.push(Field::Text("seed", &seed));
        }
        let (media_type, body) = form(&fields);
        let url = format!("{}/v2beta/3d/{}", self.base.trim_end_matches('/'), self.model.path());
        let mut request = Request::new("stability.submit", Method::Post, url);
        request.headers.push(("content-type".into(), media_type));
        request.body = body;
        let key = format!("Bearer {}", self.key.expose_secret());
        let request = request.with_secret("authorization", Some(key.into()));
        let response = transport.send(&request.within(Duration::from_secs(600), MAX_MESH_BYTES))?;
        if !response.is_success() {
            return Err(asked.refused(&response));
        }
        glb_bytes(asked, response).map(Submitted::File)
    }

    fn poll(&self, _: &dyn Transport, _: &JobHandle) -> Result<JobState, AdapterError> {
        Ok(JobState::Gone)
    }
}
