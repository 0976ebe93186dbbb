//! Materials and textures of the mesh file, carried over to the surfaces of the asset.

use std::sync::Arc;

use adapters::GeneratedMesh;
use asset::{Asset, AssetAppearance};
use model::Articulation;
use object::meshfile;
use runner::{Stage, StageError};

use super::code;
use super::tools::Tools;

/// Asset, the object it was built of and the file that came from, to how each link looks.
pub struct TransferAppearance;

impl Stage<Tools> for TransferAppearance {
    type Input = (Arc<Asset>, Arc<Articulation>, Arc<GeneratedMesh>);
    type Output = AssetAppearance;
    const NAME: &'static str = "transfer-appearance";

    fn code(&self) -> String {
        code::version(&[code::ASSET])
    }

    fn run(
        &self,
        (asset, made, mesh): Self::Input,
        _tools: &Tools,
    ) -> Result<AssetAppearance, StageError> {
        let reading = meshfile::read_noted(&mesh.file).map_err(|e| StageError::from_error(&e))?;
        let of = AssetAppearance::of(&asset, &made.object, reading.appearance.as_ref());
        Ok(of.with_notes(reading.notes))
    }
}
