//! Mesh to GLB: one plain primitive any viewer opens, and the chunk larger files are grown from.

use std::collections::BTreeMap;

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
    let mut chunk = BinaryChunk::default();
    let mut primitive = chunk.surface(mesh);
    primitive["material"] = 0.into();
    chunk.into_glb(json!({
        "asset": {"version": "2.0", "generator": "kinfold"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.8},
            "doubleSided": true, "alphaMode": "OPAQUE"}],
    }))
}

/// The binary chunk of a GLB and what describes it, grown accessor by accessor.
#[derive(Debug, Default)]
pub struct BinaryChunk {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    /// Encoded pictures and their media types.
    images: Vec<(Vec<u8>, &'static str)>,
}

/// Some faces of a surface, and where their corners lie on textures.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a> {
    /// Unit normals of the corners of every face of the surface, object frame.
    pub normals: &'a [[DVec3; 3]],
    /// Which faces, by their index.
    pub faces: &'a [u32],
    /// For each of these, texture coordinates of its corners, v downward; empty without textures.
    pub corners: &'a [[[f32; 2]; 3]],
    /// Whether colours of vertices are written, where the surface has any.
    pub painted: bool,
}

impl BinaryChunk {
    /// Adds a surface, turned y up: a primitive with positions, normals, colours where the mesh has
    /// any, and indices. The material is left to the caller.
    pub fn surface(&mut self, mesh: &Mesh) -> Value {
        let split = shaded(mesh, CREASE_ANGLE);
        let to_file =
            |p: DVec3| FileFrame { up: UpAxis::Y }.point_to_file(p).to_array().map(|c| c as f32);
        let points = split.source.iter().map(|&v| to_file(mesh.vertices()[v as usize])).collect();
        let normals = split.normals.iter().map(|&n| to_file(n)).collect();
        let mut attributes = json!({
            "POSITION": self.positions(points),
            "NORMAL": self.normals(normals),
        });
        if let Some(colours) = mesh.colours() {
            let rows = split.source.iter().map(|&v| colours[v as usize]);
            attributes["COLOR_0"] = self.colours(rows).into();
        }
        json!({"attributes": attributes, "indices": self.indices(&split)})
    }

    /// Adds some faces of a surface, turned y up: a primitive as [`BinaryChunk::surface`] gives it, and with
    /// texture coordinates. Faces that are not there are left out.
    pub fn faces(&mut self, mesh: &Mesh, of: Faces<'_>) -> Value {
        type Corner = (u32, [u64; 3], [u32; 2]);
        let mut known: BTreeMap<Corner, u32> = BTreeMap::new();
        let (mut source, mut normals, mut places) = (Vec::new(), Vec::new(), Vec::new());
        let mut faces = Vec::new();
        for (n, &face) in of.faces.iter().enumerate() {
            let face = face as usize;
            let both = mesh.faces().get(face).zip(of.normals.get(face));
            let Some((vertices, own)) = both else { continue };
            let uv = of.corners.get(n).copied().unwrap_or_default();
            faces.push([0, 1, 2].map(|k| {
                let key =
                    (vertices[k], own[k].to_array().map(f64::to_bits), uv[k].map(f32::to_bits));
                *known.entry(key).or_insert_with(|| {
                    source.push(vertices[k]);
                    normals.push(own[k]);
                    places.push(uv[k]);
                    source.len() as u32 - 1
                })
            }));
        }
        let to_file =
            |p: DVec3| FileFrame { up: UpAxis::Y }.point_to_file(p).to_array().map(|c| c as f32);
        let points = source.iter().map(|&v| to_file(mesh.vertices()[v as usize])).collect();
        let mut attributes = json!({
            "POSITION": self.positions(points),
            "NORMAL": self.normals(normals.iter().map(|&n| to_file(n)).collect()),
        });
        if !of.corners.is_empty() {
            let accessor = json!({"componentType": FLOAT, "type": "VEC2", "count": places.len()});
            attributes["TEXCOORD_0"] = self.add(floats(&places), Some(VERTICES), accessor).into();
        }
        if let Some(colours) = mesh.colours().filter(|_| of.painted) {
            let rows: Vec<_> = source.iter().map(|&v| colours[v as usize]).collect();
            attributes["COLOR_0"] = self.colours(rows.into_iter()).into();
        }
        json!({"attributes": attributes, "indices": self.corners(&faces, source.len())})
    }

    /// Adds an encoded picture; returns the image's index.
    pub fn image(&mut self, bytes: Vec<u8>, media_type: &'static str) -> usize {
        self.images.push((bytes, media_type));
        self.images.len() - 1
    }

    /// Adds the moments of an animation, seconds, ascending; returns the accessor's index.
    pub fn times(&mut self, times: &[f32]) -> usize {
        let bytes = times.iter().flat_map(|t| t.to_le_bytes()).collect();
        let [min, max] = [times.first(), times.last()].map(|t| f64::from(*t.unwrap_or(&0.0)));
        let accessor = json!({"componentType": FLOAT, "type": "SCALAR", "count": times.len(),
            "min": [min], "max": [max]});
        self.add(bytes, None, accessor)
    }

    /// Adds an animation's positions, the file's frame; returns the accessor's index.
    pub fn translations(&mut self, rows: &[[f32; 3]]) -> usize {
        let accessor = json!({"componentType": FLOAT, "type": "VEC3", "count": rows.len()});
        self.add(floats(rows), None, accessor)
    }

    /// Adds an animation's turns, unit quaternions x, y, z, w; returns the accessor's index.
    pub fn rotations(&mut self, rows: &[[f32; 4]]) -> usize {
        let accessor = json!({"componentType": FLOAT, "type": "VEC4", "count": rows.len()});
        self.add(floats(rows), None, accessor)
    }

    /// Adds a view and an accessor over `bytes`; both have the same index.
    fn add(&mut self, bytes: Vec<u8>, target: Option<u32>, mut accessor: Value) -> usize {
        let index = self.views.len();
        let (offset, length) = (self.bytes.len(), bytes.len());
        let mut view = json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        accessor["bufferView"] = index.into();
        self.accessors.push(accessor);
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        index
    }

    fn positions(&mut self, rows: Vec<[f32; 3]>) -> usize {
        let pick = |pick: fn(f32, f32) -> f32, start: f32| {
            let fold = |m: [f32; 3], p: &[f32; 3]| std::array::from_fn(|i| pick(m[i], p[i]));
            rows.iter().fold([start; 3], fold).map(f64::from)
        };
        let (min, max) = (pick(f32::min, f32::INFINITY), pick(f32::max, f32::NEG_INFINITY));
        let accessor = json!({"componentType": FLOAT, "type": "VEC3", "count": rows.len(),
            "min": min, "max": max});
        self.add(floats(&rows), Some(VERTICES), accessor)
    }

    fn normals(&mut self, rows: Vec<[f32; 3]>) -> usize {
        let accessor = json!({"componentType": FLOAT, "type": "VEC3", "count": rows.len()});
        self.add(floats(&rows), Some(VERTICES), accessor)
    }

    fn colours(&mut self, rows: impl ExactSizeIterator<Item = [u8; 4]>) -> usize {
        let count = rows.len();
        let word = |light: f64| (light * 65535.0).round() as u16;
        let linear = |c: u8| word(linear_of_srgb(f64::from(c) / 255.0));
        let words =
            |[r, g, b, a]: [u8; 4]| [linear(r), linear(g), linear(b), word(f64::from(a) / 255.0)];
        let bytes = rows.flat_map(words).flat_map(u16::to_le_bytes).collect();
        let accessor = json!({"componentType": UNSIGNED_SHORT, "type": "VEC4", "count": count,
            "normalized": true});
        self.add(bytes, Some(VERTICES), accessor)
    }

    fn indices(&mut self, split: &Shaded) -> usize {
        let bytes = split.faces.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let count = split.faces.len() * 3;
        let accessor = json!({"componentType": UNSIGNED_INT, "type": "SCALAR", "count": count});
        self.add(bytes, Some(INDICES), accessor)
    }

    /// Indices in two bytes where that is enough.
    fn corners(&mut self, faces: &[[u32; 3]], vertices: usize) -> usize {
        let all = faces.iter().flatten();
        let (kind, bytes): (u32, Vec<u8>) = if vertices <= usize::from(u16::MAX) {
            (UNSIGNED_SHORT, all.flat_map(|v| (*v as u16).to_le_bytes()).collect())
        } else {
            (UNSIGNED_INT, all.flat_map(|v| v.to_le_bytes()).collect())
        };
        let accessor = json!({"componentType": kind, "type": "SCALAR", "count": faces.len() * 3});
        self.add(bytes, Some(INDICES), accessor)
    }

    /// The GLB file: `document` is its JSON without accessors, views, buffers and images.
    pub fn into_glb(mut self, mut document: Value) -> Vec<u8> {
        let mut images = Vec::new();
        for (bytes, media_type) in std::mem::take(&mut self.images) {
            self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
            let view =
                json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
            images.push(json!({"bufferView": self.views.len(), "mimeType": media_type}));
            self.views.push(view);
            self.bytes.extend(bytes);
        }
        if !images.is_empty() {
            document["images"] = images.into();
        }
        document["accessors"] = self.accessors.into();
        document["bufferViews"] = self.views.into();
        document["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        of_chunks(document.to_string().into_bytes(), Some(self.bytes))
    }
}

/// A GLB file of a JSON chunk and a binary one.
pub(crate) fn of_chunks(mut json: Vec<u8>, bin: Option<Vec<u8>>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let bin = bin.map(|mut bin| {
        bin.resize(bin.len().next_multiple_of(4), 0);
        (b"BIN\0", bin)
    });
    let chunks = || std::iter::once((b"JSON", &json)).chain(bin.iter().map(|(k, b)| (*k, b)));
    let length = 12 + chunks().map(|(_, chunk)| 8 + chunk.len()).sum::<usize>();
    let mut glb = Vec::with_capacity(length);
    glb.extend(b"glTF");
    [2, length as u32].iter().for_each(|word| glb.extend(word.to_le_bytes()));
    for (kind, chunk) in chunks() {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}

fn floats<const N: usize>(rows: &[[f32; N]]) -> Vec<u8> {
    rows.iter().flatten().flat_map(|c| c.to_le_bytes()).collect()
}
