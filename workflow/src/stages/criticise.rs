//! Photo and articulated object to a critique: asks whoever says what looks wrong. It only flags:
//! nothing is made of what it says, and a run goes on without it.

use std::sync::Arc;

use adapters::{Critique, CritiqueQuestion, Photo};
use model::Articulation;
use runner::{Artefact, Patience, Resource, Stage, StageError};
use trace::Digest;

use super::code;
use super::motion_views::{SIZE, motion_views};
use super::tools::{Tools, adapter_error};

/// Photo and articulated object to a critique.
pub struct Criticise;

impl Tools {
    /// The stage that asks the critic, where there is one.
    pub fn criticise(&self) -> Option<Criticise> {
        self.critic.as_ref().map(|_| Criticise)
    }
}

impl Stage<Tools> for Criticise {
    type Input = (Arc<Photo>, Arc<Articulation>);
    type Output = Critique;
    const NAME: &'static str = "criticise";

    fn code(&self) -> String {
        code::version(&[code::VIEW, code::ADAPTERS])
    }

    fn params(&self, _tools: &Tools) -> serde_json::Value {
        serde_json::json!({ "size": SIZE })
    }

    fn identity(&self, tools: &Tools) -> Result<Option<String>, StageError> {
        let critic = tools.critic.as_ref().ok_or_else(nobody)?;
        critic.identity().map(Some).map_err(|e| adapter_error(&e))
    }

    fn resource(&self) -> Resource {
        Resource::Network
    }

    /// One attempt: a call is repeated by itself, and what may be gone without is not waited for.
    fn patience(&self) -> Patience {
        Patience::default()
    }

    fn run(&self, (photo, made): Self::Input, tools: &Tools) -> Result<Critique, StageError> {
        let critic = tools.critic.as_ref().ok_or_else(nobody)?;
        let views = motion_views(&made.object)?;
        let digest = Digest::of(&made.encode().map_err(|e| StageError::from_error(&e))?);
        let (object, views) = (&made.object, &views[..]);
        let question = CritiqueQuestion { photo: &photo, object, digest: &digest, views };
        critic.criticise(&question).map(Critique::Given).map_err(|e| adapter_error(&e))
    }

    fn instead(&self, error: &StageError) -> Option<Critique> {
        Some(Critique::Lost(error.line()))
    }
}

fn nobody() -> StageError {
    StageError::new("nobody to ask for a critique")
}
