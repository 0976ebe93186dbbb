//! The reader against files made here, real files beside the project, and hostile bytes.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};

use super::*;
use crate::mesh::{Bounds, FileFrame, MeshError, UpAxis};
use glamx::DVec3;

mod bombs;
mod look;

/// A tetrahedron's Draco stream, without quantisation.
const DRACO: [u8; 82] = [
    68, 82, 65, 67, 79, 2, 2, 1, 1, 0, 0, 0, 4, 4, 0, 3, 0, 0, 1, 47, 1, 1, 16, 1, 255, 0, 0, 1, 0,
    9, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63, 0, 0, 0, 0, 0, 0, 128, 63, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63, 0, 0, 0, 0, 0, 0, 0, 0,
];
const TETRAHEDRON: [[f32; 3]; 4] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// A file under construction: JSON, and a binary chunk that grows view by view.
struct File {
    json: Value,
    bin: Vec<u8>,
}

impl File {
    fn new() -> Self {
        let json = json!({"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []});
        Self { json, bin: Vec::new() }
    }

    fn view(&mut self, bytes: impl IntoIterator<Item = u8>) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend(bytes);
        let length = self.bin.len() - offset;
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": length}))
    }

    fn push(&mut self, list: &str, entry: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(entry);
        list.len() - 1
    }

    fn accessor(&mut self, view: usize, kind: u32, shape: &str, count: usize) -> usize {
        let entry =
            json!({"bufferView": view, "componentType": kind, "type": shape, "count": count});
        self.push("accessors", entry)
    }

    fn floats(&mut self, rows: &[impl AsRef<[f32]>]) -> usize {
        let shape = ["SCALAR", "VEC2", "VEC3", "VEC4"][rows[0].as_ref().len() - 1];
        let bytes: Vec<u8> =
            rows.iter().flat_map(|r| r.as_ref().to_vec()).flat_map(f32::to_le_bytes).collect();
        let view = self.view(bytes);
        self.accessor(view, 5126, shape, rows.len())
    }

    fn bytes(&mut self, indices: &[u8]) -> usize {
        let view = self.view(indices.to_vec());
        self.accessor(view, 5121, "SCALAR", indices.len())
    }

    /// One mesh of the given primitives, placed by the given nodes; node 0 is the root.
    fn scene(mut self, primitives: Value, nodes: Value) -> Vec<u8> {
        self.json["meshes"] = json!([{ "primitives": primitives }]);
        self.json["nodes"] = nodes;
        self.json["scenes"] = json!([{"nodes": [0]}]);
        self.glb()
    }

    fn glb(mut self) -> Vec<u8> {
        if self.json["buffers"].is_null() {
            self.json["buffers"] = json!([{"byteLength": self.bin.len()}]);
        }
        pack(self.json.to_string().into_bytes(), self.bin)
    }
}

fn pack(mut json: Vec<u8>, mut bin: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend(((28 + json.len() + bin.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", bin)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}

fn tetrahedron_with(nodes: Value) -> Vec<u8> {
    let mut file = File::new();
    let position = file.floats(&TETRAHEDRON);
    let indices =
        file.bytes(FACES.as_flattened().iter().map(|&i| i as u8).collect::<Vec<_>>().as_slice());
    file.scene(json!([{"attributes": {"POSITION": position}, "indices": indices}]), nodes)
}

fn draco() -> Vec<u8> {
    let mut file = File::new();
    let view = file.view(DRACO);
    let entry = |shape: &str, kind: u32, count: u32| json!({"componentType": kind, "type": shape, "count": count});
    let position = file.push("accessors", entry("VEC3", 5126, 4));
    let indices = file.push("accessors", entry("SCALAR", 5121, 12));
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    let extension = json!({"bufferView": view, "attributes": {"POSITION": 0}});
    let primitive = json!({"attributes": {"POSITION": position}, "indices": indices,
        "extensions": {"KHR_draco_mesh_compression": extension}});
    file.scene(json!([primitive]), json!([{"mesh": 0}]))
}

/// A meshopt vertex stream (version 0) of up to 16 elements: every byte plane stored as literal
/// differences.
fn meshopt_stream(elements: &[[u8; 4]]) -> Vec<u8> {
    let mut stream = vec![0xA0];
    for plane in 0..4 {
        let mut last = elements[0][plane];
        let mut deltas: Vec<u8> = Vec::new();
        for e in elements {
            let delta = e[plane].wrapping_sub(last) as i8;
            deltas.push(((delta << 1) ^ (delta >> 7)) as u8);
            last = e[plane];
        }
        deltas.resize(16, 0);
        stream.push(0x03);
        stream.extend(deltas);
    }
    stream.resize(stream.len() + 28, 0);
    stream.extend(elements[0]);
    stream
}

/// A meshopt-packed, quantised tetrahedron: bytes 0…127 normalised, brought back by the node.
fn meshopt() -> Vec<u8> {
    let mut file = File::new();
    let rows = TETRAHEDRON.map(|p| [p[0], p[1], p[2], 0.0].map(|c| (c * 127.0) as u8));
    let stream = meshopt_stream(&rows);
    let packed = json!({"buffer": 0, "byteOffset": 0, "byteLength": stream.len(), "byteStride": 4,
        "mode": "ATTRIBUTES", "count": 4});
    let view = file.view(stream);
    file.json["bufferViews"][view] = json!({"buffer": 1, "byteLength": 16, "byteStride": 4,
        "extensions": {"EXT_meshopt_compression": packed}});
    let position = file.accessor(view, 5120, "VEC3", 4);
    file.json["accessors"][position]["normalized"] = true.into();
    let indices = file.bytes(&[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
    let fallback = json!({"EXT_meshopt_compression": {"fallback": true}});
    file.json["buffers"] =
        json!([{"byteLength": file.bin.len()}, {"byteLength": 16, "extensions": fallback}]);
    file.json["extensionsRequired"] = json!(["EXT_meshopt_compression", "KHR_mesh_quantization"]);
    let primitive = json!({"attributes": {"POSITION": position}, "indices": indices});
    file.scene(json!([primitive]), json!([{"mesh": 0, "scale": [2, 2, 2]}]))
}

/// A square with a two-texel PNG (red left, green right), half as bright by its factor.
fn textured() -> Vec<u8> {
    let mut file = File::new();
    let position =
        file.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let coordinate = file.floats(&[[0.25, 0.5], [0.75, 0.5], [1.75, 0.5], [0.25, 0.5]]);
    let indices = file.bytes(&[0, 1, 2, 0, 2, 3]);
    let mut png = std::io::Cursor::new(Vec::new());
    let texels = image::RgbaImage::from_vec(2, 1, vec![255, 0, 0, 255, 0, 255, 0, 255]).unwrap();
    texels.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let view = file.view(png.into_inner());
    file.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    file.json["textures"] = json!([{"source": 0}]);
    file.json["materials"] = json!([{"pbrMetallicRoughness":
        {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 0.5, 0.5, 1.0]}}]);
    let attributes = json!({"POSITION": position, "TEXCOORD_0": coordinate});
    let primitive = json!({"attributes": attributes, "indices": indices, "material": 0});
    file.scene(json!([primitive]), json!([{"mesh": 0}]))
}

/// A sparse accessor over nothing: all corners at the origin but two.
fn sparse() -> Vec<u8> {
    let mut file = File::new();
    let indices = file.view([1, 2]);
    let values = file.view([1f32, 0.0, 0.0, 0.0, 1.0, 0.0].into_iter().flat_map(f32::to_le_bytes));
    let accessor = json!({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": {"count": 2,
        "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values}}});
    let position = file.push("accessors", accessor);
    file.scene(json!([{"attributes": {"POSITION": position}}]), json!([{"mesh": 0}]))
}

fn upright(p: [f32; 3]) -> DVec3 {
    FileFrame { up: UpAxis::Y }.point_to_object(DVec3::from_array(p.map(f64::from)))
}

fn error_of(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

/// The JSON of a plain tetrahedron, changed by `change`, as a file.
fn changed(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let glb = tetrahedron_with(json!([{"mesh": 0}]));
    let container = container::Container::parse(&glb).unwrap();
    let mut json: Value = serde_json::from_slice(container.json).unwrap();
    change(&mut json);
    pack(json.to_string().into_bytes(), container.bin.unwrap().to_vec())
}

#[test]
fn a_tetrahedron_is_turned_upright_exactly_and_keeps_its_face_order() {
    let mesh = read(&tetrahedron_with(json!([{"mesh": 0}]))).unwrap();
    assert_eq!(mesh.vertices(), TETRAHEDRON.map(upright));
    assert_eq!(mesh.faces(), FACES);
    assert_eq!(mesh.colours(), None);
    assert_eq!(mesh.frame().up, UpAxis::Y);
    assert!((mesh.signed_volume() - 1.0 / 6.0).abs() < 1e-15);
}

#[test]
fn draco_meshopt_and_plain_files_hold_the_same_surface() {
    let plain = read(&tetrahedron_with(json!([{"mesh": 0}]))).unwrap();
    let unpacked = read(&draco()).unwrap();
    assert_eq!(unpacked.bounds(), plain.bounds());
    assert_eq!(unpacked.faces().len(), 4);
    assert!((unpacked.signed_volume() - 1.0 / 6.0).abs() < 1e-15);
    let quantised = read(&meshopt()).unwrap();
    assert_eq!(quantised.faces(), FACES);
    assert_eq!(quantised.vertices(), TETRAHEDRON.map(|p| upright(p) * 2.0));
}

#[test]
fn nested_nodes_move_turn_and_mirror_and_the_surface_still_faces_outward() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let matrix = [-2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1];
    let nodes = json!([
        {"children": [1, 2], "translation": [0, 3, 0], "rotation": [0.0, half, 0.0, half]},
        {"mesh": 0, "matrix": matrix},
        {"mesh": 0, "scale": [1, 1, -1]}
    ]);
    let mesh = read(&tetrahedron_with(nodes)).unwrap();
    assert_eq!(mesh.faces().len(), 8);
    assert!((mesh.signed_volume() - (2.0 + 1.0) / 6.0).abs() < 1e-12);
    // A quarter turn about y takes x to −z: glTF (1,0,0) → (3,0,0) → (0,3,−3) → object (0,3,3).
    assert!((mesh.vertices()[1] - DVec3::new(0.0, 3.0, 3.0)).length() < 1e-12);
    assert_eq!(mesh.faces()[0], [0, 1, 2], "mirrored: wound the other way");
}

#[test]
fn strips_fans_and_lists_follow_each_other_in_file_order() {
    let mut file = File::new();
    let position =
        file.floats(&[[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    let strip = file.bytes(&[0, 1, 2, 3]);
    let degenerate = file.bytes(&[0, 0, 1, 0, 1, 2]);
    let attributes = json!({"POSITION": position});
    let primitives = json!([
        {"attributes": attributes, "indices": strip, "mode": 5},
        {"attributes": attributes, "mode": 6},
        {"attributes": attributes, "indices": strip, "mode": 1},
        {"attributes": attributes, "indices": degenerate}
    ]);
    let reading = read_noted(&file.scene(primitives, json!([{"mesh": 0}]))).unwrap();
    let (strip, fan) = ([[0, 1, 2], [1, 3, 2]], [[5, 6, 4], [6, 7, 4]]);
    let list = [[8, 8, 9], [8, 9, 10]];
    assert_eq!(reading.mesh.faces(), [strip, fan, list].concat());
    assert_eq!(reading.notes, ["mesh 0 primitive 2: points and lines have no surface"]);
}

#[test]
fn sparse_entries_replace_zeros() {
    let mesh = read(&sparse()).unwrap();
    let expected = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(upright);
    assert_eq!(mesh.vertices(), expected);
}

#[test]
fn colour_is_vertex_colour_times_factor_times_texture_in_linear_light() {
    let mesh = read(&textured()).unwrap();
    // sRGB of linear 0.5 is 188; u = 1.75 repeats to 0.75.
    let (red, green) = ([188, 0, 0, 255], [0, 188, 0, 255]);
    assert_eq!(mesh.colours().unwrap(), [red, green, green, red]);
}

#[test]
fn a_texture_that_cannot_be_decoded_leaves_the_factor() {
    let mut glb = textured();
    let at = glb.windows(4).position(|w| w == b"\x89PNG").unwrap();
    glb[at..at + 4].copy_from_slice(b"XPNG");
    let reading = read_noted(&glb).unwrap();
    assert_eq!(reading.mesh.colours().unwrap(), [[188, 188, 188, 255]; 4]);
    assert!(reading.notes[0].starts_with("colours go without a texture"), "{:?}", reading.notes);
}

/// The checksum of PNG chunks, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 };
    let fold = |crc: u32, &byte: &u8| (0..8).fold(crc ^ u32::from(byte), step);
    !bytes.iter().fold(u32::MAX, fold)
}

#[test]
fn an_image_too_large_is_refused_from_its_header() {
    let mut glb = textured();
    let at = glb.windows(4).position(|w| w == b"IHDR").unwrap();
    glb[at + 4..at + 8].copy_from_slice(&8193u32.to_be_bytes());
    let checksum = crc32(&glb[at..at + 17]);
    glb[at + 17..at + 21].copy_from_slice(&checksum.to_be_bytes());
    let expected = "GLB: image 0: an image has at most 8192 a side, found 8193 × 1";
    assert_eq!(error_of(&glb), expected);
}

#[test]
fn what_is_written_reads_back_with_its_colours() {
    let colours =
        vec![[0, 1, 2, 255], [50, 100, 200, 255], [255, 254, 253, 255], [7, 77, 177, 255]];
    let mesh = read(&tetrahedron_with(json!([{"mesh": 0}]))).unwrap();
    let mesh = mesh.with_colours(Some(colours.clone())).unwrap();
    let bytes = write(&mesh);
    let back = read(&bytes).unwrap();
    assert_eq!(back.vertices().len(), 12, "every corner of a tetrahedron is a crease");
    let corners = |m: &Mesh| (0..4).map(|f| m.corners(f)).collect::<Vec<_>>();
    assert_eq!(corners(&back), corners(&mesh));
    let of = |f: usize, c: usize| back.colours().unwrap()[back.faces()[f][c] as usize];
    assert_eq!(of(3, 1), colours[2]);
    assert_eq!(bytes, write(&mesh), "the same bytes for the same mesh");
    assert_eq!(write(&back), write(&read(&write(&back)).unwrap()));
}

#[test]
fn containers_that_lie_are_refused_with_the_rule_and_the_finding() {
    let good = tetrahedron_with(json!([{"mesh": 0}]));
    assert_eq!(error_of(b""), "GLB: the header takes 12 bytes, found 0 bytes");
    assert!(error_of(b"solid stl file").starts_with("GLB: the file must start with `glTF`"));
    let mut version = good.clone();
    version[4] = 1;
    assert_eq!(error_of(&version), "GLB: the version must be 2, found 1");
    let length = good.len();
    let expected = format!(
        "GLB: the declared length must be the file's, found {length} declared, {} present",
        length - 4
    );
    assert_eq!(error_of(&good[..length - 4]), expected);
    let mut chunk = good.clone();
    chunk[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(error_of(&chunk).contains("multiple of 4"));
    chunk[12..16].copy_from_slice(&(u32::MAX - 3).to_le_bytes());
    assert!(error_of(&chunk).contains("a chunk must end inside the file"));
}

#[test]
fn json_that_nests_too_deep_or_is_not_gltf_is_refused() {
    let deep = format!("{}{}", "[".repeat(65), "]".repeat(65));
    assert_eq!(
        error_of(&pack(deep.into_bytes(), vec![])),
        "GLB: JSON may nest at most 64 deep, found more at byte 64"
    );
    let hidden = json!({"asset": {"version": "2.0", "generator": "[".repeat(99) + "\"{"}});
    let error = read(&pack(hidden.to_string().into_bytes(), vec![])).unwrap_err();
    assert_eq!(error, GlbError::Mesh(MeshError::Empty), "brackets in a string do not nest");
    assert!(error_of(&pack(b"{}".to_vec(), vec![])).contains("missing field `asset`"));
    let many = json!({"asset": {"version": "2.0"}, "nodes": vec![json!({}); 10_001]});
    let error = error_of(&pack(many.to_string().into_bytes(), vec![]));
    assert!(error.contains("a list of at most 10000 entries, found more"), "{error}");
    let huge = vec![b' '; MAX_JSON + 4];
    assert!(error_of(&pack(huge, vec![])).contains("at most 16 MiB"));
}

#[test]
fn every_broken_reference_and_range_is_named() {
    type Change = fn(&mut Value);
    let cases: [(Change, &str); 14] = [
        (|j| j["extensionsRequired"] = json!(["EXT_magic"]), "`EXT_magic`, which kinfold does not"),
        (|j| j["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]), "EXT_mesh_gpu_instancing"),
        (|j| j["buffers"][0]["uri"] = json!("file:///etc/x"), "found the URI `file:///etc/x`"),
        (|j| j["images"] = json!([{"uri": "a.png"}]), "found the URI `a.png`"),
        (|j| j["buffers"][0]["byteLength"] = json!(4000), "4000 declared, 60 present"),
        (|j| j["bufferViews"][0]["byteLength"] = json!(61), "its range must lie inside its buffer"),
        (|j| j["accessors"][0]["count"] = json!(5), "its elements must lie inside its view"),
        (|j| j["accessors"][0]["count"] = json!(5_000_001), "5,000,000 vertices"),
        (|j| j["accessors"][0]["byteOffset"] = json!(u64::MAX), "its elements must lie inside"),
        (|j| j["accessors"][1]["componentType"] = json!(5120), "indices must be u8, u16 or u32"),
        (|j| j["nodes"][0]["mesh"] = json!(7), "node 0 uses mesh 7, but the file has 1"),
        (|j| j["scene"] = json!(3), "scene uses scene 3, but the file has 1"),
        (|j| j["meshes"][0]["primitives"][0]["attributes"] = json!({}), "needs POSITION"),
        (|j| j["asset"]["version"] = json!("1.0"), "the glTF version must be 2.x, found `1.0`"),
    ];
    for (change, expected) in cases {
        let error = error_of(&changed(change));
        assert!(error.contains(expected), "expected {expected:?} in {error:?}");
    }
}

#[test]
fn node_graphs_must_be_shallow_trees() {
    let chain = |n: usize| (0..n).map(|i| json!({"children": [i + 1]})).collect::<Vec<_>>();
    let ended = |n: usize| [chain(n), vec![json!({"mesh": 0})]].concat();
    assert!(read(&tetrahedron_with(json!(ended(63)))).is_ok());
    assert!(error_of(&tetrahedron_with(json!(ended(64)))).contains("at most 64 deep, found 65"));
    let cycle = json!([{"mesh": 0}, {"children": [2]}, {"children": [1]}]);
    assert!(error_of(&tetrahedron_with(cycle)).contains("found a cycle"));
    let diamond = json!([{"children": [1, 2]}, {"children": [2]}, {"mesh": 0}]);
    assert!(error_of(&tetrahedron_with(diamond)).contains("a node has one parent at most"));
}

#[test]
fn many_instances_of_one_mesh_stay_within_the_limits() {
    let mut file = File::new();
    let position =
        file.push("accessors", json!({"componentType": 5126, "type": "VEC3", "count": 600_000}));
    // A smaller file may not unpack to that much in the first place.
    file.view(vec![0; 100_000]);
    let children: Vec<usize> = (1..=9).collect();
    let mut nodes = vec![json!({"children": children})];
    nodes.resize(10, json!({"mesh": 0}));
    let error =
        error_of(&file.scene(json!([{"attributes": {"POSITION": position}}]), json!(nodes)));
    assert!(
        error.contains("a mesh may have 5,000,000 vertices, found 600000 where 200000"),
        "{error}"
    );
}

#[test]
fn indices_past_the_end_and_coordinates_that_are_not_finite_are_refused() {
    let glb = tetrahedron_with(json!([{"mesh": 0}]));
    let bin = glb.len() - 60;
    let mut index = glb.clone();
    index[bin + 48 + 5] = 4;
    let expected =
        "GLB: mesh 0 primitive 0: an index must name a vertex, found index 4 at 5 for 4 vertices";
    assert_eq!(error_of(&index), expected);
    let mut nan = glb;
    nan[bin + 4..bin + 8].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(error_of(&nan).contains("positions must be finite, found vertex 0"));
}

#[test]
fn a_draco_stream_that_promises_more_than_the_limits_is_not_unpacked() {
    let mut glb = draco();
    let at = glb.windows(5).position(|w| w == b"DRACO").unwrap();
    let cut = glb.len() - 30;
    glb[at + 12] = 0xFF;
    assert!(read(&glb).is_err());
    glb[cut..].fill(0xFF);
    assert!(read(&glb).is_err());
}

/// One hostile variant of a file: some bytes changed, perhaps cut short with honest lengths.
fn mutate(rng: &mut Pcg64Mcg, glb: &[u8]) -> Vec<u8> {
    let json_end = 20 + u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let mut bytes = glb.to_vec();
    for _ in 0..rng.random_range(1..6) {
        let at = rng.random_range(0..bytes.len());
        bytes[at] = match rng.random_range(0..4) {
            0 => rng.random(),
            1 => 0xFF,
            2 if (20..json_end).contains(&at) => b'0' + rng.random_range(0..10u8),
            _ => bytes[at] ^ (1 << rng.random_range(0..8)),
        };
    }
    if rng.random_range(0..4) == 0 {
        let bin = &bytes[json_end + 8..];
        let kept = bin[..rng.random_range(0..bin.len())].to_vec();
        bytes = pack(bytes[20..json_end].to_vec(), kept);
    }
    bytes
}

#[test]
fn thousands_of_hostile_files_never_panic() {
    let colours = vec![[9, 8, 7, 255]; 4];
    let plain = read(&tetrahedron_with(json!([{"mesh": 0}]))).unwrap();
    let written = write(&plain.with_colours(Some(colours)).unwrap());
    let mut rng = Pcg64Mcg::seed_from_u64(20_260_101);
    let (mut read_fine, mut refused) = (0, 0);
    for glb in [written, draco(), meshopt(), textured(), sparse()] {
        assert!(read(&glb).is_ok());
        for _ in 0..1200 {
            match read(&mutate(&mut rng, &glb)) {
                Ok(mesh) => {
                    assert!(mesh.vertices().iter().all(|v| v.is_finite()));
                    read_fine += 1;
                }
                Err(error) => {
                    assert!(!error.to_string().is_empty());
                    refused += 1;
                }
            }
        }
        for length in 0..glb.len() {
            assert!(read(&glb[..length]).is_err());
        }
    }
    assert!(read_fine > 100 && refused > 1000, "{read_fine} read, {refused} refused");
}

/// The data beside the project, or none with a loud line.
fn shared(name: &str) -> Option<Vec<u8>> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared");
    let root = std::env::var("KINFOLD_SHARED").unwrap_or_else(|_| beside.into());
    let path = std::path::Path::new(&root).join("data").join(name);
    let bytes = std::fs::read(&path).ok();
    if bytes.is_none() {
        eprintln!("SKIPPED: {} is absent; set KINFOLD_SHARED", path.display());
    }
    bytes
}

fn largest_difference(a: Bounds, b: Bounds) -> f64 {
    (a.min - b.min).abs().max_element().max((a.max - b.max).abs().max_element())
}

#[test]
fn one_generator_mesh_in_four_encodings_has_one_box() {
    let Some(plain) = shared("glb/hunyuan3d2_plain.glb") else { return };
    let plain = read(&plain).unwrap();
    assert_eq!((plain.vertices().len(), plain.faces().len()), (19_996, 40_000));
    let corner = |x, y, z| FileFrame { up: UpAxis::Y }.point_to_object(DVec3::new(x, y, z));
    let (a, b) = (corner(-0.36684, -0.54217, -0.30135), corner(0.36671, 0.54151, 0.29146));
    let known = Bounds { min: a.min(b), max: a.max(b) };
    assert!(largest_difference(plain.bounds(), known) < 5e-6);
    for (name, tolerance) in [("draco", 1e-4), ("meshopt", 4e-5), ("quantized", 4e-5)] {
        let Some(bytes) = shared(&format!("glb/hunyuan3d2_{name}.glb")) else { return };
        let mesh = read(&bytes).unwrap();
        assert_eq!(mesh.faces().len(), 40_000, "{name}");
        let off = largest_difference(mesh.bounds(), plain.bounds());
        assert!(off < tolerance, "{name}: {off}");
        let volume = mesh.signed_volume() / plain.signed_volume();
        assert!((volume - 1.0).abs() < 1e-3, "{name}: {volume}");
    }
}

#[test]
fn a_textured_generator_mesh_has_its_colours_baked() {
    let Some(bytes) = shared("glb/embodiedgen_basket.glb") else { return };
    let mesh = read(&bytes).unwrap();
    assert_eq!((mesh.vertices().len(), mesh.faces().len()), (11_685, 17_266));
    let colours = mesh.colours().unwrap();
    assert!(colours.iter().any(|c| c != &colours[0]));
}

#[test]
fn a_real_case_has_as_many_faces_as_its_truth_says() {
    let case = "cases/dev/articraft__drawer_cabinet_with_sliding_drawers_0847";
    let (Some(glb), Some(truth)) =
        (shared(&format!("{case}/mesh.glb")), shared(&format!("{case}/truth.json")))
    else {
        return;
    };
    let truth: Value = serde_json::from_slice(&truth).unwrap();
    let mesh = read(&glb).unwrap();
    assert_eq!(mesh.faces().len() as u64, truth["mesh"]["n_faces"].as_u64().unwrap());
    assert_eq!(mesh.vertices().len() as u64, truth["mesh"]["n_vertices"].as_u64().unwrap());
}
