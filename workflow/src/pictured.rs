//! What stands in a photo's place where none was given: a view of the mesh, which is known.

use std::path::Path;

use adapters::{AdapterError, MeshFile, Photo};
use view::{Paint, eight_views, encode_png, render_views};

/// Width and height of the view, pixels.
const SIZE: u32 = 512;

/// The photo; without one, the first view of the mesh. Neither is there only where nobody asked for either.
///
/// # Errors
/// [`AdapterError`], naming the file, the rule and what was found.
pub(crate) fn photo(photo: Option<&Path>, mesh: Option<MeshFile>) -> Result<Photo, AdapterError> {
    let Some(mesh) = mesh.filter(|_| photo.is_none()) else {
        return Photo::open(photo.unwrap_or(Path::new("")));
    };
    let name = format!("a view of {}", mesh.path.display());
    let made = mesh.read()?;
    let views = eight_views(&made.mesh.bounds(), SIZE);
    let first = views.get(..1).unwrap_or_default();
    let drawn = render_views(&made.mesh, &Paint::Surface, first);
    let png = drawn.first().and_then(|picture| encode_png(picture).ok());
    Photo::read(png.unwrap_or_default(), &name)
}
