//! The same cabinet in every mesh format: whoever has it in one gets the asset that another gives.

use std::fmt::Write as _;
use std::path::Path;

use object::Mesh;
use object::mesh::FileFrame;
use serde_json::{Value, json};

use crate::cabinet::mesh;
use crate::kinfold::{Bench, Said, program};

/// Corners of the cabinet's faces in a file with y up.
fn corners(mesh: &Mesh) -> Vec<[[f32; 3]; 3]> {
    let frame = FileFrame::default();
    let single = |p| frame.point_to_file(p).to_array().map(|c| c as f32);
    (0..mesh.faces().len()).map(|f| mesh.corners(f).map(single)).collect()
}

fn stl(mesh: &Mesh) -> Vec<u8> {
    let faces = corners(mesh);
    let mut bytes = vec![b' '; 80];
    bytes.extend((faces.len() as u32).to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flatten().flat_map(|c| c.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ply(mesh: &Mesh) -> Vec<u8> {
    let faces = corners(mesh);
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        3 * faces.len(),
        faces.len()
    );
    for [x, y, z] in faces.iter().flatten() {
        writeln!(text, "{x} {y} {z}").unwrap();
    }
    for n in 0..faces.len() {
        writeln!(text, "3 {} {} {}", 3 * n, 3 * n + 1, 3 * n + 2).unwrap();
    }
    text.into_bytes()
}

fn usda(mesh: &Mesh) -> Vec<u8> {
    let faces = corners(mesh);
    let points: Vec<_> =
        faces.iter().flatten().map(|[x, y, z]| format!("({x}, {y}, {z})")).collect();
    let list = |words: Vec<String>| words.join(", ");
    format!(
        "#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\ndef Mesh \"cabinet\"\n{{\n\
         int[] faceVertexCounts = [{}]\nint[] faceVertexIndices = [{}]\npoint3f[] points = [{}]\n\
         uniform token subdivisionScheme = \"none\"\n}}\n",
        list(faces.iter().map(|_| "3".into()).collect()),
        list((0..3 * faces.len()).map(|n| n.to_string()).collect()),
        list(points),
    )
    .into_bytes()
}

/// The cabinet's own GLB as a text and a buffer beside it.
fn gltf(folder: &Path) -> Vec<u8> {
    let glb = object::glb::write(&mesh());
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let mut document: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    std::fs::create_dir_all(folder.join("data")).unwrap();
    std::fs::write(folder.join("data/the cabinet.bin"), &glb[28 + length..]).unwrap();
    document["buffers"][0]["uri"] = json!("data/the%20cabinet.bin");
    document.to_string().into_bytes()
}

/// What is said of the cabinet without a photo, from a mesh file of this name.
fn made(bench: &Bench, name: &str) -> Said {
    made_with(bench, name, &[])
}

fn made_with(bench: &Bench, name: &str, more: &[&str]) -> Said {
    let out = program()
        .current_dir(bench.path(""))
        .env("KINFOLD_STATE", bench.path("state"))
        .args(["make", "--mesh", name, "--condition", "cabinet.json"])
        .args(more)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Said { code: out.status.code(), out: text(&out.stdout), err: text(&out.stderr) }
}

/// Names and masses of links, and joints with their ranges, to six digits.
fn told(bench: &Bench) -> String {
    let urdf = std::fs::read_to_string(bench.path("cabinet.kinfold/asset.urdf")).unwrap();
    let document = roxmltree::Document::parse(&urdf).unwrap();
    let mut words = String::new();
    let told = |node: roxmltree::Node<'_, '_>, words: &mut String| {
        for attribute in node.attributes() {
            let value = attribute.value();
            let number = value.parse::<f64>().map(|x| format!("{x:.4}"));
            write!(words, " {}", number.unwrap_or_else(|_| value.to_owned())).unwrap();
        }
        words.push('\n');
    };
    let all = document.descendants();
    all.filter(|n| ["link", "mass", "joint", "limit"].contains(&n.tag_name().name()))
        .for_each(|n| told(n, &mut words));
    words
}

#[test]
fn every_mesh_format_gives_the_same_cabinet_without_a_photo() {
    let mut known = None;
    for name in ["glb", "gltf", "obj", "stl", "ply", "usda"] {
        let bench = Bench::new();
        let upright = |p| FileFrame::default().point_to_file(p);
        let bytes = match name {
            "glb" => object::glb::write(&mesh()),
            "gltf" => gltf(&bench.path("")),
            "stl" => stl(&mesh()),
            "ply" => ply(&mesh()),
            "usda" => usda(&mesh()),
            _ => {
                let mesh = mesh().map_vertices(upright).unwrap();
                object::obj::write(&mesh, object::obj::ObjNormals::None).into_bytes()
            }
        };
        let file = format!("cabinet.{name}");
        std::fs::write(bench.path(&file), bytes).unwrap();
        std::fs::remove_file(&bench.cabinet.photo).unwrap();
        let said = made(&bench, &file);
        assert_eq!(said.code, Some(0), "{name}: {said:?}");
        assert!(said.err.contains("no photo was given: a view of the mesh stands in its place"));
        let told = told(&bench);
        assert_eq!(&told, known.get_or_insert_with(|| told.clone()), "{name}");
    }
    assert!(known.unwrap().contains("revolute"));
}

#[test]
fn a_file_beside_a_mesh_is_never_taken_from_another_folder() {
    let bench = Bench::new();
    let inner = bench.path("inner");
    std::fs::create_dir_all(&inner).unwrap();
    let text = String::from_utf8(gltf(&bench.path(""))).unwrap();
    let text = text.replace("data/the%20cabinet.bin", "../data/the%20cabinet.bin");
    std::fs::write(inner.join("cabinet.gltf"), text).unwrap();
    let said = made(&bench, "inner/cabinet.gltf");
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("leads out of the folder"), "{said:?}");
    std::fs::copy(bench.path("data/the cabinet.bin"), inner.join("the cabinet.bin")).unwrap();
    assert_eq!(made(&bench, "inner/cabinet.gltf").code, Some(0));
}

#[test]
fn a_picture_that_an_obj_names_is_part_of_what_is_made() {
    let bench = Bench::new();
    let frame = FileFrame::default();
    let upright = mesh().map_vertices(|p| frame.point_to_file(p)).unwrap();
    let obj = object::obj::write(&upright, object::obj::ObjNormals::None);
    let faces = obj.lines().filter(|l| l.starts_with("f ")).map(|line| {
        let corners = line.split(' ').skip(1).zip(1..).map(|(v, t)| format!(" {v}/{t}"));
        format!("f{}\n", corners.collect::<String>())
    });
    let vertices: String =
        obj.lines().filter(|l| l.starts_with("v ")).map(|l| format!("{l}\n")).collect();
    let text = format!(
        "mtllib cabinet.mtl\n{vertices}vt 0.1 0.1\nvt 0.9 0.1\nvt 0.1 0.9\nusemtl wood\n{}",
        faces.collect::<String>()
    );
    std::fs::write(bench.path("cabinet.obj"), text).unwrap();
    let said = made(&bench, "cabinet.obj");
    assert!(said.err.contains("`cabinet.mtl` are left out: it is not there"), "{said:?}");
    std::fs::write(bench.path("cabinet.mtl"), "newmtl wood\nKd 1 1 1\nmap_Kd wood.png\n").unwrap();
    std::fs::write(bench.path("wood.png"), crate::cabinet::png(32, 32)).unwrap();
    // It looks otherwise now, so whoever means the folder names it.
    assert_eq!(made(&bench, "cabinet.obj").code, Some(2));
    let said = made_with(&bench, "cabinet.obj", &["--out", "cabinet.kinfold"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(!said.err.contains("left out"), "{said:?}");
    let meshes = std::fs::read_dir(bench.path("cabinet.kinfold/meshes")).unwrap();
    let names: Vec<_> = meshes.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    assert!(names.iter().any(|n| n.ends_with(".png")), "{names:?}");
}
