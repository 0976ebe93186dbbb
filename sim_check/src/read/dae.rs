//! COLLADA file → mesh: triangles and polygons of the scene, each where its nodes put it, in metres.
//!
//! As RViz and Gazebo take it: the file's unit counts, its up axis does not. (PyBullet turns a file
//! that says another axis than z; such a file looks different there.) Materials, animations and
//! skins are passed over.
//!
//! ```
//! let text = r##"<COLLADA><asset><unit meter="0.01"/></asset><library_geometries><geometry id="g">
//!   <mesh><source id="p"><float_array id="a">0 0 0 200 0 0 0 300 0</float_array></source>
//!   <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
//!   <triangles><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh>
//!   </geometry></library_geometries></COLLADA>"##;
//! let mesh = sim_check::read::dae::read(text.as_bytes())?;
//! assert_eq!(mesh.area(0), 3.0);
//! # Ok::<(), sim_check::read::dae::DaeError>(())
//! ```

mod scene;
mod surface;
#[cfg(test)]
mod tests;
mod xml;

use object::Mesh;
use roxmltree::{Document, ParsingOptions};
pub use xml::DaeError;
use xml::child;

use crate::read::caps;

/// Most XML nodes of a file. Real ones have hundreds; numbers stand in a few long texts.
const MAX_NODES: u32 = 1_000_000;

/// Reads a COLLADA file.
///
/// # Errors
/// [`DaeError`], the first broken rule.
pub fn read(bytes: &[u8]) -> Result<Mesh, DaeError> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if let Some(rule) = caps::broken(text) {
        return Err(DaeError::Text(rule));
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options);
    let document = document.map_err(|e| DaeError::Text(format!("not XML: {e}")))?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(DaeError::at(root, "expected `COLLADA`"));
    }
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let metre = unit.and_then(|unit| unit.attribute("meter")).unwrap_or("1");
    let metre: f64 = metre.trim().parse().unwrap_or(f64::NAN);
    if !(metre > 0.0 && metre.is_finite()) {
        return Err(DaeError::at(root, "unit: meter must be a positive number"));
    }
    let soup = scene::gather(root, metre)?;
    Ok(Mesh::new(soup.points, soup.faces)?)
}
