//! Restate's back door: makes workers known, and asks whether all stages have one.

use std::sync::Arc;

use adapters::transport::{Method, Request, Response, Transport, TransportError};
use runner::restate::service;
use serde_json::json;

use super::ingress::said;
use crate::image_to_urdf::any_image_to_urdf;

/// Restate's administration.
pub struct Admin {
    /// Its address, such as `http://127.0.0.1:9070`.
    pub address: String,
    /// How requests get there.
    pub transport: Arc<dyn Transport>,
}

/// Why nobody could be asked for stages.
#[derive(Debug, thiserror::Error)]
pub enum AdminError {
    /// It does not answer.
    #[error("restate at {address}: cannot be asked: {source}")]
    Silent {
        /// Its address.
        address: String,
        /// What happened.
        source: TransportError,
    },
    /// It does not take the workers.
    #[error("restate at {address}: expected workers at {workers}, found status {status}: {found}")]
    Refused {
        /// Its address.
        address: String,
        /// The workers' address.
        workers: String,
        /// Of its answer.
        status: u16,
        /// What it said.
        found: String,
    },
    /// Nobody does a stage.
    #[error("restate at {address}: expected a worker for every stage, found no service {service}")]
    Nobody {
        /// Its address.
        address: String,
        /// The service that is missing.
        service: String,
    },
}

impl Admin {
    /// The administration at an address.
    pub fn new(address: &str, transport: Arc<dyn Transport>) -> Self {
        Self { address: address.trim_end_matches('/').into(), transport }
    }

    /// Makes workers known by the address Restate reaches them at.
    ///
    /// # Errors
    /// [`AdminError`] when Restate does not answer or cannot reach them.
    pub fn introduce(&self, workers: &str) -> Result<(), AdminError> {
        let body = json!({ "uri": workers, "force": true });
        let url = format!("{}/deployments", self.address);
        let response = self.send(&Request::post_json("restate.deployments", url, &body))?;
        match response.status {
            200..=299 => Ok(()),
            status => Err(AdminError::Refused {
                address: self.address.clone(),
                workers: workers.into(),
                status,
                found: said(&response),
            }),
        }
    }

    /// Asks whether every stage that computes has a worker.
    ///
    /// # Errors
    /// [`AdminError`] with the first that has none.
    pub fn everybody_there(&self) -> Result<(), AdminError> {
        for (stage, _) in any_image_to_urdf().computing() {
            let service = service(stage);
            let url = format!("{}/services/{service}", self.address);
            let response = self.send(&Request::new("restate.services", Method::Get, url))?;
            if response.status != 200 {
                return Err(AdminError::Nobody { address: self.address.clone(), service });
            }
        }
        Ok(())
    }

    fn send(&self, request: &Request) -> Result<Response, AdminError> {
        let silent = |source| AdminError::Silent { address: self.address.clone(), source };
        self.transport.send(request).map_err(silent)
    }
}
