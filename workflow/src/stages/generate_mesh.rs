//! Photo to mesh: asks whoever makes meshes.

use std::sync::Arc;
use std::time::Duration;

use adapters::{GeneratedMesh, Photo};
use runner::{Patience, Resource, Stage, StageError};

use super::code;
use super::tools::{Tools, adapter_error};

/// Photo to mesh.
pub struct GenerateMesh;

impl Stage<Tools> for GenerateMesh {
    type Input = Arc<Photo>;
    type Output = GeneratedMesh;
    const NAME: &'static str = "generate-mesh";

    fn code(&self) -> String {
        code::version(&[code::ADAPTERS])
    }

    fn seed(&self, tools: &Tools) -> Option<u64> {
        Some(tools.seed)
    }

    fn identity(&self, tools: &Tools) -> Result<Option<String>, StageError> {
        tools.image_to_3d.identity().map(Some).map_err(|e| adapter_error(&e))
    }

    fn resource(&self) -> Resource {
        Resource::Network
    }

    fn patience(&self) -> Patience {
        Patience { timeout: Duration::from_secs(1800), attempts: 4, pause: Duration::from_secs(2) }
    }

    fn run(&self, photo: Arc<Photo>, tools: &Tools) -> Result<GeneratedMesh, StageError> {
        tools.image_to_3d.generate(&photo, tools.seed).map_err(|e| adapter_error(&e))
    }
}
