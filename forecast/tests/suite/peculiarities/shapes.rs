//! Peculiar visuals, collisions and meshes.

use super::{BOX, Peculiar, SOLID};
use super::{boxed, felt, hinge, inertial, link, mesh, moving, robot, seen};

const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// What a box of the tetrahedron's extents and 1 kg weighs.
const BOXED: [f64; 3] = [0.05 / 12.0, 0.1 / 12.0, 0.13 / 12.0];

fn tetrahedron() -> Vec<u8> {
    let corners = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let faces = FACES.map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).concat();
    (corners + &faces).into_bytes()
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(4_u32.to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flat_map(|i| CORNERS[*i]).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text_stl() -> Vec<u8> {
    let corner = |i: usize| {
        let [x, y, z] = CORNERS[i];
        format!("vertex {x} {y} {z}\n")
    };
    let face = |f: [usize; 3]| {
        let corners = f.map(corner).concat();
        format!("facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid t\n{}endsolid\n", FACES.map(face).concat()).into_bytes()
}

fn glb() -> Vec<u8> {
    let mut data: Vec<u8> = CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let indices = FACES.iter().flatten().map(|i| u32::try_from(*i).unwrap());
    data.extend(indices.flat_map(u32::to_le_bytes));
    let mut text = br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
"buffers":[{"byteLength":96}],"bufferViews":[{"buffer":0,"byteLength":48},
{"buffer":0,"byteOffset":48,"byteLength":48}],"accessors":[{"bufferView":0,"componentType":5126,
"count":4,"type":"VEC3","min":[0,0,0],"max":[0.3,0.2,0.1]},
{"bufferView":1,"componentType":5125,"count":12,"type":"SCALAR"}]}"#
        .to_vec();
    while !text.len().is_multiple_of(4) {
        text.push(b' ');
    }
    let length = |n: usize| u32::try_from(n).unwrap().to_le_bytes();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(length(28 + text.len() + data.len()));
    bytes.extend(length(text.len()));
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend(length(data.len()));
    bytes.extend(b"BIN\0");
    bytes.extend(data);
    bytes
}

/// A closed L of 1 m, 0.2 m thick.
fn ell() -> Vec<u8> {
    let outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.2), (0.2, 0.2), (0.2, 1.0), (0.0, 1.0)];
    let mut text = String::new();
    for z in [0.0, 0.2] {
        text += &outline.map(|(x, y)| format!("v {x} {y} {z}\n")).concat();
    }
    for (b, c) in [(2, 3), (3, 4), (4, 5), (5, 6)] {
        text += &format!("f 1 {c} {b}\nf 7 {} {}\n", b + 6, c + 6);
    }
    for a in 1..=6 {
        let b = a % 6 + 1;
        text += &format!("f {a} {b} {}\nf {a} {} {}\n", b + 6, b + 6, a + 6);
    }
    text.into_bytes()
}

/// A ball of 0.1 m with 640 faces.
fn ball() -> Vec<u8> {
    let (rings, sides) = (17_u32, 20_u32);
    let mut text = "v 0 0 0.1\nv 0 0 -0.1\n".to_string();
    for ring in 1..rings {
        for side in 0..sides {
            let up = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
            let around = std::f64::consts::TAU * f64::from(side) / f64::from(sides);
            let (x, y) = (up.sin() * around.cos(), up.sin() * around.sin());
            text += &format!("v {} {} {}\n", 0.1 * x, 0.1 * y, 0.1 * up.cos());
        }
    }
    let at = |ring: u32, side: u32| 3 + (ring - 1) * sides + side % sides;
    for side in 0..sides {
        text += &format!("f 1 {} {}\n", at(1, side), at(1, side + 1));
        text += &format!("f 2 {} {}\n", at(rings - 1, side + 1), at(rings - 1, side));
        for ring in 1..rings - 1 {
            let (a, b) = (at(ring, side), at(ring, side + 1));
            let (c, d) = (at(ring + 1, side), at(ring + 1, side + 1));
            text += &format!("f {a} {c} {d}\nf {a} {d} {b}\n");
        }
    }
    text.into_bytes()
}

/// The usual file, its moving link felt by this mesh.
fn felt_mesh(
    name: &'static str,
    filename: &str,
    moments: [f64; 3],
    beside: Vec<(&'static str, Vec<u8>)>,
    rules: &'static str,
) -> Peculiar {
    let a = link("a", &inertial(1.0, moments), &felt(&mesh(filename)));
    Peculiar { beside, ..moving(name, a, rules) }
}

/// The usual file, its moving link seen so.
fn seen_as(name: &'static str, visuals: &str, rules: &'static str) -> Peculiar {
    moving(name, link("a", &inertial(1.0, SOLID), &(visuals.to_string() + &felt(BOX))), rules)
}

pub(crate) fn files() -> Vec<Peculiar> {
    let mut files = meshes();
    files.extend(names());
    files
}

fn meshes() -> Vec<Peculiar> {
    let file = |name: &'static str, bytes: Vec<u8>| vec![(name, bytes)];
    let sheet = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n".to_vec();
    let dented = [1.04 / 12.0, 1.04 / 12.0, 2.0 / 12.0];
    vec![
        felt_mesh("felt_obj", "t.obj", BOXED, file("t.obj", tetrahedron()), ""),
        felt_mesh(
            "felt_glb",
            "t.glb",
            BOXED,
            file("t.glb", glb()),
            "mujoco.mesh-format pybullet.mesh-format drake.mesh-format isaac.mesh-format",
        ),
        Peculiar {
            beside: file("t.glb", glb()),
            ..seen_as(
                "seen_glb",
                &seen(&mesh("t.glb")),
                "mujoco.visuals-dropped pybullet.mesh-format isaac.mesh-format",
            )
        },
        felt_mesh("felt_stl", "t.stl", BOXED, file("t.stl", binary_stl()), "drake.mesh-format"),
        felt_mesh(
            "felt_text_stl",
            "t.stl",
            BOXED,
            file("t.stl", text_stl()),
            "mujoco.stl-text drake.mesh-format",
        ),
        felt_mesh(
            "felt_sheet",
            "sheet.obj",
            [1.0 / 12.0, 1.0 / 12.0, 1.0 / 6.0],
            file("sheet.obj", sheet),
            "mujoco.mesh-flat",
        ),
        felt_mesh(
            "felt_missing",
            "none.obj",
            BOXED,
            vec![],
            "mujoco.mesh-missing pybullet.mesh-missing drake.mesh-missing newton.mesh-missing \
             isaac.mesh-missing sapien.mesh-missing genesis.mesh-missing rerun.mesh-missing",
        ),
        seen_as(
            "seen_missing",
            &seen(&mesh("none.obj")),
            "mujoco.visuals-dropped pybullet.mesh-missing drake.mesh-missing newton.mesh-missing \
             isaac.mesh-missing genesis.mesh-missing rerun.mesh-missing",
        ),
        felt_mesh(
            "felt_package",
            "package://nobody/t.obj",
            BOXED,
            vec![],
            "mujoco.mesh-uri pybullet.mesh-package drake.mesh-package newton.mesh-uri \
             isaac.mesh-package sapien.mesh-uri genesis.mesh-package rerun.mesh-package",
        ),
        felt_mesh(
            "felt_package_near",
            "package://near/t.obj",
            BOXED,
            file("near/t.obj", tetrahedron()),
            "mujoco.mesh-uri drake.mesh-package newton.mesh-uri isaac.mesh-package \
             rerun.mesh-package",
        ),
        felt_mesh(
            "felt_file_uri",
            "file://FOLDER/t.obj",
            BOXED,
            file("t.obj", tetrahedron()),
            "mujoco.mesh-uri newton.mesh-uri sapien.mesh-uri genesis.mesh-file-uri",
        ),
        felt_mesh(
            "felt_concave",
            "ell.obj",
            dented,
            file("ell.obj", ell()),
            "mujoco.concave pybullet.concave drake.concave isaac.concave sapien.concave \
             genesis.concave",
        ),
        felt_mesh(
            "felt_of_many_faces",
            "ball.obj",
            [0.08 / 12.0; 3],
            file("ball.obj", ball()),
            "genesis.faces-decimated",
        ),
    ]
}

fn names() -> Vec<Peculiar> {
    let colours = b"mtllib t.mtl\nv 0 0 0\nv 0.3 0 0\nv 0 0.2 0\nv 0 0 0.1\nusemtl red\nf 1 3 2\n\
                    f 1 2 4\nusemtl blue\nf 1 4 3\nf 2 3 4\n";
    let paints = b"newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n";
    let capsule = "<geometry><capsule radius='0.1' length='0.3'/></geometry>";
    let twice = format!("<collision name='x'>{BOX}</collision>").repeat(2);
    let two = link("a", &inertial(1.0, SOLID), &twice);
    let bare = format!("<visual>{BOX}<material name='nobody'/></visual>");
    vec![
        seen_as("seen", &seen(BOX), "mujoco.visuals-dropped"),
        moving(
            "capsule",
            link("a", &inertial(1.0, SOLID), &felt(capsule)),
            "isaac.capsule-dropped",
        ),
        seen_as(
            "material_undefined",
            &bare,
            "mujoco.visuals-dropped pybullet.material-undefined drake.material-undefined",
        ),
        Peculiar {
            beside: vec![("t.obj", colours.to_vec()), ("t.mtl", paints.to_vec())],
            ..seen_as(
                "two_colours",
                &seen(&mesh("t.obj")),
                "mujoco.visuals-dropped pybullet.mesh-colours",
            )
        },
        robot("collision_twice", &[boxed("base"), two, hinge()], "rerun.collision-name-twice"),
        seen_as(
            "visual_twice",
            &format!("<visual name='x'>{BOX}</visual>").repeat(2),
            "mujoco.visuals-dropped rerun.visual-name-twice",
        ),
    ]
}
