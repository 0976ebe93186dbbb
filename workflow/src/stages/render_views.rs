//! Mesh to pictures: eight sides of it, each named in the picture.

use std::sync::Arc;

use adapters::GeneratedMesh;
use view::camera::{View, eight_views};
use view::raster::Paint;
use view::{caption, png, raster};

use super::bundle::Files;
use super::{Tools, Views, code};
use crate::dag::{Stage, StageError};

/// Width and height of each picture, pixels.
pub const SIZE: u32 = 1024;

/// Mesh to pictures.
pub struct RenderViews;

impl Stage<Tools> for RenderViews {
    type Input = Arc<GeneratedMesh>;
    type Output = Views;
    const NAME: &'static str = "render-views";

    fn code(&self) -> String {
        code::version(&[code::VIEW])
    }

    fn params(&self, _tools: &Tools) -> serde_json::Value {
        serde_json::json!({ "size": SIZE })
    }

    fn run(&self, mesh: Arc<GeneratedMesh>, _tools: &Tools) -> Result<Views, StageError> {
        let views = eight_views(&mesh.mesh.bounds(), SIZE);
        let total = views.len();
        let picture = |(n, view): (usize, &View)| {
            let mut picture = raster::render(&mesh.mesh, &Paint::Surface, &view.camera);
            caption(&mut picture, &format!("{} {}/{total}", view.name, n + 1));
            let png = png::encode_png(&picture).map_err(|e| StageError::from_error(&e))?;
            Ok((format!("{}.png", view.name), png))
        };
        views.iter().enumerate().map(picture).collect::<Result<Files, _>>().map(Views)
    }
}
