//! Asset and how it looks to the files of a URDF package.

use std::sync::Arc;

use asset::{Asset, AssetAppearance};
use runner::{Stage, StageError};

use super::artefacts::UrdfPackage;
use super::code;
use super::tools::Tools;

/// Asset and how it looks to the files of a URDF package.
pub struct WriteUrdf;

impl Stage<Tools> for WriteUrdf {
    type Input = (Arc<Asset>, Arc<AssetAppearance>);
    type Output = UrdfPackage;
    const NAME: &'static str = "write-urdf";

    fn code(&self) -> String {
        code::version(&[code::ASSET])
    }

    fn run(&self, (asset, looks): Self::Input, _: &Tools) -> Result<UrdfPackage, StageError> {
        Ok(UrdfPackage(asset.to_urdf_with(&looks).files))
    }
}
