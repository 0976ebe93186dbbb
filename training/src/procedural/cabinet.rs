//! A bedside cabinet: a drawer above, a door below, each with a knob.

use object::{DPose3, DVec3, JointKind, JointMotion};

use super::piece::{Piece, limits};
use super::shapes::{Shape, block, turned};

const OAK: [u8; 3] = [178, 132, 84];
const FRONT: [u8; 3] = [226, 220, 208];
const BRASS: [u8; 3] = [196, 164, 74];
/// Half the width, half the depth, the height and the thickness of the boards, metres.
const W: f64 = 0.25;
const D: f64 = 0.2;
const H: f64 = 0.6;
const T: f64 = 0.018;
/// Where the shelf between drawer and door lies, and the gap around the fronts.
const SHELF: f64 = 0.4;
const GAP: f64 = 0.002;

pub(super) fn pieces() -> Vec<Piece> {
    vec![body(), drawer(), door()]
}

fn body() -> Piece {
    let side = |x: f64| block([x, -D, 0.0], [x + T, D, H], OAK);
    let shelf = |z: f64| block([-W + T, -D, z], [W - T, D - T, z + T], OAK);
    let back = block([-W + T, D - T, 0.0], [W - T, D, H], OAK);
    let shape = side(-W).with(side(W - T)).with(back);
    Piece {
        name: "body",
        text: "cabinet body",
        material: "oak",
        parent: None,
        motions: vec![],
        point: DVec3::new(-W, 0.0, 0.3),
        shape: shape.with(shelf(0.03)).with(shelf(SHELF)).with(shelf(H - T)),
    }
}

fn drawer() -> Piece {
    let (low, high) = (SHELF + T + GAP, H - T - GAP);
    let (x, y) = (W - T - GAP, D - T - 0.02);
    let wall = |min, max| block(min, max, OAK);
    let t = 0.012;
    let shape = block([-x, -D, low], [x, -D + T, high], FRONT)
        .with(wall([-x, -D + T, low], [x, y, low + t]))
        .with(wall([-x, -D + T, low + t], [-x + t, y, high - 0.03]))
        .with(wall([x - t, -D + T, low + t], [x, y, high - 0.03]))
        .with(wall([-x + t, y - t, low + t], [x - t, y, high - 0.03]))
        .with(knob().at(0.0, -D, (low + high) / 2.0));
    Piece {
        name: "drawer",
        text: "drawer",
        material: "oak",
        parent: Some(0),
        motions: vec![JointMotion {
            kind: JointKind::Prismatic,
            axis: DVec3::NEG_Y,
            pivot: DVec3::new(0.0, -D, low),
            range: limits(0.0, 0.3),
        }],
        point: DVec3::new(0.1, -D, (low + high) / 2.0),
        shape,
    }
}

fn door() -> Piece {
    let (low, high, x) = (0.03 + T + GAP, SHELF - GAP, W - T - GAP);
    let panel = block([-x, -D, low], [x, -D + T, high], FRONT);
    Piece {
        name: "door",
        text: "door",
        material: "oak",
        parent: Some(0),
        motions: vec![JointMotion {
            kind: JointKind::Revolute,
            axis: DVec3::NEG_Z,
            pivot: DVec3::new(-x, -D, low),
            range: limits(0.0, 1.9),
        }],
        point: DVec3::new(-0.1, -D, 0.2),
        shape: panel.with(knob().at(x - 0.04, -D, (low + high) / 2.0)),
    }
}

/// A turned knob that grows out of the plane y = 0 towards the viewer.
fn knob() -> Shape {
    let profile = [(0.006, 0.0), (0.006, 0.012), (0.014, 0.018), (0.014, 0.026), (0.008, 0.031)];
    let towards_viewer = DPose3::rotation(DVec3::X * std::f64::consts::FRAC_PI_2);
    turned(&profile, 24, BRASS).moved(towards_viewer)
}
