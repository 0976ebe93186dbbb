//! What a person who makes a mistake is told, row by row as new users made them.

use serde_json::{Value, json};

use crate::cabinet::{condition, in_file};
use crate::kinfold::{Bench, Said, program, say};

/// What is said of a cabinet with a spoilt condition.
fn told(edit: impl FnOnce(&mut Value)) -> Said {
    text_told(&{
        let mut condition = condition();
        edit(&mut condition);
        serde_json::to_string_pretty(&condition).unwrap()
    })
}

fn text_told(text: &str) -> Said {
    let bench = Bench::new();
    std::fs::write(&bench.cabinet.condition, text).unwrap();
    bench.made(&[])
}

#[track_caller]
fn says(said: &Said, code: i32, words: &str) {
    assert!(said.err.contains(words), "{words:?} is missing from {}", said.err);
    assert_eq!(said.code, Some(code), "{}", said.err);
}

#[test]
fn a_mesh_of_another_format_is_called_by_its_name() {
    let formats: [(&str, &[u8], &str); 8] = [
        ("a.off", b"OFF\n3 1 0\n", "found OFF"),
        ("a.fbx", b"Kaydara FBX Binary  \0\x1a\0", "found FBX"),
        ("a.zip", b"PK\x03\x04\x0a\0", "found a ZIP archive: unpack it"),
        ("a.blend", b"BLENDER-v300", "found a Blender file (.blend)"),
        ("a.html", b"<!doctype html><html></html>", "found a web page"),
        ("a.glb", b"version https://git-lfs.github.com/spec/v1\n", "run `git lfs pull`"),
        ("a.drc", b"DRACO\x02\x02", "found a Draco file"),
        ("a.png", b"\x89PNG\r\n\x1a\n", "found a picture"),
    ];
    for (name, bytes, words) in formats {
        let bench = Bench::new();
        std::fs::write(bench.path(name), bytes).unwrap();
        std::fs::copy(bench.path(name), &bench.cabinet.mesh).unwrap();
        let said = bench.made(&[]);
        says(&said, 1, words);
        says(&said, 1, "expected a mesh as GLB, glTF, OBJ, STL, PLY or USD");
    }
}

#[test]
fn a_photo_of_another_format_is_called_by_its_name() {
    for (bytes, words) in [
        (&b"\0\0\0\x18ftypheic\0\0\0\0mif1heic"[..], "HEIC, as iPhones take it"),
        (b"\0\0\0\x1cftypavif\0\0\0\0avifmif1", "AVIF"),
        (b"GIF89a\x01\0\x01\0", "found GIF"),
        (b"BM\x46\0\0\0", "found BMP"),
        (b"II*\0\x08\0\0\0", "found TIFF"),
    ] {
        let bench = Bench::new();
        std::fs::write(&bench.cabinet.photo, bytes).unwrap();
        says(&bench.made(&[]), 1, words);
    }
}

#[test]
fn a_joint_by_another_name_is_told_ours() {
    let joint = |word: &str| told(|c| c["parts"][1]["joint"] = json!(word));
    let rule = "is no joint; there are revolute, continuous, prismatic: did you mean `revolute`?";
    says(&joint("hinge"), 1, &format!("part `door`: `joint`: `hinge` {rule}"));
    says(&joint("Revolute"), 1, &format!("`Revolute` {rule}"));
}

#[test]
fn a_size_that_is_no_size_is_told_what_one_is() {
    let size = |size: Value| told(|c| c["size"] = size);
    let rule = "`size` is an object with one of largest, height, width, depth, in metres";
    says(&size(json!(0.9)), 1, rule);
    says(&size(json!({"height": 0.9, "width": 0.4})), 1, rule);
    says(&size(json!({"height": "tall"})), 1, "a length is a number of metres");
    says(&size(json!({"height": "0.9m"})), 0, "");
}

#[test]
fn a_byte_order_mark_and_comments_are_read() {
    let text = serde_json::to_string_pretty(&condition()).unwrap();
    says(&text_told(&format!("\u{feff}// a cabinet\n{text}")), 0, "");
}

#[test]
fn points_of_another_program_are_recognised() {
    let points = |f: fn([f64; 3]) -> [f64; 3]| {
        told(|c| {
            for part in c["parts"].as_array_mut().unwrap() {
                let point = [0, 1, 2].map(|i| part["point"][i].as_f64().unwrap());
                part["point"] = json!(f(point));
            }
        })
    };
    let said = points(|[x, y, z]| [x, -z, y]);
    says(&said, 1, "these look like z-up coordinates, as Blender has them");
    says(&said, 1, "nearest on it is");
    says(&points(|p| p.map(|c| c * 1000.0)), 1, "1000 times too large, millimetres for metres?");
}

#[test]
fn a_point_off_the_mesh_is_moved_onto_it_where_that_was_asked_for() {
    let bench = Bench::new();
    let mut condition = condition();
    condition["parts"][1]["point"] = json!([0.0, 0.3, 0.08]);
    bench.cabinet.write_condition(&condition);
    says(&bench.made(&[]), 1, "lies 0.0580 off the mesh");
    says(&bench.made(&["--snap"]), 0, "1 point was moved onto the mesh (--snap)");
}

#[test]
fn all_that_is_wrong_is_told_at_once_and_before_anything_is_made() {
    let bench = Bench::new();
    let mut condition = condition();
    condition["parts"][0]["point"] = json!([9, 9, 9]);
    condition["parts"][1]["point"] = json!([8, 8, 8]);
    bench.cabinet.write_condition(&condition);
    let said = bench.made(&[]);
    says(&said, 1, "2 things are wrong in it");
    says(&said, 1, "part `body`: point (9, 9, 9) lies");
    says(&said, 1, "part `door`: point (8, 8, 8) lies");
    assert_eq!(bench.finished("render-views"), 0, "nothing was rendered for it");
}

#[test]
fn what_was_taken_for_granted_is_said() {
    let bench = Bench::new();
    let mut unsized_ = condition();
    unsized_.as_object_mut().unwrap().remove("size");
    bench.cabinet.write_condition(&unsized_);
    says(
        &bench.made(&[]),
        0,
        "size unknown: the mesh file's unit is taken as a metre, so it is 0.60 m high",
    );
    let bench = Bench::new();
    let lying = |p: object::DVec3| object::DVec3::new(p.x, p.z, -p.y);
    let mesh = crate::cabinet::mesh().map_vertices(lying).unwrap();
    std::fs::write(&bench.cabinet.mesh, object::glb::write(&mesh)).unwrap();
    let mut pointless = condition();
    for part in pointless["parts"].as_array_mut().unwrap() {
        part.as_object_mut().unwrap().remove("point");
    }
    bench.cabinet.write_condition(&pointless);
    let said = bench.made(&[]);
    assert!(said.err.contains("if it lies on its back, say --up z"), "{said:?}");
    let bench = Bench::new();
    let upright = |p: object::DVec3| object::DVec3::from_array(in_file(p.to_array()));
    let mesh = crate::cabinet::mesh().map_vertices(upright).unwrap();
    let obj = object::obj::write(&mesh, object::obj::ObjNormals::None);
    std::fs::write(bench.path("cabinet.obj"), format!("mtllib cabinet.mtl\n{obj}")).unwrap();
    let said = program()
        .current_dir(bench.path(""))
        .env("KINFOLD_STATE", bench.path("state"))
        .args(["make", "photo.png", "--mesh", "cabinet.obj", "--condition", "cabinet.json"])
        .output()
        .unwrap();
    let err = String::from_utf8_lossy(&said.stderr).into_owned();
    assert!(err.contains("the materials of `cabinet.mtl` are left out: it is not there"), "{err}");
}

#[test]
fn what_one_begins_with_can_be_read_and_points_are_found_for_it() {
    let bench = Bench::new();
    let folder = bench.path("new");
    let said = say(&["init", folder.to_str().unwrap()]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(said.out.lines().count(), 2);
    let text = std::fs::read_to_string(folder.join("condition.json")).unwrap();
    assert_eq!(object::Condition::from_json(&text).unwrap().tree.len(), 3);
    says(&say(&["init", folder.to_str().unwrap()]), 1, "are there already");
    let mesh = bench.cabinet.mesh.to_str().unwrap();
    let at = say(&["points", mesh, "--at", "front:512,512"]);
    assert_eq!(at.code, Some(0), "{at:?}");
    let point: [f64; 3] = serde_json::from_str(&at.out).unwrap();
    assert!((point[2] - 0.022).abs() < 1e-6, "the door's front: {point:?}");
    says(&say(&["points", mesh, "--at", "front:1,1"]), 1, "shows background");
    says(&say(&["points", mesh, "--at", "top:1,1"]), 2, "no view is called `top`");
    let out = bench.path("views");
    let said = say(&["points", mesh, "--out", out.to_str().unwrap()]);
    assert_eq!(said.out.lines().count(), 9, "{said:?}");
    let again = say(&["points", mesh, "--out", out.to_str().unwrap()]);
    says(&again, 1, "is there already");
    says(&say(&["points", mesh, "--out", out.to_str().unwrap(), "--force"]), 0, "");
    says(&say(&["points", mesh, "--at", "front:-1,5"]), 2, "lies outside of the view");
    let table: Value =
        serde_json::from_slice(&std::fs::read(out.join("points.json")).unwrap()).unwrap();
    assert_eq!(
        table["mesh"],
        json!(object::glb::read(&std::fs::read(mesh).unwrap()).unwrap().digest())
    );
    let rows = table["views"]["front"].as_array().unwrap();
    assert!(rows.len() > 100, "{}", rows.len());
    let mut corrected = condition();
    corrected["parts"][1]["point"] = rows[rows.len() / 2]["point"].clone();
    bench.cabinet.write_condition(&corrected);
    assert_eq!(bench.made(&[]).code, Some(0), "a point of the table is one of a condition");

    let patch = say(&["points", mesh, "--at", "front:512,512", "--faces"]);
    let patch: object::condition::Runs = patch.out.trim().parse().unwrap();
    let whole = say(&["points", mesh, "--at", "front:512,512", "--faces", "180", "--json"]);
    let whole: Value = serde_json::from_str(&whole.out).unwrap();
    let piece = rows.iter().find(|row| row["face"] == whole["face"]).unwrap()["piece"].as_u64();
    assert_eq!(table["pieces"][piece.unwrap() as usize], whole["faces"]);
    let faces: object::condition::Runs = whole["faces"].as_str().unwrap().parse().unwrap();
    assert!(patch.iter().all(|face| faces.iter().any(|f| f == face)), "{patch} of {faces}");
    assert!(patch.iter().count() < faces.iter().count(), "{patch} of {faces}");
    corrected["schema"] = "kinfold-condition/2".into();
    (corrected["mesh"], corrected["parts"][1]["faces"]) =
        (whole["mesh"].clone(), whole["faces"].clone());
    bench.cabinet.write_condition(&corrected);
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(0), "faces that were told are faces of a condition: {said:?}");
    says(&say(&["points", mesh, "--at", "front:512,512", "--faces", "181"]), 2, "0 to 180 degrees");
    says(&say(&["points", mesh, "--faces"]), 2, "--at");
}
