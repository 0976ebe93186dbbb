//! Materials, pictures and coordinates of files made here.

use super::*;
use crate::appearance::{AlphaMode, Pixels, Wrap};

const CORNERS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [0.25, 0.5], [0.0, 1.0]];

/// A tetrahedron of four vertices with coordinates, materials and one picture.
fn textured(materials: Value, more: impl FnOnce(&mut File, &mut Value)) -> Vec<u8> {
    let mut file = File::new();
    let position = file.floats(&TETRAHEDRON);
    let uv = file.floats(&CORNERS);
    let indices =
        file.bytes(FACES.as_flattened().iter().map(|&i| i as u8).collect::<Vec<_>>().as_slice());
    let view = file.view(Pixels::filled(4, 2, [200, 100, 50, 255]).png().unwrap());
    file.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    file.push("samplers", json!({"wrapS": 33071, "wrapT": 33648}));
    file.push("textures", json!({"source": 0, "sampler": 0}));
    file.json["materials"] = materials;
    let mut primitive = json!({"attributes": {"POSITION": position, "TEXCOORD_0": uv},
        "indices": indices, "material": 0});
    more(&mut file, &mut primitive);
    file.scene(json!([primitive]), json!([{"mesh": 0, "scale": [1, 1, -1]}]))
}

fn base(info: Value) -> Value {
    json!([{"name": "wood", "pbrMetallicRoughness":
        {"baseColorTexture": info, "baseColorFactor": [1, 0.5, 0.25, 1], "metallicFactor": 0}}])
}

#[test]
fn a_textured_file_keeps_its_material_picture_and_coordinates() {
    let bytes = textured(base(json!({"index": 0})), |_, _| {});
    let reading = read_noted(&bytes).unwrap();
    assert_eq!(reading.notes, [""; 0]);
    let look = reading.appearance.unwrap();
    assert_eq!(look.pictures()[0].size(), [4, 2]);
    let (wood, corners) = look.of_face(0).unwrap();
    assert_eq!((wood.name.as_str(), wood.base_colour), ("wood", [1.0, 0.5, 0.25, 1.0]));
    assert_eq!((wood.metallic, wood.roughness, wood.alpha), (0.0, 1.0, AlphaMode::Opaque));
    assert_eq!(wood.base_texture.unwrap().wrap, [Wrap::Clamp, Wrap::Mirror]);
    // Mirrored in place: the face is turned round, and its coordinates with it.
    assert_eq!(FACES[0], [0, 2, 1]);
    assert_eq!(corners, [CORNERS[0], CORNERS[1], CORNERS[2]]);
}

#[test]
fn the_mesh_of_a_textured_file_is_the_same_with_and_without_its_looks() {
    let bytes = textured(base(json!({"index": 0})), |_, _| {});
    assert_eq!(read(&bytes).unwrap(), read_noted(&bytes).unwrap().mesh);
}

#[test]
fn a_texture_transform_is_done_to_the_coordinates() {
    let transform = json!({"offset": [0.5, 0.25], "scale": [2, 3]});
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
    let look = read_noted(&textured(base(info), |_, _| {})).unwrap().appearance.unwrap();
    assert_eq!(look.faces()[0].corners, [[0.5, 0.25], [2.5, 0.25], [1.0, 1.75]]);
}

#[test]
fn every_map_and_factor_comes_along() {
    let texture = json!({"index": 0});
    let all = json!([{"pbrMetallicRoughness": {"baseColorTexture": texture,
            "metallicRoughnessTexture": texture, "metallicFactor": 0.5, "roughnessFactor": 0.25},
        "normalTexture": {"index": 0, "scale": 0.5}, "emissiveTexture": texture,
        "emissiveFactor": [1, 0, 0.5], "alphaMode": "MASK", "doubleSided": true,
        "occlusionTexture": texture,
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2},
            "KHR_materials_clearcoat": {}}}]);
    let reading = read_noted(&textured(all, |_, _| {})).unwrap();
    let look = reading.appearance.unwrap();
    let material = &look.materials()[0];
    assert!(material.textures().iter().all(Option::is_some));
    assert_eq!((material.metallic, material.roughness, material.normal_scale), (0.5, 0.25, 0.5));
    assert_eq!((material.emissive, material.alpha), ([2.0, 0.0, 1.0], AlphaMode::Mask(0.5)));
    assert!(material.double_sided);
    let due = [
        "material 0: its occlusion texture is left out",
        "material 0: `KHR_materials_clearcoat` is left out",
    ];
    assert_eq!(reading.notes, due);
}

#[test]
fn a_basis_or_avif_texture_is_a_loss_and_no_refusal() {
    for (extension, kind) in [("KHR_texture_basisu", "Basis"), ("EXT_texture_avif", "AVIF")] {
        let bytes = textured(base(json!({"index": 0})), |file, _| {
            let view = file.view(*b"no picture of ours");
            file.json["images"][0]["bufferView"] = view.into();
            file.json["textures"][0] = json!({"extensions": {extension: {"source": 0}}});
            file.json["extensionsRequired"] = json!([extension]);
        });
        let reading = read_noted(&bytes).unwrap();
        assert!(reading.notes.iter().any(|n| n.contains(kind)), "{:?}", reading.notes);
        assert!(!reading.appearance.unwrap().materials()[0].is_textured());
    }
}

#[test]
fn colours_of_vertices_stay_with_the_mesh_unless_a_texture_lies_over_them() {
    let colours = [[1.0f32, 0.0, 0.0, 1.0]; 4];
    let bytes = textured(json!([{}]), |file, primitive| {
        primitive["attributes"]["COLOR_0"] = file.floats(&colours).into();
    });
    let reading = read_noted(&bytes).unwrap();
    assert!(reading.appearance.is_none());
    assert_eq!(reading.mesh.colours().unwrap()[0], [255, 0, 0, 255]);
    let bytes = textured(base(json!({"index": 0})), |file, primitive| {
        primitive["attributes"]["COLOR_0"] = file.floats(&colours).into();
    });
    let reading = read_noted(&bytes).unwrap();
    let material = &reading.appearance.as_ref().unwrap().of_face(0).unwrap().0;
    assert_eq!((material.base_colour, material.name.as_str()), ([1.0, 0.0, 0.0, 1.0], "wood"));
    assert_eq!(reading.notes, [""; 0]);
}

#[test]
fn colours_of_vertices_over_a_texture_multiply_it_texel_by_texel() {
    let colours = CORNERS.map(|[u, _]| [1.0, u, 1.0, 1.0]);
    let bytes = textured(base(json!({"index": 0})), |file, primitive| {
        primitive["attributes"]["COLOR_0"] = file.floats(&colours).into();
    });
    let Reading { appearance, notes, .. } = read_noted(&bytes).unwrap();
    let look = appearance.unwrap();
    assert_eq!(notes, [""; 0]);
    let texture = look.of_face(0).unwrap().0.base_texture.unwrap();
    assert_eq!((texture.picture, texture.wrap), (1, [Wrap::Clamp, Wrap::Mirror]));
    let pixels = look.pictures()[1].pixels().unwrap();
    let green = |u: f64| (srgb_of_linear(linear_of_srgb(100.0 / 255.0) * u) * 255.0).round() as u8;
    assert_eq!(pixels.at(2, 0), [200, green(0.625), 50, 255]);
    assert_eq!(pixels.at(0, 1), [200, green(0.125), 50, 255]);
    assert_eq!(look.pictures()[0].pixels().unwrap().at(2, 0), [200, 100, 50, 255]);
    let other = colours.map(|[r, g, b, a]| [1.0 - g * 0.5, r, b, a]);
    let beyond = textured(
        base(json!({"index": 0, "extensions": {"KHR_texture_transform":
        {"scale": [3, 3]}}})),
        |file, primitive| {
            primitive["attributes"]["COLOR_0"] = file.floats(&other).into();
        },
    );
    let notes = read_noted(&beyond).unwrap().notes;
    assert!(notes[0].contains("over a texture that repeats"), "{notes:?}");
}

#[test]
fn a_texture_without_coordinates_is_told_and_gives_no_look() {
    let bytes = textured(base(json!({"index": 0, "texCoord": 3})), |_, _| {});
    let reading = read_noted(&bytes).unwrap();
    assert!(reading.appearance.is_none());
    assert!(reading.notes[0].contains("no TEXCOORD_3"), "{:?}", reading.notes);
}

#[test]
fn a_hidden_node_is_left_out_with_what_hangs_below_it() {
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    let nodes = json!([{"mesh": 0, "children": [1]}, {"children": [2], "extensions": hidden},
        {"mesh": 0, "translation": [5, 0, 0]}]);
    let reading = read_noted(&tetrahedron_with(nodes)).unwrap();
    assert_eq!(reading.mesh.faces().len(), 4);
    assert_eq!(reading.notes, ["node 1 is hidden and left out with what hangs below it"]);
}

#[test]
fn a_skinned_mesh_stands_where_its_joints_put_it_and_not_its_node() {
    let mut file = File::new();
    let position = file.floats(&TETRAHEDRON);
    let indices: Vec<u8> = FACES.as_flattened().iter().map(|&i| i as u8).collect();
    let indices = file.bytes(&indices);
    let mut bind = [0.0f32; 16];
    (bind[0], bind[5], bind[10], bind[12], bind[15]) = (1.0, 1.0, 1.0, 1.0, 1.0);
    let view = file.view(bind.into_iter().flat_map(f32::to_le_bytes));
    let matrices = file.accessor(view, 5126, "MAT4", 1);
    file.json["skins"] = json!([{"joints": [2], "inverseBindMatrices": matrices}]);
    let nodes = json!([{"children": [1, 2], "scale": [2, 2, 2]},
        {"mesh": 0, "skin": 0, "translation": [50, 0, 0]}, {"translation": [3, 0, 0]}]);
    let primitive = json!({"attributes": {"POSITION": position}, "indices": indices});
    let reading = read_noted(&file.scene(json!([primitive]), nodes)).unwrap();
    let bounds = reading.mesh.bounds();
    assert_eq!((bounds.min.x, bounds.max.x), (8.0, 10.0));
    assert_eq!(reading.notes, ["1 skins are left out"]);
    let lost = tetrahedron_with(json!([{"mesh": 0, "skin": 7}]));
    assert!(error_of(&lost).contains("skin 7"));
}
