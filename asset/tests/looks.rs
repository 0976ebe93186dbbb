//! A textured cabinet: what its file shows is what every format shows.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on stops")]

mod cabinet;

use std::collections::BTreeMap;

use asset::{Asset, AssetAppearance};
use cabinet::{DOOR, DRAWER, built, cabinet};
use object::appearance::{Appearance, Material, Picture, Pixels, Surfacing, Texture, Wrap};
use object::{DVec3, Mesh, glb, weld};
use roxmltree::Document;

/// Texels along a face's own square of the picture, and squares in a row.
const SQUARE: u32 = 16;
const ROW: u32 = 8;

fn colour(face: u32) -> [u8; 4] {
    [(face * 37 % 256) as u8, (face * 91 % 256) as u8, (face * 153 % 256) as u8, 255]
}

/// Every face of the cabinet has a square of a colour of its own; the door is brass without a picture.
fn look() -> Appearance {
    let mesh = cabinet().mesh().clone();
    let count = mesh.faces().len() as u32;
    let mut pixels = Pixels::filled(SQUARE * ROW, SQUARE * count.div_ceil(ROW), [0, 0, 0, 255]);
    let (width, height) = (pixels.width(), pixels.height());
    for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
        pixels.set(x, y, colour(y / SQUARE * ROW + x / SQUARE));
    }
    let size = [pixels.width(), pixels.height()].map(|s| s as f32);
    let picture = Picture::new(pixels.png().unwrap()).unwrap();
    let base_texture = Some(Texture { picture: 0, wrap: [Wrap::Repeat; 2] });
    let wood = Material { name: "wood".into(), base_texture, ..Material::default() };
    let base_colour = [0.5, 0.25, 0.125, 1.0];
    let brass = Material {
        name: "brass".into(),
        base_colour,
        metallic: 1.0,
        roughness: 0.25,
        ..wood.clone()
    };
    let brass = Material { base_texture: None, ..brass };
    let face = |f: u32| {
        let low = [f % ROW * SQUARE + 2, f / ROW * SQUARE + 2].map(|t| t as f32);
        let at = |x: f32, y: f32| [(low[0] + x) / size[0], (low[1] + y) / size[1]];
        let is_door = cabinet().part_of_face()[f as usize] == DOOR as u16;
        let corners = [at(0.0, 0.0), at(12.0, 0.0), at(0.0, 12.0)];
        Surfacing { material: Some(u32::from(is_door)), corners }
    };
    Appearance::new(vec![picture], vec![wood, brass], (0..count).map(face).collect()).unwrap()
}

fn dressed() -> (Asset, AssetAppearance) {
    let asset = built();
    let appearance = AssetAppearance::of(&asset, &cabinet(), Some(&look()));
    assert_eq!(appearance.notes(), [""; 0]);
    (asset, appearance)
}

/// The cabinet's own mesh where the asset stands.
fn placed(asset: &Asset) -> Mesh {
    let place = |p: DVec3| asset.turn * (asset.scale.value * p) + asset.offset;
    cabinet().mesh().map_vertices(place).unwrap()
}

/// The face of the cabinet that a face of the asset is a piece of.
fn origin(original: &Mesh, corners: [DVec3; 3]) -> usize {
    let [a, b, c] = corners;
    let (middle, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize());
    let near = weld::nearest_faces(original, middle, 1e-6);
    near.into_iter()
        .max_by(|f, g| original.normal(*f).dot(normal).total_cmp(&original.normal(*g).dot(normal)))
        .unwrap()
}

fn texel(pixels: &Pixels, uv: [f64; 2]) -> [u8; 4] {
    let at = |c: f64, n: u32| (c * f64::from(n)) as u32;
    pixels.at(at(uv[0], pixels.width()), at(uv[1], pixels.height()))
}

fn middle(corners: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|k| corners.iter().map(|c| c[k]).sum::<f64>() / 3.0)
}

#[test]
fn the_glb_shows_on_every_face_what_the_file_showed_there() {
    let (asset, appearance) = dressed();
    let bytes = asset.to_glb_with(&appearance);
    let reading = glb::read_noted(&bytes).unwrap();
    let (look, original) = (reading.appearance.unwrap(), placed(&asset));
    let pixels: Vec<Pixels> = look.pictures().iter().map(|p| p.pixels().unwrap()).collect();
    let door = cabinet().part_of_face().to_vec();
    for face in 0..reading.mesh.faces().len() {
        let from = origin(&original, reading.mesh.corners(face));
        let (material, corners) = look.of_face(face).unwrap();
        if door[from] == DOOR as u16 {
            assert_eq!((material.base_colour, material.metallic), ([0.5, 0.25, 0.125, 1.0], 1.0));
            continue;
        }
        let uv = middle(corners.map(|c| c.map(f64::from)));
        let shown = texel(&pixels[material.base_texture.unwrap().picture], uv);
        assert_eq!(shown, colour(from as u32), "face {face} of {from}");
    }
}

/// Corners and texture coordinates of a face.
type Face = ([DVec3; 3], Option<[[f64; 2]; 3]>);

/// The faces of an OBJ.
fn faces_of(obj: &str) -> Vec<Face> {
    let rows = |word: &str| -> Vec<Vec<f64>> {
        let lines = obj.lines().filter(|l| l.split(' ').next() == Some(word));
        lines.map(|l| l.split(' ').skip(1).map(|w| w.parse().unwrap()).collect()).collect()
    };
    let (points, places) = (rows("v"), rows("vt"));
    let face = |line: &str| {
        let corners: Vec<Vec<usize>> = line
            .split(' ')
            .skip(1)
            .map(|c| c.split('/').map(|n| n.parse().unwrap_or(0)).collect())
            .collect();
        let point = |k: usize| DVec3::from_slice(&points[corners[k][0] - 1][..3]);
        let place = |k: usize| {
            let at = &places[corners[k][1] - 1];
            [at[0], 1.0 - at[1]]
        };
        let is_textured = corners[0][1] > 0;
        ([0, 1, 2].map(point), is_textured.then(|| [0, 1, 2].map(place)))
    };
    obj.lines().filter(|l| l.starts_with("f ")).map(face).collect()
}

#[test]
fn the_urdf_shows_on_every_face_what_the_file_showed_there() {
    let (asset, appearance) = dressed();
    let (files, original) = (asset.to_urdf_with(&appearance).files, placed(&asset));
    let text = |path: &str| String::from_utf8(files[path].clone()).unwrap();
    let urdf = text("asset.urdf");
    let document = Document::parse(&urdf).unwrap();
    let mut seen = 0;
    for link in &asset.links {
        let Some(body) = &link.body else { continue };
        let is_own = |n: &roxmltree::Node<'_, '_>| n.attribute("name") == Some(link.name.as_str());
        let node = document.root_element().children().find(is_own).unwrap();
        let visuals = node.children().filter(|n| n.has_tag_name("visual"));
        let mut faces = 0;
        for visual in visuals {
            let path = visual.descendants().find_map(|n| n.attribute("filename")).unwrap();
            let obj = text(path);
            let mtl = obj.lines().find_map(|l| l.strip_prefix("mtllib ")).unwrap();
            let mtl = text(&format!("meshes/{mtl}"));
            let name = obj.lines().find_map(|l| l.strip_prefix("usemtl ")).unwrap();
            let of = mtl.split("newmtl ").find(|m| m.starts_with(&format!("{name}\n"))).unwrap();
            let picture = of.lines().find_map(|l| l.strip_prefix("map_Kd "));
            let pixels = picture.map(|p| {
                Picture::new(files[&format!("meshes/{p}")].clone()).unwrap().pixels().unwrap()
            });
            for (corners, uv) in faces_of(&obj) {
                faces += 1;
                let from = origin(&original, corners.map(|p| p + link.frame));
                let Some(pixels) = &pixels else {
                    assert_eq!(cabinet().part_of_face()[from], DOOR as u16);
                    assert!(of.contains("Kd 0.7354 0.5371 0.3886\n"), "{of}");
                    continue;
                };
                assert_eq!(texel(pixels, middle(uv.unwrap())), colour(from as u32), "{path}");
                seen += 1;
            }
        }
        assert_eq!(faces, body.visual.faces().len(), "{}", link.name);
    }
    assert!(seen > 40, "{seen}");
}

#[test]
fn a_link_carries_only_what_it_shows() {
    let (asset, appearance) = dressed();
    let files = asset.to_urdf_with(&appearance).files;
    let size = |bytes: &[u8]| Picture::new(bytes.to_vec()).unwrap().pixel_count();
    let sizes: BTreeMap<_, _> =
        files.iter().filter(|(p, _)| p.ends_with(".png")).map(|(p, b)| (p, size(b))).collect();
    let whole = look().pictures()[0].pixel_count();
    assert!(sizes.values().sum::<u64>() <= whole, "{sizes:?} of {whole}");
}

#[test]
fn mjcf_and_usd_name_the_pictures_of_the_package() {
    let (asset, appearance) = dressed();
    let files = asset.to_urdf_with(&appearance).files;
    let mjcf = asset.to_mjcf_with(&appearance);
    let document = Document::parse(&mjcf).unwrap();
    let all = |tag: &'static str| document.descendants().filter(move |n| n.has_tag_name(tag));
    assert!(all("texture").count() > 0);
    assert!(all("texture").all(|t| files.contains_key(t.attribute("file").unwrap())));
    assert!(all("mesh").all(|m| files.contains_key(m.attribute("file").unwrap())));
    let materials: Vec<_> = all("material").filter_map(|m| m.attribute("name")).collect();
    let used: Vec<_> = all("geom").filter_map(|g| g.attribute("material")).collect();
    assert!(!used.is_empty() && used.iter().all(|u| materials.contains(u)));
    let usd = asset.to_usd_with(&appearance);
    let assets = usd.lines().filter_map(|l| l.trim().strip_prefix("asset inputs:file = @"));
    let named: Vec<_> = assets.map(|a| a.trim_end_matches('@')).collect();
    assert!(!named.is_empty() && named.iter().all(|n| files.contains_key(*n)));
}

#[test]
fn an_appearance_reads_back_as_it_was() {
    let (asset, appearance) = dressed();
    let files = appearance.to_files();
    let back = AssetAppearance::from_files(files.clone()).unwrap();
    assert!(back == appearance && asset.to_glb_with(&back) == asset.to_glb_with(&appearance));
    let mut torn = files;
    torn.retain(|name, _| !name.ends_with(".png"));
    assert!(AssetAppearance::from_files(torn).unwrap_err().contains(".png"));
}

#[test]
fn a_jpeg_that_is_shown_whole_stays_a_jpeg_in_the_glb() {
    let mut jpeg = Vec::new();
    let noise = |i: usize| ((i * 2_654_435_761) >> 7) as u8;
    let pixels: Vec<u8> = (0..3 * 64 * 64).map(noise).collect();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 90);
    image::ImageEncoder::write_image(encoder, &pixels, 64, 64, image::ExtendedColorType::Rgb8)
        .unwrap();
    let picture = Picture::new(jpeg.clone()).unwrap();
    let base_texture = Some(Texture { picture: 0, wrap: [Wrap::Repeat; 2] });
    let photo = Material { base_texture, ..Material::default() };
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let faces = vec![Surfacing { material: Some(0), corners }; cabinet().mesh().faces().len()];
    let look = Appearance::new(vec![picture], vec![photo], faces).unwrap();
    let asset = built();
    let appearance = AssetAppearance::of(&asset, &cabinet(), Some(&look));
    assert!(AssetAppearance::from_files(appearance.to_files()).unwrap() == appearance);
    let glb = glb::read_noted(&asset.to_glb_with(&appearance)).unwrap();
    assert_eq!(glb.appearance.unwrap().pictures()[0].bytes(), jpeg);
    let files = asset.to_urdf_with(&appearance).files;
    assert!(files.keys().any(|path| path.ends_with(".png")));
}

#[test]
fn without_an_appearance_every_byte_is_as_it_was() {
    let asset = built();
    let none = AssetAppearance::of(&asset, &cabinet(), None);
    assert!(asset.to_urdf_with(&none) == asset.to_urdf());
    assert!(asset.to_glb_with(&none) == asset.to_glb());
    assert!(asset.to_usd_with(&none) == asset.to_usd());
    assert!(asset.to_mjcf_with(&none) == asset.to_mjcf());
}

#[test]
fn brass_knobs_on_a_wooden_drawer_stay_brass_without_a_picture() {
    let object = cabinet();
    let apart: Vec<_> =
        (0..object.mesh().faces().len()).map(|f| object.mesh().corners(f)).collect();
    let mesh = Mesh::of_triangles(&apart).unwrap();
    let shade = |v: usize| match object.part_of_face()[v / 3] {
        p if p == DRAWER as u16 && v / 3 % 12 < 2 => [200, 160, 40, 255],
        _ => [120, 80, 40, 255],
    };
    let mesh = mesh.with_colours(Some((0..apart.len() * 3).map(shade).collect())).unwrap();
    let painted = object.with_surface(mesh, object.part_of_face().to_vec()).unwrap();
    let options = asset::BuildOptions::default();
    let asset = asset::build(&painted, &cabinet::condition(), &cabinet::MAP, &options).unwrap();
    let appearance = AssetAppearance::of(&asset, &painted, None);
    let mjcf = asset.to_mjcf_with(&appearance);
    assert!(mjcf.contains("rgba=\"0.7843 0.6275 0.1569 1\""), "{mjcf}");
    assert!(asset.to_glb_with(&appearance) == asset.to_glb(), "a GLB has colours of vertices");
}

#[test]
fn materials_of_another_mesh_are_left_out_and_told() {
    let asset = built();
    let other = Appearance::new(vec![], vec![], vec![]).unwrap();
    let appearance = AssetAppearance::of(&asset, &cabinet(), Some(&other));
    assert_eq!(appearance.notes(), ["materials are left out: they are of another mesh"]);
    let sidecar = asset.to_urdf_with(&appearance).files["asset.json"].clone();
    let sidecar: serde_json::Value = serde_json::from_slice(&sidecar).unwrap();
    assert_eq!(sidecar["left_out"][0], appearance.notes()[0]);
}

/// Writes the asset of a GLB, cut in two parts by height, in every format. Not part of any check: it is
/// how pictures of real files are looked at. `KINFOLD_GLB=in.glb KINFOLD_LOOKS=out cargo test -p
/// kinfold-asset --test looks -- --ignored`.
#[test]
#[ignore = "asks for a file to look at"]
fn a_file_is_written_in_every_format_to_be_looked_at() {
    let said = |name: &str| std::env::var(name).unwrap();
    let bytes = std::fs::read(said("KINFOLD_GLB")).unwrap();
    let reading = glb::read_noted(&bytes).unwrap();
    let mesh = reading.mesh;
    let level = mesh.bounds().min.z + 0.7 * mesh.bounds().size().z;
    let label = |f: usize| u16::from(mesh.centroid(f).z > level);
    let labels: Vec<u16> = (0..mesh.faces().len()).map(label).collect();
    let condition = object::Condition::from_json(
        r#"{"schema": "kinfold-condition/1", "category": "thing", "size": {"height": 0.4},
            "parts": [{"name": "base"},
                      {"name": "lid", "parent": "base", "joint": "prismatic"}]}"#,
    )
    .unwrap();
    let slide = object::JointMotion {
        kind: object::JointKind::Prismatic,
        axis: DVec3::Z,
        pivot: mesh.bounds().centre().with_z(level),
        range: object::Range::Limits { lower: 0.0, upper: 0.1 * mesh.bounds().size().z },
    };
    let tree = condition.tree.clone();
    let object =
        object::ArticulatedObject::new(mesh, tree, labels, vec![vec![], vec![slide]]).unwrap();
    let options = asset::BuildOptions::default();
    let asset = asset::build(&object, &condition, &[Some(0), Some(1)], &options).unwrap();
    let start = std::time::Instant::now();
    let appearance = AssetAppearance::of(&asset, &object, reading.appearance.as_ref());
    println!("transferred in {:.2?}", start.elapsed());
    let start = std::time::Instant::now();
    let mut files = asset.to_urdf_with(&appearance).files;
    println!("urdf in {:.2?}", start.elapsed());
    files.insert("asset.xml".into(), asset.to_mjcf_with(&appearance).into_bytes());
    files.insert("asset.usda".into(), asset.to_usd_with(&appearance).into_bytes());
    files.insert("asset.usdz".into(), asset.to_usdz_with(&appearance));
    files.insert("asset.glb".into(), asset.to_glb_with(&appearance));
    println!("all written in {:.2?}", start.elapsed());
    println!("notes: {:?} {:?}", reading.notes, appearance.notes());
    for (path, bytes) in &files {
        let path = std::path::Path::new(&said("KINFOLD_LOOKS")).join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
    }
}
