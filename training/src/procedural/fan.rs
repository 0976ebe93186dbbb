//! A table fan: a foot with a post, a head that tilts, blades that turn without end.

use std::f64::consts::{FRAC_PI_2, TAU};

use object::{DPose3, DVec3, JointKind, JointMotion, Range};

use super::piece::{Piece, limits};
use super::shapes::{Shape, block, cylinder, turned};

const CREAM: [u8; 3] = [236, 230, 214];
const TEAL: [u8; 3] = [62, 132, 136];
const GREY: [u8; 3] = [96, 100, 106];
/// Height of the head's axis, metres.
const AXLE: f64 = 0.3;

pub(super) fn pieces() -> Vec<Piece> {
    vec![foot(), head(), blades()]
}

fn foot() -> Piece {
    let plate = turned(&[(0.11, 0.0), (0.11, 0.015), (0.09, 0.025)], 64, CREAM);
    let post = cylinder(0.014, 0.025, 0.22, GREY);
    let prong = |x: f64| block([x - 0.006, -0.018, 0.22], [x + 0.006, 0.018, AXLE + 0.02], GREY);
    let bridge = block([-0.062, -0.018, 0.208], [0.062, 0.018, 0.22], GREY);
    Piece {
        name: "foot",
        text: "fan base with post",
        material: "abs plastic",
        parent: None,
        motions: vec![],
        point: DVec3::new(0.1, 0.0, 0.02),
        shape: plate.with(post).with(bridge).with(prong(-0.056)).with(prong(0.056)),
    }
}

fn head() -> Piece {
    let profile = [(0.02, -0.07), (0.045, -0.05), (0.045, 0.03), (0.03, 0.045)];
    let motor = turned(&profile, 48, TEAL).moved(facing());
    let spindle = cylinder(0.008, 0.045, 0.062, GREY).moved(facing());
    Piece {
        name: "head",
        text: "motor housing that tilts",
        material: "abs plastic",
        parent: Some(0),
        motions: vec![JointMotion {
            kind: JointKind::Revolute,
            axis: DVec3::X,
            pivot: DVec3::new(0.0, 0.0, AXLE),
            range: limits(-0.4, 0.4),
        }],
        point: DVec3::new(0.0, 0.0, AXLE + 0.045),
        shape: motor.with(spindle).at(0.0, 0.0, AXLE),
    }
}

fn blades() -> Piece {
    let hub = turned(&[(0.022, 0.064), (0.022, 0.085), (0.012, 0.092)], 48, CREAM);
    let blade = |i: u32| {
        let pitch = DPose3::rotation(DVec3::X * 0.45);
        let spread = DPose3::rotation(DVec3::Z * (TAU * f64::from(i) / 4.0));
        let flat: Shape = block([0.018, -0.026, -0.0015], [0.12, 0.026, 0.0015], CREAM);
        flat.moved(spread * DPose3::from_translation(DVec3::Z * 0.0765) * pitch)
    };
    let shape = (0..4).map(blade).fold(hub, Shape::with);
    Piece {
        name: "blades",
        text: "fan blades",
        material: "abs plastic",
        parent: Some(1),
        motions: vec![JointMotion {
            kind: JointKind::Continuous,
            axis: DVec3::NEG_Y,
            pivot: DVec3::new(0.0, -0.075, AXLE),
            range: Range::Continuous,
        }],
        point: DVec3::new(0.0, -0.092, AXLE),
        shape: shape.moved(facing()).at(0.0, 0.0, AXLE),
    }
}

/// Turns what was built along +z to face the viewer, along −y.
fn facing() -> DPose3 {
    DPose3::rotation(DVec3::X * FRAC_PI_2)
}
