//! What runs in slots, on rails and in tubes, and boards with fittings on plates of their own.

use std::f64::consts::{FRAC_PI_2, TAU};

use object::{DPose3, DVec3, JointKind, JointMotion, Range};

use super::super::draft::{
    Dice, Draft, at, cuboid, hinge, lathe, placed, rod, shell, slide, spin, words,
};
use super::super::shapes::Shape;

/// A plate across y through `middle` with a hole: their sizes along x and z, and where the hole's middle
/// lies from the plate's.
pub(super) struct Slotted {
    pub(super) middle: DVec3,
    pub(super) size: DVec3,
    pub(super) hole: [f64; 2],
    pub(super) off: [f64; 2],
}

impl Slotted {
    pub(super) fn shape(&self) -> Shape {
        let (half, [w, h], [x, z]) = (self.size / 2.0, self.hole.map(|s| s / 2.0), self.off);
        let piece = |[a, b]: [f64; 2], [c, e]: [f64; 2]| {
            let middle = self.middle + at((a + b) / 2.0, 0.0, (c + e) / 2.0);
            cuboid(middle, at(b - a, self.size.y, e - c))
        };
        let (left, right) = ([-half.x, x - w], [x + w, half.x]);
        let (full, across) = ([-half.z, half.z], [x - w, x + w]);
        piece(left, full)
            .with(piece(right, full))
            .with(piece(across, [-half.z, z - h]))
            .with(piece(across, [z + h, half.z]))
    }
}

/// How thick the walls of a housing are.
fn wall(size: DVec3) -> f64 {
    0.05 * size.min_element()
}

/// A box on the floor whose front has a hole.
fn housing(size: DVec3, hole: [f64; 2], off: [f64; 2]) -> Shape {
    let (wall, half) = (wall(size), size / 2.0);
    let box_of = shell(at(-half.x, -half.y + wall, 0.0), at(half.x, half.y, size.z), wall);
    let middle = at(0.0, -half.y + wall / 2.0, half.z);
    let front = Slotted { middle, size: at(size.x, wall, size.z), hole, off };
    box_of.with(front.shape())
}

/// A box with a slot, in which a handle goes from one end to the other: a press, a lever machine.
pub(super) fn slot_lever(dice: &mut Dice) -> Draft {
    let size = at(dice.between(0.08, 0.3), dice.between(0.08, 0.3), dice.between(0.1, 0.3));
    let lies = dice.chance(0.25);
    let (along, side) = if lies { (DVec3::X, DVec3::Z) } else { (DVec3::Z, DVec3::X) };
    let (room, across) = if lies { (size.x, size.z) } else { (size.z, size.x) };
    let (long, wide) = (dice.between(0.4, 0.8) * room, dice.between(0.08, 0.4) * across);
    let spare = ((room - long) / 2.0 - 1.2 * wall(size)).max(0.0);
    let shift = dice.between(-spare, spare);
    let hole = if lies { [long, wide] } else { [wide, long] };
    let off = if lies { [shift, 0.0] } else { [0.0, shift] };
    let body = housing(size, hole, off);
    let names = words(&["base", "housing", "machine body", "box", "press body", "frame"]);
    let mut draft = Draft::new(names, body);
    // As thick as a share of the slot; its middle goes from one end of what is left to the other.
    let thick = dice.between(0.3, 0.95) * wide;
    let high = (dice.between(0.4, 1.2) * thick).min(0.35 * long);
    let way = if dice.chance(0.75) { -1.0 } else { 1.0 };
    let (near, stroke) = (dice.between(0.0, 0.25) * (long - high), dice.between(0.8, 1.0));
    let start = shift - way * ((long - high) / 2.0 - near);
    let stroke = stroke * (long - high - near);
    let root = at(0.0, -size.y / 2.0, size.z / 2.0) + along * start;
    let (inside, out) = (dice.between(0.05, 0.6) * size.y, dice.between(0.15, 0.7) * size.y);
    let stem = cuboid(
        root + DVec3::Y * (inside - out) / 2.0,
        DVec3::Y * (inside + out) + along * high + side * thick,
    );
    let tip = root - DVec3::Y * out;
    let r = dice.between(0.5, 1.2) * high.max(0.012);
    let grip = match dice.count(0, 3) {
        0 | 1 => {
            let half = side * dice.between(0.2, 0.7) * across;
            rod(tip - half, tip + half, r)
        }
        2 => lathe(
            &[(0.5 * r, 0.0), (1.2 * r, r), (1.2 * r, 2.0 * r), (0.5 * r, 3.0 * r)],
            tip,
            DVec3::NEG_Y,
        ),
        _ => cuboid(
            tip - DVec3::Y * r,
            at(0.0, 2.0 * r, 0.0) + along * 1.3 * high + side * 1.5 * wide,
        ),
    };
    let names = words(&["handle", "lever", "press handle", "slide lever", "push lever", "grip"]);
    draft.add(0, names, vec![slide(along * way, root, stroke)], stem.with(grip));
    draft
}

/// A board with sliders side by side, each in its slot: upright, or lying on a desk.
pub(super) fn sliders(dice: &mut Dice) -> Draft {
    let count = dice.count(1, 5);
    let (pitch, long) = (dice.between(0.03, 0.06), dice.between(0.05, 0.14));
    let (wide, thick) = (dice.between(0.004, 0.012), dice.between(0.002, 0.006));
    let (high, deep) = (long + dice.between(0.03, 0.1), dice.between(0.02, 0.08));
    let pose = if dice.chance(0.5) {
        DPose3::rotation(DVec3::NEG_X * FRAC_PI_2)
    } else {
        DPose3::IDENTITY
    };
    let place = |i: usize| pitch * (i as f64 - (count as f64 - 1.0) / 2.0);
    let size = at(pitch * count as f64, deep, high);
    let mut body = cuboid(at(0.0, deep / 2.0 + 0.012, 0.0), size);
    for i in 0..count {
        let middle = at(place(i), thick / 2.0, 0.0);
        let (hole, off) = ([wide, long], [0.0; 2]);
        body = body.with(Slotted { middle, size: at(pitch, thick, high), hole, off }.shape());
    }
    for side in [-1.0, 1.0] {
        let rim = at(side * (size.x / 2.0 - 0.001), 0.006 + thick / 2.0, 0.0);
        body = body.with(cuboid(rim, at(0.002, 0.012 - thick, high)));
    }
    let names = words(&["console", "panel", "mixer body", "control board", "base"]);
    let mut draft = Draft::new(names, body.moved(pose));
    let cap =
        at(dice.between(0.5, 0.8) * pitch, dice.between(0.008, 0.02), dice.between(0.01, 0.03));
    for i in 0..count {
        let reach = 0.45 * (long - cap.z);
        let z = dice.between(-reach, reach);
        let root = at(place(i), 0.0, z);
        let stem = cuboid(root, at(0.7 * wide, 0.016, 0.6 * cap.z));
        let knob = cuboid(root - DVec3::Y * (0.006 + cap.y / 2.0), cap);
        let motion = JointMotion {
            kind: JointKind::Prismatic,
            axis: pose.rotation * DVec3::Z,
            pivot: pose * root,
            range: Range::Limits { lower: -reach - z, upper: reach - z },
        };
        let number = [format!("fader {}", i + 1), format!("slider {}", i + 1)];
        let names = number.into_iter().chain(words(&["slide control", "slider knob"])).collect();
        draft.add(0, names, vec![motion], stem.with(knob).moved(pose));
    }
    draft
}

/// A bolt that slides through staples on a plate: level, or upright as at the foot of a door.
pub(super) fn bolt(dice: &mut Dice) -> Draft {
    let (r, half) = (dice.between(0.004, 0.012), dice.between(0.04, 0.12));
    let turn = if dice.chance(0.3) { FRAC_PI_2 } else { 0.0 };
    let pose = DPose3::rotation(DVec3::Y * turn);
    let plate = cuboid(at(0.0, 0.003, 0.0), at(2.0 * half, 0.006, 6.0 * r));
    let staple = |x: f64| {
        let thin = 0.6 * r;
        let post = |z: f64| cuboid(at(x, -1.3 * r, z * 1.7 * r), at(0.4 * half, 2.6 * r, thin));
        post(1.0)
            .with(post(-1.0))
            .with(cuboid(at(x, -2.6 * r - thin / 2.0, 0.0), at(0.4 * half, thin, 4.0 * r)))
    };
    let stroke = dice.between(0.2, 0.45) * half;
    let keeper = staple(half + stroke + 0.2 * half);
    let foot = cuboid(at(half + stroke + 0.2 * half, 0.003, 0.0), at(0.4 * half, 0.006, 6.0 * r));
    let body = plate.with(staple(-0.75 * half)).with(staple(0.75 * half)).with(keeper).with(foot);
    let names = words(&["bolt plate", "latch body", "base plate", "base"]);
    let mut draft = Draft::new(names, body.moved(pose));
    let middle = at(0.0, -1.3 * r, 0.0);
    let bar = rod(middle - DVec3::X * 0.95 * half, middle + DVec3::X * half, r);
    let root = middle + DVec3::X * dice.between(-0.4, 0.0) * half;
    let tip = root - DVec3::Y * dice.between(2.0, 4.0) * r;
    let knob = rod(root, tip, 0.5 * r).with(lathe(&[(r, 0.0), (r, 1.2 * r)], tip, DVec3::NEG_Y));
    let names = words(&["bolt", "sliding bolt", "latch bolt", "bolt handle", "handle"]);
    let motion = slide(pose.rotation * DVec3::X, pose * middle, stroke);
    draft.add(0, names, vec![motion], bar.with(knob).moved(pose));
    draft
}

/// A piston in a tube, with a disc or a bar to push and pull: upright, or lying.
pub(super) fn plunger(dice: &mut Dice) -> Draft {
    let (r, h) = (dice.between(0.008, 0.05), dice.between(0.08, 0.4));
    let (wall, pulled) = (0.08 * r, dice.between(0.1, 0.9));
    let pose = match dice.count(0, 3) {
        0 => DPose3::rotation(DVec3::Y * FRAC_PI_2),
        1 => DPose3::rotation(DVec3::X * FRAC_PI_2),
        _ => DPose3::IDENTITY,
    };
    let profile = [(r, 0.0), (r, h), (r - wall, h), (r - wall, wall)];
    let mut body = lathe(&profile, DVec3::ZERO, DVec3::Z);
    if dice.chance(0.5) {
        body = body.with(lathe(&[(0.25 * r, -0.1 * h), (0.3 * r, 0.0)], DVec3::ZERO, DVec3::Z));
    }
    if dice.chance(0.5) {
        let ears = cuboid(at(0.0, 1.25 * r, 0.97 * h), at(1.2 * r, 0.5 * r, 0.02 * h));
        body =
            body.with(ears.clone()).with(ears.moved(DPose3::rotation(DVec3::Z * 2.0 * FRAC_PI_2)));
    }
    let names = words(&["barrel", "cylinder", "pump body", "tube", "syringe barrel"]);
    let mut draft = Draft::new(names, body.moved(pose));
    let (stroke, thick) = (0.85 * h, 0.06 * h);
    let foot = at(0.0, 0.0, wall + 0.01 * h + pulled * 0.6 * stroke);
    let top = foot + DVec3::Z * (0.95 * h + 0.02 * h);
    let piston = lathe(&[(0.97 * (r - wall), 0.0), (0.97 * (r - wall), thick)], foot, DVec3::Z);
    let stem = rod(foot + DVec3::Z * 0.5 * thick, top, dice.between(0.15, 0.45) * r);
    let head = if dice.chance(0.5) {
        let wide = dice.between(0.7, 1.3) * r;
        lathe(&[(wide, 0.0), (wide, 0.03 * h)], top, DVec3::Z)
    } else {
        let half = DVec3::X * dice.between(1.0, 2.5) * r;
        rod(top - half, top + half, 0.35 * r)
    };
    let motion = JointMotion {
        kind: JointKind::Prismatic,
        axis: pose.rotation * DVec3::Z,
        pivot: pose * top,
        range: Range::Limits {
            lower: -pulled * 0.6 * stroke,
            upper: (1.0 - pulled) * 0.6 * stroke,
        },
    };
    let names = words(&["plunger", "pump handle", "piston rod", "handle", "piston"]);
    draft.add(0, names, vec![motion], piston.with(stem).with(head).moved(pose));
    draft
}

/// A carriage on a beam or on two rods, or the jaw of a caliper.
pub(super) fn carriage(dice: &mut Dice) -> Draft {
    let (half, thick) = (dice.between(0.08, 0.5), dice.between(0.006, 0.03));
    let long = dice.between(0.15, 0.5) * half;
    let (two, pinches) = (dice.chance(0.5), dice.chance(0.6));
    let gap = 2.0 * thick;
    let beam = |y: f64| {
        let end = at(half, y, 0.0);
        if two {
            rod(at(-half, y, 0.0), end, 0.5 * thick)
        } else {
            cuboid(DVec3::ZERO, at(2.0 * half, thick, 1.4 * thick))
        }
    };
    let rails = if two { beam(-gap).with(beam(gap)) } else { beam(0.0) };
    let reach = half - long / 2.0 - 1.5 * thick;
    let x = dice.between(-reach, reach);
    let mut run = cuboid(at(x, 0.0, 0.9 * thick), at(long, 2.0 * gap, 0.3 * thick));
    let sides = [-1.0, 1.0]
        .map(|s| cuboid(at(x, s * 0.65 * thick, 0.0), at(long, 0.2 * thick, 1.4 * thick)));
    let ends = |x: f64, down: f64| {
        cuboid(at(x, 0.0, -down), at(1.5 * thick, 3.0 * gap, 2.0 * thick + 2.0 * down))
    };
    let (base, called) = if pinches && !two {
        // Both jaws hang down; what slides carries the other.
        let deep = dice.between(2.0, 5.0) * thick;
        let jaw = |x: f64| cuboid(at(x, 0.0, -thick - deep / 2.0), at(thick, thick, deep));
        run = run
            .with(jaw(x - long / 2.0 + thick / 2.0))
            .with(cuboid(at(x, 0.0, -0.95 * thick), at(long, 1.5 * thick, 0.3 * thick)));
        (
            rails.with(jaw(-half + thick / 2.0)).with(ends(-half, 0.0)),
            words(&["sliding jaw", "jaw", "slide", "moving jaw"]),
        )
    } else {
        let down = dice.between(0.0, 2.0) * thick;
        (
            rails.with(ends(-half, down)).with(ends(half, down)),
            words(&["carriage", "slide", "trolley", "runner", "cutter head"]),
        )
    };
    if !two {
        run = sides.into_iter().fold(run, Shape::with);
    }
    if dice.chance(0.5) {
        run = run.with(cuboid(at(x, 0.0, 2.0 * thick), at(0.6 * long, gap, 2.0 * thick)));
    }
    let mut draft = Draft::new(words(&["rail", "base", "beam", "frame", "track"]), base);
    let range = Range::Limits { lower: -reach - x, upper: reach - x };
    let motion =
        JointMotion { kind: JointKind::Prismatic, axis: DVec3::X, pivot: at(x, 0.0, 0.0), range };
    draft.add(0, called, vec![motion], run);
    draft
}

/// A box with toggles, knobs and buttons, each on a round or a square plate of the box.
pub(super) fn control_box(dice: &mut Dice) -> Draft {
    let (count, pitch) = (dice.count(1, 5), dice.between(0.05, 0.1));
    let (high, deep) = (pitch * dice.between(1.0, 2.5), dice.between(0.03, 0.2));
    let body = cuboid(at(0.0, deep / 2.0, 0.0), at(pitch * (count as f64 + 0.4), deep, high));
    let names = words(&["control box", "panel", "enclosure", "base", "housing"]);
    let mut draft = Draft::new(names, body);
    for i in 0..count {
        let x = pitch * (i as f64 - (count as f64 - 1.0) / 2.0);
        let (wide, thick) = (dice.between(0.15, 0.45) * pitch, dice.between(0.001, 0.006));
        let root = at(x, 0.0, 0.0);
        let plate = if dice.chance(0.7) {
            lathe(&[(wide, 0.0), (0.95 * wide, thick)], root, DVec3::NEG_Y)
        } else {
            cuboid(root - DVec3::Y * thick / 2.0, at(2.0 * wide, thick, 2.0 * wide))
        };
        draft.add_to_root(plate);
        fitting(&mut draft, dice, i, (root - DVec3::Y * thick, wide));
    }
    draft
}

/// One of them, on a plate that is `wide` from its middle to its rim.
fn fitting(draft: &mut Draft, dice: &mut Dice, i: usize, (root, wide): (DVec3, f64)) {
    let called = |names: &[&str]| placed(names, &[&(i + 1).to_string()]);
    let r = dice.between(0.25, 0.7) * wide;
    let out = dice.between(0.4, 1.6) * wide;
    match dice.count(0, 3) {
        0 | 1 => {
            let (lean, side) = (dice.between(0.2, 0.5), if dice.chance(0.5) { 1.0 } else { -1.0 });
            let way = DVec3::NEG_Y * lean.cos() + DVec3::Z * side * lean.sin();
            let ball = lathe(
                &[(0.4 * r, -0.3 * r), (0.6 * r, 0.0), (0.4 * r, 0.3 * r)],
                root,
                DVec3::NEG_Y,
            );
            let tip = root + way * (out + r);
            let stick = rod(root, tip, 0.25 * r).with(rod(tip - way * 0.4 * r, tip, 0.4 * r));
            // It leans one way and goes as far the other.
            let motion = hinge(DVec3::X * side, root, 0.0, 2.0 * lean);
            let names = called(&["toggle switch", "switch", "lever", "light switch"]);
            draft.add(0, names, vec![motion], ball.with(stick));
        }
        2 => {
            let dial = lathe(&[(r, 0.0), (0.9 * r, out)], root, DVec3::NEG_Y);
            let names = called(&["knob", "dial", "rotary switch", "control knob"]);
            let mark =
                cuboid(root + at(0.0, -0.5 * out, 0.85 * r), at(0.2 * r, 0.9 * out, 0.4 * r));
            let turn = hinge(DVec3::NEG_Y, root, -TAU / 3.0, TAU / 3.0);
            let motion = if dice.chance(0.3) { spin(DVec3::NEG_Y, root) } else { turn };
            draft.add(0, names, vec![motion], dial.with(mark));
        }
        _ => {
            let high = 0.5 * out;
            let button = lathe(&[(r, 0.0), (0.9 * r, high)], root, DVec3::NEG_Y);
            let names = called(&["button", "push button", "key"]);
            draft.add(0, names, vec![slide(DVec3::Y, root, 0.6 * high)], button);
        }
    }
}
