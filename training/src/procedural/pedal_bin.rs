//! A pedal bin: a round can, a lid hinged at the back, a pedal in front.

use object::{DVec3, JointKind, JointMotion};

use super::piece::{Piece, limits};
use super::shapes::{Shape, block, turned};

const STEEL: [u8; 3] = [186, 190, 196];
const BLACK: [u8; 3] = [48, 50, 54];
const RIM: f64 = 0.36;
const R: f64 = 0.12;

pub(super) fn pieces() -> Vec<Piece> {
    vec![can(), lid(), pedal()]
}

fn can() -> Piece {
    let profile = [(R, 0.0), (R, RIM), (R - 0.006, RIM), (R - 0.006, 0.05)];
    let bracket = block([-0.05, R - 0.004, RIM - 0.06], [0.05, R + 0.02, RIM - 0.005], BLACK);
    Piece {
        name: "can",
        text: "bin body",
        material: "stainless steel",
        parent: None,
        motions: vec![],
        point: DVec3::new(R, 0.0, 0.2),
        shape: turned(&profile, 64, STEEL).with(bracket),
    }
}

fn lid() -> Piece {
    let profile = [(R + 0.003, 0.0), (R + 0.003, 0.012), (R - 0.03, 0.034), (0.03, 0.042)];
    let tongue = block([-0.04, R - 0.02, RIM + 0.002], [0.04, R + 0.022, RIM + 0.012], BLACK);
    Piece {
        name: "lid",
        text: "lid",
        material: "abs plastic",
        parent: Some(0),
        motions: vec![JointMotion {
            kind: JointKind::Revolute,
            axis: DVec3::NEG_X,
            pivot: DVec3::new(0.0, R + 0.02, RIM + 0.002),
            range: limits(0.0, 1.4),
        }],
        point: DVec3::new(0.0, -0.0, RIM + 0.002 + 0.042),
        shape: turned(&profile, 64, BLACK).at(0.0, 0.0, RIM + 0.002).with(tongue),
    }
}

fn pedal() -> Piece {
    let (near, far) = (-R - 0.07, -R - 0.004);
    let plate = |y: [f64; 2], x: f64, z: [f64; 2]| block([-x, y[0], z[0]], [x, y[1], z[1]], BLACK);
    let shape: Shape = plate([near, far], 0.045, [0.028, 0.036]);
    Piece {
        name: "pedal",
        text: "foot pedal",
        material: "abs plastic",
        parent: Some(0),
        motions: vec![JointMotion {
            kind: JointKind::Revolute,
            axis: DVec3::X,
            pivot: DVec3::new(0.0, far, 0.032),
            range: limits(0.0, 0.3),
        }],
        point: DVec3::new(0.0, near + 0.02, 0.036),
        shape,
    }
}
