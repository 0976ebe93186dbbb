//! Mesh and prompts to an articulated object.

use std::sync::Arc;
use std::time::Duration;

use adapters::GeneratedMesh;
use model::Articulation;
use runner::{Patience, Stage, StageError};

use super::artefacts::Prompts;
use super::code;
use super::tools::Tools;

/// Mesh and prompts to an articulated object.
pub struct Articulate;

impl Stage<Tools> for Articulate {
    type Input = (Arc<GeneratedMesh>, Arc<Prompts>);
    type Output = Articulation;
    const NAME: &'static str = "articulate";

    fn code(&self) -> String {
        code::version(&[code::MODEL])
    }

    fn seed(&self, tools: &Tools) -> Option<u64> {
        Some(tools.seed)
    }

    fn identity(&self, tools: &Tools) -> Result<Option<String>, StageError> {
        Ok(Some(tools.articulate.identity()))
    }

    fn patience(&self) -> Patience {
        Patience { timeout: Duration::from_secs(1800), ..Patience::default() }
    }

    fn run(&self, (mesh, prompts): Self::Input, tools: &Tools) -> Result<Articulation, StageError> {
        let made = tools.articulate.articulate(&mesh.mesh, &prompts.0, tools.seed);
        made.map_err(|e| StageError::from_error(&e))
    }
}
