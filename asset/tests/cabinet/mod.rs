//! A cabinet with a door, a drawer, a screw cap and a foot, for the tests of this crate.

#![allow(dead_code, unreachable_pub, reason = "each test file takes what it needs")]

use asset::{Asset, BuildOptions, build};
use object::{
    ArticulatedObject, Condition, DVec3, JointKind, JointMotion, KinematicTree, Mesh, Part, Range,
};

/// Twelve outward triangles of a block.
fn block(min: DVec3, max: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let pick = |i: u32, k: usize| if (i >> k) & 1 == 1 { max[k] } else { min[k] };
    let corners = (0..8).map(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2))).collect();
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    (corners, faces)
}

pub const BODY: usize = 0;
pub const DOOR: usize = 1;
pub const DRAWER: usize = 2;
pub const CAP: usize = 3;

/// Boxes of the parts, in units of two metres, standing off the origin.
pub fn blocks() -> [(DVec3, DVec3); 5] {
    let v = DVec3::new;
    [
        (v(1.0, 1.0, 1.0), v(1.3, 1.2, 1.4)),
        (v(1.0, 0.985, 1.2), v(1.3, 0.995, 1.4)),
        (v(1.01, 0.985, 1.01), v(1.29, 0.995, 1.19)),
        (v(1.1, 1.05, 1.402), v(1.14, 1.09, 1.44)),
        (v(1.02, 1.02, 0.98), v(1.28, 1.18, 0.999)),
    ]
}

fn motion(kind: JointKind, axis: DVec3, pivot: DVec3, lower: f64, upper: f64) -> JointMotion {
    let range = match kind {
        JointKind::Continuous => Range::Continuous,
        _ => Range::Limits { lower, upper },
    };
    JointMotion { kind, axis, pivot, range }
}

/// The object.
pub fn cabinet() -> ArticulatedObject {
    let v = DVec3::new;
    let joints = vec![
        vec![],
        vec![motion(JointKind::Revolute, DVec3::NEG_Z, v(1.0, 0.985, 1.3), 0.0, 1.5)],
        vec![motion(JointKind::Prismatic, DVec3::NEG_Y, v(1.15, 0.99, 1.1), 0.0, 0.01)],
        vec![
            motion(JointKind::Prismatic, DVec3::Z, v(1.12, 1.07, 1.402), 0.0, 0.01),
            motion(JointKind::Continuous, DVec3::Z, v(1.12, 1.07, 1.402), 0.0, 0.0),
        ],
        vec![],
    ];
    let names = ["body", "door", "drawer", "Drawer_cap", "foot"];
    let part = |(i, name): (usize, &&str)| Part {
        name: (*name).into(),
        text: name.replace('_', " "),
        parent: (i > 0).then_some(0),
        joints: joints[i].iter().map(|m| m.kind).collect(),
    };
    let tree = KinematicTree::new(names.iter().enumerate().map(part).collect()).unwrap();
    let (mut vertices, mut faces, mut labels) = (vec![], vec![], vec![]);
    for (part, (min, max)) in blocks().into_iter().enumerate() {
        let (corners, triangles) = block(min, max);
        let first = vertices.len() as u32;
        vertices.extend(corners);
        faces.extend(triangles.iter().map(|t| t.map(|i| i + first)));
        labels.extend([part as u16; 12]);
    }
    let mesh = Mesh::new(vertices, faces).unwrap();
    ArticulatedObject::new(mesh, tree, labels, joints).unwrap()
}

/// Two metres per unit: the cabinet is 0.92 m high.
pub fn condition() -> Condition {
    Condition::from_json(
        r#"{"schema": "kinfold-condition/1", "category": "Cabinet & <co>", "size": {"height": 0.92},
            "parts": [
              {"name": "body", "material": "oak", "density": 600},
              {"name": "door", "parent": "body", "joint": "revolute", "material": "steel", "density": 7800},
              {"name": "drawer", "parent": "body", "joint": "prismatic", "mass": 2.5},
              {"name": "cap", "parent": "body", "joint": ["prismatic", "continuous"]}]}"#,
    )
    .unwrap()
}

/// Which part of the object each part of the condition is.
pub const MAP: [Option<usize>; 4] = [Some(BODY), Some(DOOR), Some(DRAWER), Some(CAP)];

/// The asset made of it.
pub fn built() -> Asset {
    build(&cabinet(), &condition(), &MAP, &BuildOptions::default()).unwrap()
}
