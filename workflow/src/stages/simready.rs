//! Asset to a SimReady package, with a thumbnail of it.

use std::sync::Arc;

use asset::{Asset, AssetAppearance};
use object::glb;
use runner::{Stage, StageError};
use view::{Paint, ViewError, eight_views, encode_png, render};

use super::artefacts::Simready;
use super::code;
use super::tools::Tools;

/// Width and height of the thumbnail, pixels, as SimReady wants it (SR.002).
const SIZE: u32 = 256;
/// The side it is seen from.
const SIDE: &str = "front_right";

/// Asset to a SimReady package.
pub struct WriteSimready;

impl Stage<Tools> for WriteSimready {
    type Input = (Arc<Asset>, Arc<AssetAppearance>);
    type Output = Simready;
    const NAME: &'static str = "write-simready";

    fn code(&self) -> String {
        code::version(&[code::ASSET, code::VIEW])
    }

    fn run(&self, (asset, looks): Self::Input, _: &Tools) -> Result<Simready, StageError> {
        let mesh = glb::read(&asset.to_glb_with(&looks)).map_err(|e| StageError::from_error(&e))?;
        let thumbnail = picture(&mesh).map_err(|e| StageError::from_error(&e))?;
        Ok(asset.to_simready_with(&looks, thumbnail).into())
    }
}

/// PNG of the asset at rest, in its own colours.
fn picture(mesh: &object::Mesh) -> Result<Vec<u8>, ViewError> {
    let views = eight_views(&mesh.bounds(), SIZE);
    let Some(view) = views.iter().find(|v| v.name == SIDE).or(views.first()) else {
        return Err(ViewError::EmptySheet);
    };
    encode_png(&render(mesh, &Paint::Surface, &view.camera))
}
