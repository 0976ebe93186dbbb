//! Mesh to GLB: one plain primitive any viewer opens.

use glamx::DVec3;
use serde_json::{Value, json};

use super::paint::linear_of_srgb;
use crate::mesh::{FileFrame, Mesh, UpAxis};
use crate::normals::{CREASE_ANGLE, Shaded, shaded};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Writes a mesh as a plain GLB file, y up, single precision, the same bytes for the same mesh.
///
/// Faces keep their order; vertices are doubled along creases of more than 40° so that each has one
/// normal, and vertices no face uses are left out. Colours are stored as 16-bit linear light and
/// come back exactly.
pub fn write(mesh: &Mesh) -> Vec<u8> {
    let split = shaded(mesh, CREASE_ANGLE);
    let to_file =
        |p: DVec3| FileFrame { up: UpAxis::Y }.point_to_file(p).to_array().map(|c| c as f32);
    let mut body = Body::default();
    body.positions(split.source.iter().map(|&v| to_file(mesh.vertices()[v as usize])).collect());
    body.normals(split.normals.iter().map(|&n| to_file(n)).collect());
    if let Some(colours) = mesh.colours() {
        body.colours(split.source.iter().map(|&v| colours[v as usize]));
    }
    body.indices(&split);
    body.into_glb()
}

/// The binary chunk and what describes it, grown attribute by attribute.
#[derive(Default)]
struct Body {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    attributes: serde_json::Map<String, Value>,
}

impl Body {
    /// Adds a view and an accessor over `bytes`; both have the same index.
    fn add(&mut self, bytes: Vec<u8>, target: u32, mut accessor: Value) -> usize {
        let index = self.views.len();
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.views.push(
            json!({"buffer": 0, "byteOffset": offset, "byteLength": length, "target": target}),
        );
        accessor["bufferView"] = index.into();
        self.accessors.push(accessor);
        self.bytes.extend(bytes);
        index
    }

    fn attribute(&mut self, name: &str, bytes: Vec<u8>, accessor: Value) {
        let index = self.add(bytes, VERTICES, accessor);
        self.attributes.insert(name.into(), index.into());
    }

    fn positions(&mut self, rows: Vec<[f32; 3]>) {
        let pick = |pick: fn(f32, f32) -> f32, start: f32| {
            let fold = |m: [f32; 3], p: &[f32; 3]| std::array::from_fn(|i| pick(m[i], p[i]));
            rows.iter().fold([start; 3], fold).map(f64::from)
        };
        let (min, max) = (pick(f32::min, f32::INFINITY), pick(f32::max, f32::NEG_INFINITY));
        let accessor = json!({"componentType": FLOAT, "type": "VEC3", "count": rows.len(),
            "min": min, "max": max});
        self.attribute("POSITION", floats(&rows), accessor);
    }

    fn normals(&mut self, rows: Vec<[f32; 3]>) {
        let accessor = json!({"componentType": FLOAT, "type": "VEC3", "count": rows.len()});
        self.attribute("NORMAL", floats(&rows), accessor);
    }

    fn colours(&mut self, rows: impl ExactSizeIterator<Item = [u8; 4]>) {
        let count = rows.len();
        let word = |light: f64| (light * 65535.0).round() as u16;
        let linear = |c: u8| word(linear_of_srgb(f64::from(c) / 255.0));
        let words =
            |[r, g, b, a]: [u8; 4]| [linear(r), linear(g), linear(b), word(f64::from(a) / 255.0)];
        let bytes = rows.flat_map(words).flat_map(u16::to_le_bytes).collect();
        let accessor = json!({"componentType": UNSIGNED_SHORT, "type": "VEC4", "count": count,
            "normalized": true});
        self.attribute("COLOR_0", bytes, accessor);
    }

    fn indices(&mut self, split: &Shaded) {
        let bytes = split.faces.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let count = split.faces.len() * 3;
        let accessor = json!({"componentType": UNSIGNED_INT, "type": "SCALAR", "count": count});
        self.add(bytes, INDICES, accessor);
    }

    fn into_glb(self) -> Vec<u8> {
        let indices = self.views.len() - 1;
        let json = json!({
            "asset": {"version": "2.0", "generator": "kinfold"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [
                {"attributes": self.attributes, "indices": indices, "material": 0}
            ]}],
            "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.8},
                "doubleSided": true, "alphaMode": "OPAQUE"}],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.bytes.len()}],
        });
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bytes;
        bin.resize(bin.len().next_multiple_of(4), 0);
        let length = 12 + 8 + text.len() + 8 + bin.len();
        let mut glb = Vec::with_capacity(length);
        glb.extend(b"glTF");
        [2, length as u32].iter().for_each(|word| glb.extend(word.to_le_bytes()));
        for (kind, chunk) in [(b"JSON", text), (b"BIN\0", bin)] {
            glb.extend((chunk.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(chunk);
        }
        glb
    }
}

fn floats(rows: &[[f32; 3]]) -> Vec<u8> {
    rows.iter().flatten().flat_map(|c| c.to_le_bytes()).collect()
}
