//! A small object made in code: a cabinet with a door, as photo, mesh and condition.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use object::mesh::{FileFrame, UpAxis};
use object::{DVec3, Mesh, glb};
use serde_json::{Value, json};

/// Where a cabinet's files lie.
pub struct Cabinet {
    /// A picture; what it shows does not matter here.
    pub photo: PathBuf,
    /// The surface as GLB.
    pub mesh: PathBuf,
    /// The parts.
    pub condition: PathBuf,
}

impl Cabinet {
    /// Writes the three files into a folder.
    pub fn write(folder: &Path) -> Self {
        let this = Self {
            photo: folder.join("photo.png"),
            mesh: folder.join("cabinet.glb"),
            condition: folder.join("cabinet.json"),
        };
        std::fs::write(&this.photo, png(48, 40)).unwrap();
        std::fs::write(&this.mesh, glb::write(&mesh())).unwrap();
        this.write_condition(&condition());
        this
    }

    /// Replaces the condition.
    pub fn write_condition(&self, condition: &Value) {
        std::fs::write(&self.condition, condition.to_string()).unwrap();
    }
}

/// A PNG picture.
pub fn png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let pixel = |x: u32, y: u32| image::Rgb([(x * 5) as u8, (y * 6) as u8, 90]);
    let picture = image::RgbImage::from_fn(width, height, pixel);
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Body 0.4 x 0.3 x 0.6 m with its front at y = 0; door 2 cm thick, 2 mm before it.
pub fn mesh() -> Mesh {
    let body = [[-0.2, 0.0, 0.0], [0.2, 0.3, 0.6]];
    let door = [[-0.2, -0.022, 0.0], [0.2, -0.002, 0.6]];
    boxes(&[body, door])
}

/// Closed boxes, each by its lowest and its highest corner.
pub fn boxes(all: &[[[f64; 3]; 2]]) -> Mesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for [low, high] in all {
        add_box(&mut vertices, &mut faces, *low, *high);
    }
    Mesh::new(vertices, faces).unwrap()
}

fn add_box(vertices: &mut Vec<DVec3>, faces: &mut Vec<[u32; 3]>, low: [f64; 3], high: [f64; 3]) {
    let first = vertices.len() as u32;
    let pick = |i: usize, axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
    vertices.extend((0..8).map(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2))));
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for [a, b, c, d] in quads {
        faces.extend([[a, b, c], [a, c, d]].map(|f: [u32; 3]| f.map(|v| v + first)));
    }
}

/// A point of the object frame as it stands in the mesh file.
pub fn in_file(p: [f64; 3]) -> [f64; 3] {
    FileFrame { up: UpAxis::Y }.point_to_file(DVec3::from_array(p)).to_array()
}

/// The cabinet's condition.
pub fn condition() -> Value {
    json!({
        "schema": "kinfold-condition/1",
        "category": "cabinet",
        "size": { "height": 0.6 },
        "parts": [
            { "name": "body", "text": "cabinet body", "material": "wood",
              "point": in_file([0.2, 0.15, 0.3]) },
            { "name": "door", "text": "cabinet door", "parent": "body", "joint": "revolute",
              "material": "wood", "point": in_file([0.0, -0.022, 0.3]) },
        ],
    })
}

#[test]
fn the_cabinet_is_two_closed_boxes() {
    let volume = 0.4 * 0.3 * 0.6 + 0.4 * 0.02 * 0.6;
    assert!((mesh().signed_volume() - volume).abs() < 1e-12);
    assert_eq!(object::weld::Weld::new(&mesh()).components().1, 2);
}
