//! Asset to the files of a URDF package.

use std::sync::Arc;

use asset::Asset;
use runner::{Stage, StageError};

use super::artefacts::UrdfPackage;
use super::code;
use super::tools::Tools;

/// Asset to the files of a URDF package.
pub struct WriteUrdf;

impl Stage<Tools> for WriteUrdf {
    type Input = Arc<Asset>;
    type Output = UrdfPackage;
    const NAME: &'static str = "write-urdf";

    fn code(&self) -> String {
        code::version(&[code::ASSET])
    }

    fn run(&self, asset: Arc<Asset>, _tools: &Tools) -> Result<UrdfPackage, StageError> {
        Ok(UrdfPackage(asset.to_urdf().files))
    }
}
