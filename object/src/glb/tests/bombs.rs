//! Small files that would take much memory or time.

use super::*;
use crate::glb::decoding::within;
use std::time::Duration;

/// A few hundred bytes that name millions of vertices, none of them in the file.
#[test]
fn a_small_file_does_not_unpack_to_hundreds_of_megabytes() {
    for (count, shape) in [(2_000_000, "VEC3"), (130_000_000, "VEC4"), (4_000_000_000_u64, "VEC2")]
    {
        let mut file = File::new();
        let entry = json!({"componentType": 5126, "type": shape, "count": count});
        let left_out = file.push("accessors", entry);
        let position = file.floats(&TETRAHEDRON);
        let attributes = match shape {
            "VEC3" => json!({"POSITION": left_out}),
            "VEC4" => json!({"POSITION": position, "COLOR_0": left_out}),
            _ => json!({"POSITION": position, "TEXCOORD_0": left_out}),
        };
        let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
        file.push("materials", material);
        let glb = file.scene(
            json!([{"attributes": attributes, "material": 0, "mode": 5}]),
            json!([{"mesh": 0}]),
        );
        let error = error_of(&glb);
        let rule = match shape {
            "VEC3" => "a mesh may unpack to 16 MiB and 2000 times its file",
            _ => "attributes have one entry per vertex",
        };
        assert!(error.contains(rule), "{error}");
    }
}

#[test]
fn a_meshopt_view_does_not_unpack_to_thousands_of_times_the_file() {
    let mut file = File::new();
    file.view([0; 16]);
    let packed = json!({"buffer": 0, "byteLength": 16, "byteStride": 16, "count": 30_000_000,
                        "mode": "ATTRIBUTES"});
    file.json["bufferViews"][0]["byteLength"] = json!(480_000_000);
    file.json["bufferViews"][0]["extensions"] = json!({"EXT_meshopt_compression": packed});
    let error = error_of(&file.scene(json!([]), json!([{}])));
    assert!(error.contains("16 MiB and 2000 times the file"), "{error}");
}

#[test]
fn primitives_without_a_triangle_are_not_placed_without_end() {
    let mut file = File::new();
    let position =
        file.push("accessors", json!({"componentType": 5126, "type": "VEC3", "count": 0}));
    let primitives = vec![json!({"attributes": {"POSITION": position}}); 2_000];
    let children: Vec<usize> = (1..1_001).collect();
    let mut nodes = vec![json!({"children": children})];
    nodes.resize(1_001, json!({"mesh": 0}));
    let error = error_of(&file.scene(json!(primitives), json!(nodes)));
    assert!(error.contains("nodes may place 1,000,000 primitives"), "{error}");
}

/// Each primitive names the same stream, which decodes to its first words and then a lot of nothing.
#[test]
fn one_compressed_stream_is_not_decoded_once_for_each_of_thousands_of_primitives() {
    let mut file = File::new();
    let padded = [DRACO.to_vec(), vec![0; 40_000]].concat();
    let stream = file.view(padded);
    let position =
        file.push("accessors", json!({"componentType": 5126, "type": "VEC3", "count": 4}));
    let indices =
        file.push("accessors", json!({"componentType": 5121, "type": "SCALAR", "count": 12}));
    let packed = json!({"bufferView": stream, "attributes": {"POSITION": 0}});
    let primitive = json!({"attributes": {"POSITION": position}, "indices": indices,
                           "extensions": {"KHR_draco_mesh_compression": packed}});
    let few = vec![primitive.clone(); 3];
    let many = vec![primitive; 1_000];
    let copy = |file: &File| File { json: file.json.clone(), bin: file.bin.clone() };
    let place = || json!([{"mesh": 0}]);
    let spent = "compressed primitives may add up to 16 times the file";
    assert!(!error_or_none(&copy(&file).scene(json!(few), place())).contains(spent));
    let error = error_of(&file.scene(json!(many), place()));
    assert!(error.contains(spent), "{error}");
}

fn error_or_none(glb: &[u8]) -> String {
    read(glb).err().map_or_else(String::new, |e| e.to_string())
}

#[test]
fn a_decoder_that_does_not_end_is_given_up() {
    let (hold, held) = std::sync::mpsc::channel::<()>();
    let endless = move || held.recv().map_err(|e| e.to_string());
    let soon = Duration::from_millis(50);
    let error = within("mesh 0 primitive 0", "Draco", soon, endless).unwrap_err().to_string();
    assert!(error.ends_with("does not decode: it takes longer than the 0.05 s it may"), "{error}");
    drop(hold);
    let quick = within("here", "Draco", Duration::from_secs(60), || Ok::<_, String>(7));
    assert_eq!(quick, Ok(7));
    let broken = || -> Result<(), String> { panic!("as decoders do") };
    let error = within("here", "Draco", Duration::from_secs(60), broken).unwrap_err().to_string();
    assert!(error.contains("the decoder gave up"), "{error}");
}
