//! A hand cart: a deck with a push bar, four wheels that turn without end.

use std::f64::consts::FRAC_PI_2;

use object::{DPose3, DVec3, JointKind, JointMotion, Range};

use super::piece::Piece;
use super::shapes::{Shape, block, cylinder, turned};

const RED: [u8; 3] = [176, 58, 50];
const STEEL: [u8; 3] = [150, 154, 160];
const RUBBER: [u8; 3] = [52, 54, 58];
/// Radius of a wheel, and where the axles lie: half the track and half the wheelbase, metres.
const R: f64 = 0.06;
const TRACK: f64 = 0.2;
const BASE: f64 = 0.26;

pub(super) fn pieces() -> Vec<Piece> {
    let wheels = [
        ("front_left_wheel", "front left wheel", [-1.0, -1.0]),
        ("front_right_wheel", "front right wheel", [1.0, -1.0]),
        ("rear_left_wheel", "rear left wheel", [-1.0, 1.0]),
        ("rear_right_wheel", "rear right wheel", [1.0, 1.0]),
    ];
    let wheels = wheels.map(|(name, text, side)| wheel(name, text, side));
    std::iter::once(deck()).chain(wheels).collect()
}

fn deck() -> Piece {
    let (low, high) = (2.0 * R + 0.02, 2.0 * R + 0.05);
    let board = block([-0.2, -0.34, low], [0.2, 0.34, high], RED);
    let post = |x: f64| block([x - 0.012, 0.31, high], [x + 0.012, 0.334, 0.8], STEEL);
    let bar = block([-0.192, 0.31, 0.8], [0.192, 0.334, 0.824], STEEL);
    let bearing = |y: f64| block([-0.15, y - 0.02, R - 0.02], [0.15, y + 0.02, low], STEEL);
    Piece {
        name: "deck",
        text: "cart deck with push bar",
        material: "steel",
        parent: None,
        motions: vec![],
        point: DVec3::new(0.0, 0.0, high),
        shape: board
            .with(post(-0.18))
            .with(post(0.18))
            .with(bar)
            .with(bearing(-BASE))
            .with(bearing(BASE)),
    }
}

fn wheel(name: &'static str, text: &'static str, [x, y]: [f64; 2]) -> Piece {
    let tyre = [(R - 0.012, -0.018), (R, -0.012), (R, 0.012), (R - 0.012, 0.018)];
    let hub = cylinder(0.016, 0.018, 0.026, STEEL);
    let shape: Shape = turned(&tyre, 48, RUBBER).with(hub);
    let centre = DVec3::new(x * TRACK, y * BASE, R);
    let outward = DPose3::rotation(DVec3::Y * (FRAC_PI_2 * x));
    Piece {
        name,
        text,
        material: "rubber",
        parent: Some(0),
        motions: vec![JointMotion {
            kind: JointKind::Continuous,
            axis: DVec3::X,
            pivot: centre,
            range: Range::Continuous,
        }],
        point: centre + DVec3::X * (0.026 * x),
        shape: shape.moved(outward).at(centre.x, centre.y, centre.z),
    }
}
