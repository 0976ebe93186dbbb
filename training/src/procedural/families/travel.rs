//! On the road: bicycles and suitcases.

use std::f64::consts::{FRAC_PI_2, TAU};

use object::DVec3;

use super::super::draft::{Dice, Draft, at, cuboid, hinge, placed, rod, slide, spin, tray, words};
use super::super::shapes::Shape;

/// A tyre and spokes about an axle along x.
fn wheel(hub: DVec3, radius: f64) -> Shape {
    let point = |k: usize| {
        let turn = TAU * k as f64 / 20.0;
        hub + at(0.0, radius * turn.cos(), radius * turn.sin())
    };
    let axle = rod(hub - DVec3::X * 0.04, hub + DVec3::X * 0.04, 0.02);
    let rim = (0..20).fold(axle, |shape, k| shape.with(rod(point(k), point(k + 1), 0.016)));
    (0..10).fold(rim, |shape, k| shape.with(rod(hub, point(2 * k), 0.003)))
}

pub(super) fn bicycle(dice: &mut Dice) -> Draft {
    let (r, base) = (dice.between(0.27, 0.35), dice.between(0.95, 1.1));
    let (rear, crank) = (at(0.0, base / 2.0, r), at(0.0, 0.08, r - 0.04));
    let (seat, head) = (at(0.0, 0.18, 0.8), at(0.0, -0.32, 0.82));
    let neck = at(0.0, -0.35, 0.65);
    let tubes =
        [(crank, seat), (seat, head), (crank, neck), (head, neck), (crank, rear), (seat, rear)];
    let shift = |p: DVec3, x: f64| if p == rear { p + DVec3::X * x } else { p };
    let tube = |shape: Shape, &(a, b): &(DVec3, DVec3)| {
        if a == rear || b == rear {
            let sides = [-0.05, 0.05].map(|x| rod(shift(a, x), shift(b, x), 0.009));
            return sides.into_iter().fold(shape, Shape::with);
        }
        shape.with(rod(a, b, 0.016))
    };
    let frame = tubes.iter().fold(Shape::default(), tube);
    let mut draft = Draft::new(words(&["bicycle frame", "frame", "bike frame"]), frame);
    let saddle = cuboid(seat + at(0.0, 0.0, 0.14), at(0.14, 0.25, 0.05));
    let post = rod(seat, seat + DVec3::Z * 0.12, 0.012);
    let motion = slide(DVec3::Z, seat, dice.between(0.05, 0.15));
    draft.add(0, words(&["saddle", "seat", "bicycle seat"]), vec![motion], saddle.with(post));
    let steer = (head - neck).normalize();
    let front = at(0.0, -base / 2.0, r);
    let bar = head + steer * 0.1;
    let fork = [-0.05, 0.05].map(|x| rod(neck + DVec3::X * x, front + DVec3::X * x, 0.01));
    let crown = rod(neck - DVec3::X * 0.055, neck + DVec3::X * 0.055, 0.014);
    let fork = fork.into_iter().fold(crown, Shape::with).with(rod(head, bar, 0.014));
    let fork = fork.with(rod(bar - DVec3::X * 0.28, bar + DVec3::X * 0.28, 0.012));
    let names = words(&["handlebar", "handlebar with fork", "front fork", "steering"]);
    let fork = draft.add(0, names, vec![hinge(steer, head, -0.9, 0.9)], fork);
    draft.add(fork, words(&["front wheel"]), vec![spin(DVec3::X, front)], wheel(front, r - 0.02));
    let names = words(&["rear wheel", "back wheel"]);
    draft.add(0, names, vec![spin(DVec3::X, rear)], wheel(rear, r - 0.02));
    let axle = rod(crank - DVec3::X * 0.07, crank + DVec3::X * 0.07, 0.02);
    let ends = [1.0, -1.0].map(|s| crank + at(s * 0.07, 0.0, s * 0.16));
    let arms =
        ends.iter().fold(axle, |shape, &e| shape.with(rod(at(e.x, crank.y, crank.z), e, 0.009)));
    let crank = draft.add(
        0,
        words(&["crank", "crankset", "pedal crank"]),
        vec![spin(DVec3::X, crank)],
        arms,
    );
    for (place, end) in [("right", ends[0]), ("left", ends[1])] {
        let middle = end + DVec3::X * 0.045 * end.x.signum();
        let pedal = cuboid(middle, at(0.07, 0.08, 0.02));
        draft.add(crank, placed(&[place], &["pedal"]), vec![spin(DVec3::X, end)], pedal);
    }
    draft
}

pub(super) fn suitcase(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.35, 0.5), dice.between(0.2, 0.32), dice.between(0.5, 0.75));
    let half = d / 2.0;
    let turn = object::DPose3::rotation(DVec3::X * FRAC_PI_2);
    let shell = |deep: f64| tray(at(-w / 2.0, 0.0, 0.0), at(w / 2.0, h, deep), 0.008);
    let back = shell(half).moved(turn).moved(object::DPose3::from_translation(at(0.0, half, 0.05)));
    let names = words(&["suitcase body", "suitcase shell", "back shell"]);
    let mut draft = Draft::new(names, back);
    let flip = object::DPose3::rotation(DVec3::Z * std::f64::consts::PI);
    let front = shell(half - 0.003).moved(turn);
    let front =
        front.moved(object::DPose3::from_translation(at(0.0, half - 0.003, 0.0))).moved(flip);
    let front = front.moved(object::DPose3::from_translation(at(0.0, -0.003, 0.05)));
    let motion = hinge(DVec3::NEG_Z, at(-w / 2.0, 0.0, 0.05), 0.0, dice.between(1.5, 3.1));
    draft.add(0, words(&["suitcase lid", "front shell", "cover"]), vec![motion], front);
    let (wide, up) = (0.4 * w, h + 0.05);
    let bar = |x: f64| rod(at(x, half - 0.02, up - 0.25), at(x, half - 0.02, up + 0.04), 0.006);
    let grip =
        rod(at(-wide / 2.0, half - 0.02, up + 0.04), at(wide / 2.0, half - 0.02, up + 0.04), 0.01);
    let shape = bar(-wide / 2.0).with(bar(wide / 2.0)).with(grip);
    let motion = slide(DVec3::Z, at(0.0, half - 0.02, up), dice.between(0.25, 0.45));
    let names = words(&["telescopic handle", "pull handle", "trolley handle"]);
    draft.add(0, names, vec![motion], shape);
    for (place, x, y) in [("left", -1.0, 1.0), ("right", 1.0, 1.0)] {
        let hub = at(x * (w / 2.0 - 0.03), y * (half - 0.03), 0.028);
        let disc = rod(hub - DVec3::X * 0.012, hub + DVec3::X * 0.012, 0.026);
        draft.add(
            0,
            placed(&[place], &["wheel", "suitcase wheel"]),
            vec![spin(DVec3::X, hub)],
            disc,
        );
    }
    draft
}
