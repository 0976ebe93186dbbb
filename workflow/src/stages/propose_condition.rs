//! Photo, mesh and pictures to condition: asks whoever says what the parts are.

use std::sync::Arc;
use std::time::Duration;

use adapters::{AdapterError, GeneratedMesh, KinematicQuestion, Photo, RenderedView};
use object::Condition;
use runner::{Patience, Resource, Stage, StageError};
use view::eight_views;

use super::artefacts::Views;
use super::code;
use super::tools::{Tools, adapter_error};

/// Photo, mesh and pictures to condition.
pub struct ProposeCondition;

impl Stage<Tools> for ProposeCondition {
    type Input = (Arc<Photo>, Arc<GeneratedMesh>, Arc<Views>);
    type Output = Condition;
    const NAME: &'static str = "propose-condition";

    fn code(&self) -> String {
        code::version(&[code::ADAPTERS])
    }

    fn identity(&self, tools: &Tools) -> Result<Option<String>, StageError> {
        tools.vlm.identity().map(Some).map_err(|e| explained(&e))
    }

    fn resource(&self) -> Resource {
        Resource::Network
    }

    fn patience(&self) -> Patience {
        Patience { timeout: Duration::from_secs(600), attempts: 4, pause: Duration::from_secs(2) }
    }

    fn run(
        &self,
        (photo, mesh, views): Self::Input,
        tools: &Tools,
    ) -> Result<Condition, StageError> {
        let view = |(name, png): (&String, &Vec<u8>)| {
            let name = name.trim_end_matches(".png").to_owned();
            RenderedView { name, png: png.clone() }
        };
        let mut views: Vec<_> = views.0.iter().map(view).collect();
        // A view is asked about by its number, and that stands in its picture.
        let standard = eight_views(&mesh.mesh.bounds(), 1);
        views.sort_by_key(|v| standard.iter().position(|s| s.name == v.name));
        let question = KinematicQuestion { photo: &photo, mesh: &mesh.mesh, views: &views };
        tools.vlm.propose(&question).map_err(|e| explained(&e))
    }
}

/// An error of whoever says what the parts are, with what to do about it.
pub(crate) fn explained(error: &AdapterError) -> StageError {
    let stage_error = adapter_error(error);
    match error {
        AdapterError::Condition { .. } => {
            stage_error.hint("`kinfold schema condition` prints the format of a condition file")
        }
        _ => stage_error,
    }
}
