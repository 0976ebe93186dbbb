//! Shapes of parts to simulation-ready asset, amended where the checker finds it wanting.

use std::sync::Arc;
use std::time::Duration;

use asset::{Asset, Shapes};
use object::{Condition, Origin};
use runner::{Patience, Stage, StageError};

use super::code;
use super::repair::repaired;
use super::tools::Tools;

/// Shapes of parts to simulation-ready asset.
pub struct BuildAsset;

impl Stage<Tools> for BuildAsset {
    type Input = (Arc<Shapes>, Arc<Condition>);
    type Output = Asset;
    const NAME: &'static str = "build-asset";

    fn code(&self) -> String {
        code::version(&[code::ASSET, code::SIM_CHECK])
    }

    fn seed(&self, tools: &Tools) -> Option<u64> {
        Some(tools.seed)
    }

    fn patience(&self) -> Patience {
        Patience { timeout: Duration::from_secs(1800), ..Patience::default() }
    }

    fn run(&self, (shapes, condition): Self::Input, tools: &Tools) -> Result<Asset, StageError> {
        let shapes = Arc::unwrap_or_clone(shapes);
        let asset = asset::finish(shapes, &condition, Origin::Model);
        let asset = asset.map_err(|e| StageError::from_error(&e))?;
        repaired(asset, tools.seed, &tools.scratch)
    }
}
