//! Mesh to pictures: eight sides of it, each named in the picture.

use std::sync::Arc;

use adapters::GeneratedMesh;
use rayon::prelude::*;
use runner::{Stage, StageError};
use view::{Paint, Picture, View, caption, eight_views, encode_png, render_views};

use super::artefacts::Views;
use super::bundle::Files;
use super::code;
use super::tools::Tools;

/// Width and height of each picture, pixels.
const SIZE: u32 = 1024;

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
        let pictures = render_views(&mesh.mesh, &Paint::Surface, &views);
        let named = views.par_iter().zip(pictures).enumerate();
        let total = views.len();
        let file = |(n, (view, picture))| file(view, picture, &format!("{}/{total}", n + 1));
        named.map(file).collect::<Result<Files, _>>().map(Views)
    }
}

fn file(view: &View, mut picture: Picture, which: &str) -> Result<(String, Vec<u8>), StageError> {
    caption(&mut picture, &format!("{} {which}", view.name.replace('_', " ")));
    let png = encode_png(&picture).map_err(|e| StageError::from_error(&e))?;
    Ok((format!("{}.png", view.name), png))
}
