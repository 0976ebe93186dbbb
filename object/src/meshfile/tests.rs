use super::*;
use crate::appearance::{AlphaMode, PictureFormat, Pixels};
use crate::beside::Found;

const OBJ: &str = "mtllib my look.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nvt 0.25 0.75\n\
                   vt 0.75 0.75\nvt 0.75 0.25\nvt 0.25 0.25\nusemtl painted\nf 1/1 2/2 3/3 4/4\n\
                   usemtl brass\nf 2 5 3\nusemtl nowhere\nf 1 2 5\n";
const MTL: &str = "# by hand\nnewmtl painted\nKd 0 0 0\nmap_Kd -s 1 1 1 tex.png\nnewmtl brass\n\
                   Kd 0.8 0.5 0.2\nNs 250\nd 0.5\nmap_Bump bump.png\n";

/// Left half red, right half blue, above; green below.
fn picture() -> Vec<u8> {
    let mut pixels = Pixels::filled(2, 2, [0, 255, 0, 255]);
    pixels.set(0, 0, [255, 0, 0, 255]);
    pixels.set(1, 0, [0, 0, 255, 255]);
    pixels.png().unwrap()
}

fn folder(name: &str) -> Result<Found, String> {
    let bytes = match name {
        "my look.mtl" => MTL.as_bytes().to_vec(),
        "tex.png" => picture(),
        _ => return Err("is not there".into()),
    };
    Ok(Found { name: name.into(), bytes })
}

fn nothing(_: &str) -> Result<Found, String> {
    Err("is not there".into())
}

#[test]
fn an_obj_brings_its_materials_and_pictures_and_keeps_its_surface() {
    let taken = take_in(OBJ.into(), (true, UpAxis::Y), &mut folder).unwrap();
    let bare = obj::read(OBJ, UpAxis::Y).unwrap();
    assert_eq!(taken.mesh.digest(), bare.digest());
    assert_eq!(taken.media_type, "model/obj");
    let Reading { mesh, appearance, notes } = read_noted(&taken.file).unwrap();
    assert_eq!(mesh, taken.mesh);
    let appearance = appearance.unwrap();
    let (painted, corners) = appearance.of_face(0).unwrap();
    assert_eq!((painted.base_colour, corners[0]), ([1.0; 4], [0.25, 0.25]));
    assert_eq!(appearance.pictures()[0].format(), PictureFormat::Png);
    let (brass, _) = appearance.of_face(2).unwrap();
    assert_eq!((brass.roughness, brass.alpha, brass.base_colour[3]), (0.5, AlphaMode::Blend, 0.5));
    assert!((brass.base_colour[0] - glb::linear_of_srgb(0.8)).abs() < 1e-12);
    assert_eq!(appearance.of_face(3), None);
    assert_eq!(mesh.colours().unwrap()[0], [255, 0, 0, 255]);
    assert_eq!(mesh.colours().unwrap()[3], [0, 255, 0, 255]);
    assert_eq!(
        notes,
        [
            "material `brass`: its map_Bump is left out",
            "material `nowhere` is left out: no file defines it"
        ]
    );
}

#[test]
fn an_obj_without_its_materials_is_read_and_says_what_is_missing() {
    let taken = take_in(OBJ.into(), (true, UpAxis::Y), &mut nothing).unwrap();
    let reading = read_noted(&taken.file).unwrap();
    assert_eq!(reading.notes[0], "the materials of `my look.mtl` are left out: it is not there");
    assert_eq!((reading.appearance, reading.mesh.faces().len()), (None, 4));
    let plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let taken = take_in(plain.into(), (true, UpAxis::Y), &mut nothing).unwrap();
    assert_eq!(taken.file, plain.as_bytes());
}

#[test]
fn every_format_gives_the_same_triangle_standing_where_it_stood() {
    let stl = "solid a\nfacet normal 0 0 1\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 0 3\nendfacet\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0\n2 0 0\n0 0 3\n3 0 1 2\n";
    let obj = "v 0 0 0\nv 2 0 0\nv 0 0 3\nf 1 2 3\n";
    for up in [UpAxis::Y, UpAxis::Z] {
        let corners = [stl, ply, obj].map(|text| {
            let taken = take_in(text.into(), (text == obj, up), &mut nothing).unwrap();
            assert_eq!(taken.mesh, read(&taken.file).unwrap());
            taken.mesh.corners(0)
        });
        assert_eq!(corners[0], corners[1]);
        assert_eq!(corners[0], corners[2]);
        let height = if up == UpAxis::Z { [3.0, 0.0] } else { [0.0, -3.0] };
        assert_eq!([corners[0][2].z, corners[0][2].y], height);
    }
}

#[test]
fn what_a_ply_loses_is_said_by_the_file_that_comes_of_it() {
    let ply = "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 3\nproperty float x\n\
               property float y\nproperty float z\nelement face 1\n\
               property list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n0 0 3\n3 0 1 2\n";
    let taken = take_in(ply.into(), (false, UpAxis::Z), &mut nothing).unwrap();
    let notes = read_noted(&taken.file).unwrap().notes;
    assert!(notes[0].starts_with("the PLY's texture is left out"), "{notes:?}");
}

#[test]
fn what_is_no_mesh_is_named() {
    let error = take_in(b"Kaydara FBX Binary".to_vec(), (false, UpAxis::Y), &mut nothing);
    let said = error.unwrap_err().to_string();
    assert!(
        said.starts_with("expected a mesh as GLB, glTF, OBJ, STL, PLY or USD, found FBX"),
        "{said}"
    );
}

/// Files of every format that are found wanting in every way: cut, with bytes changed, with parts twice.
#[test]
fn thousands_of_hostile_files_of_every_format_never_panic() {
    use rand::{Rng as _, RngExt as _, SeedableRng as _};
    let seeds: [(&[u8], usize); 10] = [
        (include_bytes!("../../fuzz/seeds/meshfile/little.ply"), 1500),
        (include_bytes!("../../fuzz/seeds/meshfile/big.ply"), 1500),
        (include_bytes!("../../fuzz/seeds/meshfile/square.ply"), 1500),
        (include_bytes!("../../fuzz/seeds/meshfile/binary.stl"), 1500),
        (include_bytes!("../../fuzz/seeds/meshfile/text.stl"), 1500),
        (include_bytes!("../../fuzz/seeds/meshfile/square.obj"), 1500),
        (include_bytes!("../../fuzz/seeds/meshfile/two.gltf"), 1500),
        (include_bytes!("../../fuzz/seeds/usd/boxes.usda"), 200),
        (include_bytes!("../../fuzz/seeds/usd/boxes.usdc"), 200),
        (include_bytes!("../../fuzz/seeds/usd/boxes.usdz"), 200),
    ];
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(58);
    let mut read_well = 0;
    for (seed, count) in seeds {
        for _ in 0..count {
            let mut bytes = seed.to_vec();
            for _ in 0..random.random_range(1..6) {
                let at = random.random_range(0..bytes.len().max(1)).min(bytes.len());
                match random.random_range(0..5) {
                    0 => bytes.truncate(at),
                    1 => bytes.insert(at, random.next_u32() as u8),
                    2 => {
                        let end = (at + random.random_range(0..16)).min(bytes.len());
                        let part = bytes[at..end].to_vec();
                        bytes.splice(at..at, part);
                    }
                    _ if at < bytes.len() => bytes[at] = random.next_u32() as u8,
                    _ => {}
                }
            }
            let half = bytes.split_at(bytes.len() / 2).1.to_vec();
            let mut beside = |name: &str| Ok(Found { name: name.into(), bytes: half.clone() });
            if let Ok(taken) = take_in(bytes, (false, UpAxis::Z), &mut beside) {
                assert_eq!(read_noted(&taken.file).unwrap().mesh, taken.mesh);
                read_well += 1;
            }
        }
    }
    assert!(read_well > 100, "{read_well}");
}
