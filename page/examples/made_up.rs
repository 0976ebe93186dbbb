//! Writes the page of a made-up cabinet to the file named: `cargo run --example made_up -- page.html`.
#![allow(clippy::expect_used, reason = "a program for people who look at the page")]

use glamx::{DMat3, DPose3, DVec3};
use object::Mesh;
use page::{Check, Evidence, Inertial, Joint, Kind, Line, Link, Place, Scene, Status, Tier};

fn block(low: [f64; 3], high: [f64; 3], colour: [u8; 4]) -> Mesh {
    let at = |i: usize, k: usize| if (i >> k) & 1 == 1 { high[k] } else { low[k] };
    let vertices = (0..8).map(|i| DVec3::new(at(i, 0), at(i, 1), at(i, 2))).collect();
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = Mesh::new(vertices, faces).expect("a block");
    mesh.with_colours(Some(vec![colour; 8])).expect("its colours")
}

fn together(meshes: &[Mesh]) -> Mesh {
    let (mut vertices, mut faces, mut colours) = (vec![], vec![], vec![]);
    for mesh in meshes {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(mesh.vertices());
        faces.extend(mesh.faces().iter().map(|f| f.map(|v| v + first)));
        colours.extend_from_slice(mesh.colours().unwrap_or_default());
    }
    Mesh::new(vertices, faces).and_then(|m| m.with_colours(Some(colours))).expect("blocks")
}

fn link(name: &str, mass: f64, blocks: Vec<Mesh>) -> Link {
    let visual = together(&blocks);
    let frame = DPose3::from_translation(visual.bounds().centre());
    let side = visual.bounds().size() / 2.0;
    let square = side * side;
    let moments = DVec3::new(square.y + square.z, square.x + square.z, square.x + square.y);
    let inertia = DMat3::from_diagonal(moments * (mass / 3.0));
    let inertial = Some(Inertial { mass, frame, inertia });
    Link { name: name.into(), facts: vec![], visual: Some(visual), collisions: blocks, inertial }
}

fn joint(
    name: &str,
    kind: Kind,
    child: usize,
    at: [f64; 3],
    axis: DVec3,
    range: [f64; 2],
) -> Joint {
    let origin = DPose3::from_translation(DVec3::from_array(at));
    Joint {
        name: name.into(),
        kind,
        parent: 0,
        child,
        origin,
        axis,
        range: Some(range),
        mimic: None,
        facts: vec![],
    }
}

fn main() {
    let (oak, cream, brass) = ([150, 105, 62, 255], [228, 214, 186, 255], [196, 158, 70, 255]);
    let body = vec![
        block([-0.3, -0.2, 0.0], [-0.28, 0.2, 0.7], oak),
        block([0.28, -0.2, 0.0], [0.3, 0.2, 0.7], oak),
        block([-0.28, -0.2, 0.0], [0.28, 0.2, 0.03], oak),
        block([-0.28, -0.2, 0.67], [0.28, 0.2, 0.7], oak),
        block([-0.28, 0.18, 0.03], [0.28, 0.2, 0.67], oak),
        block([-0.28, -0.18, 0.46], [0.28, 0.18, 0.48], oak),
    ];
    let drawer = vec![
        block([-0.27, -0.22, -0.08], [0.27, -0.2, 0.08], cream),
        block([-0.26, -0.2, -0.08], [0.26, 0.16, -0.06], oak),
        block([-0.26, -0.2, -0.06], [-0.24, 0.16, 0.05], oak),
        block([0.24, -0.2, -0.06], [0.26, 0.16, 0.05], oak),
        block([-0.05, -0.25, -0.01], [0.05, -0.22, 0.01], brass),
    ];
    let door = vec![
        block([0.0, -0.02, 0.0], [0.54, 0.0, 0.4], cream),
        block([0.48, -0.05, 0.17], [0.5, -0.02, 0.25], brass),
    ];
    let links =
        vec![link("body", 11.2, body), link("drawer", 2.4, drawer), link("door", 1.7, door)];
    let joints = vec![
        joint("drawer_slide", Kind::Prismatic, 1, [0.0, 0.0, 0.575], DVec3::NEG_Y, [0.0, 0.3]),
        joint("door_hinge", Kind::Revolute, 2, [-0.27, -0.2, 0.045], DVec3::NEG_Z, [0.0, 1.9]),
    ];
    let found = Evidence {
        text: "joint `door_hinge` at 96.0 deg: `door` and `body` overlap by 3.20 mm".into(),
        pose: vec![(1, 1.675)],
        place: Some(Place { link: 0, at: DVec3::new(-0.28, -0.2, 0.25) }),
        links: vec![2, 0],
    };
    let check = |id: &str, rule: &str, status, evidence| Check {
        id: id.into(),
        rule: rule.into(),
        status,
        figure: String::new(),
        bound: String::new(),
        evidence,
    };
    let checks = vec![
        check("F1", "the file can be read", Status::Pass, vec![]),
        check("C2", "no parts overlap along any joint's range", Status::Fail, vec![found]),
        check(
            "P1",
            "the trace is whole",
            Status::Unknown,
            vec![Evidence { text: "nobody read it".into(), ..Evidence::default() }],
        ),
    ];
    let tier = Tier { name: "static".into(), reached: [2, 4], profile: "simready-urdf 1.0".into() };
    let about = vec![Line { label: "Made by".into(), text: "nobody, by hand".into() }];
    let scene = Scene {
        title: "cabinet".into(),
        tier: Some(tier),
        about,
        notes: vec![],
        links,
        joints,
        checks,
    };
    let path = std::env::args().nth(1).expect("the name of a file");
    std::fs::write(path, page::write(&scene)).expect("a page on the disk");
}
