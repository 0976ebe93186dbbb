//! Fittings that sit in collars, on plates and under caps: which of these stay, and which go along.

use std::f64::consts::{FRAC_PI_2, TAU};

use object::{DPose3, DVec3, JointMotion};

use super::super::draft::{
    Dice, Draft, at, cuboid, handle, hinge, lathe, placed, rim, rod, shell, slide, spin, words,
};
use super::super::shapes::Shape;
use super::workshop::Slotted;

/// A turn of what looks up (+z) so that it looks towards −y.
fn to_front() -> DPose3 {
    DPose3::rotation(DVec3::X * FRAC_PI_2)
}

/// A turn of what looks up (+z) so that it looks towards +x.
fn to_side() -> DPose3 {
    DPose3::rotation(DVec3::Y * FRAC_PI_2)
}

/// Where a fitting sits: its seat's middle at the origin of `pose`, what it looks at along +z there, and
/// its radius in metres.
struct Seat {
    pose: DPose3,
    r: f64,
}

impl Seat {
    fn at(root: DVec3, turn: DPose3, r: f64) -> Self {
        Self { pose: DPose3::from_parts(root, turn.rotation), r }
    }

    fn motion(&self, motion: JointMotion) -> JointMotion {
        JointMotion {
            axis: self.pose.rotation * motion.axis,
            pivot: self.pose * motion.pivot,
            ..motion
        }
    }
}

/// A cup upside down: open below, `thick` metres of wall.
fn cup(outer: f64, high: f64, thick: f64) -> Shape {
    let (inner, ceiling) = (outer - thick, high - thick);
    lathe(&[(inner, ceiling), (inner, 0.0), (outer, 0.0), (outer, high)], DVec3::ZERO, DVec3::Z)
}

/// A ring with a square bar, standing on the seat, by its inner radius.
fn ring(inner: f64, thick: f64) -> Shape {
    rim(at(0.0, 0.0, thick / 2.0), inner + thick / 2.0, thick)
}

/// What stays about a fitting: a plate under it, a ring or a frame around it, several of these or nothing;
/// and how high above the seat the fitting's foot is.
fn collars(draft: &mut Draft, dice: &mut Dice, seat: &Seat) -> f64 {
    let (r, mut foot) = (seat.r, 0.0);
    if dice.chance(0.45) {
        let (wide, thick) = (dice.between(1.05, 2.2) * r, dice.between(0.05, 0.3) * r);
        let plate = if dice.chance(0.7) {
            lathe(&[(wide, 0.0), (dice.between(0.8, 1.0) * wide, thick)], DVec3::ZERO, DVec3::Z)
        } else {
            cuboid(at(0.0, 0.0, thick / 2.0), at(2.0 * wide, 2.0 * wide, thick))
        };
        draft.add_to_root(plate.moved(seat.pose));
        foot = if dice.chance(0.7) { thick } else { 0.0 };
    }
    if dice.chance(0.5) {
        let (inner, thick) = (dice.between(1.02, 1.25) * r, dice.between(0.1, 0.4) * r);
        draft.add_to_root(ring(inner, thick).at(0.0, 0.0, foot).moved(seat.pose));
    } else if dice.chance(0.2) {
        let (inner, bar) = (dice.between(2.05, 2.4) * r, dice.between(0.2, 0.5) * r);
        let (middle, size) = (at(0.0, 0.0, 0.0), at(inner + 2.0 * bar, 0.4 * r, inner + 2.0 * bar));
        let frame = Slotted { middle, size, hole: [inner; 2], off: [0.0; 2] }.shape();
        let up = DPose3::rotation(DVec3::NEG_X * FRAC_PI_2);
        draft.add_to_root(frame.moved(up).at(0.0, 0.0, foot + 0.2 * r).moved(seat.pose));
    }
    foot
}

/// What goes along with a fitting that stands on `foot`: a skirt under it, a ring about its waist, or
/// nothing.
fn skirts(dice: &mut Dice, r: f64, (foot, high): (f64, f64)) -> Shape {
    let mut all = Shape::default();
    if dice.chance(0.3) {
        let wide = dice.between(1.05, 1.5) * r;
        let low = at(0.0, 0.0, foot + 0.03 * r);
        all.add(&lathe(&[(wide, 0.0), (0.95 * wide, 0.15 * high)], low, DVec3::Z));
    }
    if dice.chance(0.2) {
        let middle = at(0.0, 0.0, foot + dice.between(0.3, 0.8) * high);
        all.add(&rim(middle, r, 0.15 * high.min(r)));
    }
    all
}

/// A button, a knob or a switch, and what stays about it; `number` as people count, from one.
fn fitting(draft: &mut Draft, dice: &mut Dice, seat: &Seat, number: usize) {
    let called = |names: &[&str]| placed(names, &[&number.to_string()]);
    let (r, foot) = (seat.r, collars(draft, dice, seat));
    let root = at(0.0, 0.0, foot);
    match dice.count(0, 6) {
        0..=2 => {
            let high = dice.between(0.3, 1.2) * r;
            let sunk = -0.5 * high;
            let button = if dice.chance(0.7) {
                lathe(&[(r, sunk), (r, 0.8 * high), (0.85 * r, high)], root, DVec3::Z)
            } else {
                cuboid(root + DVec3::Z * (high + sunk) / 2.0, at(1.4 * r, 1.4 * r, high - sunk))
            };
            let button = button.with(skirts(dice, r, (foot, high)));
            let motion = seat.motion(slide(DVec3::NEG_Z, root, 0.4 * high));
            let names = called(&["button", "push button", "brew button", "start button", "key"]);
            draft.add(0, names, vec![motion], button.moved(seat.pose));
        }
        3 | 4 => {
            let high = dice.between(0.6, 2.0) * r;
            let dial = lathe(&[(r, 0.0), (dice.between(0.6, 1.0) * r, high)], root, DVec3::Z);
            let dial = if dice.chance(0.5) {
                let grip = at(0.35 * r, 1.9 * r, 0.9 * high);
                dial.with(cuboid(root + DVec3::Z * 0.75 * high, grip))
            } else {
                let mark = root + at(0.0, 0.85 * r, 0.5 * high);
                dial.with(cuboid(mark, at(0.2 * r, 0.4 * r, 0.95 * high)))
            };
            let dial = dial.with(skirts(dice, r, (foot, high)));
            let turn = dice.between(1.6, 2.6);
            let motion = match dice.count(0, 2) {
                0 => spin(DVec3::Z, root),
                1 => hinge(DVec3::Z, root, -turn, turn),
                _ => hinge(DVec3::NEG_Z, root, 0.0, dice.between(0.5, 0.8) * TAU),
            };
            let names = called(&["knob", "dial", "control knob", "steam knob", "rotary switch"]);
            draft.add(0, names, vec![seat.motion(motion)], dial.moved(seat.pose));
        }
        5 => {
            let (lean, side) = (dice.between(0.2, 0.5), if dice.chance(0.5) { 1.0 } else { -1.0 });
            let way = DVec3::Z * lean.cos() + DVec3::Y * side * lean.sin();
            let tip = root + way * dice.between(1.2, 3.0) * r;
            let ball =
                lathe(&[(0.4 * r, -0.4 * r), (0.7 * r, 0.0), (0.4 * r, 0.4 * r)], root, DVec3::Z);
            let stick = rod(root, tip, dice.between(0.15, 0.4) * r);
            // It leans one way and goes as far the other.
            let motion = seat.motion(hinge(DVec3::X * side, root, 0.0, 2.0 * lean));
            let names = called(&["toggle switch", "light switch", "switch", "toggle"]);
            draft.add(0, names, vec![motion], ball.with(stick).moved(seat.pose));
        }
        _ => {
            let tilt = dice.between(0.08, 0.2);
            let rocker = cuboid(DVec3::ZERO, at(0.9 * r, 1.7 * r, 0.5 * r));
            let rocker = rocker.moved(DPose3::rotation(DVec3::X * tilt));
            let motion = seat.motion(hinge(DVec3::NEG_X, root, 0.0, 2.0 * tilt));
            let names = called(&["rocker switch", "rocker", "power switch", "light switch"]);
            draft.add(0, names, vec![motion], rocker.at(0.0, 0.0, foot).moved(seat.pose));
        }
    }
}

/// An espresso machine: a foot, a column and a head, with buttons and knobs, a filter holder under its
/// group, a drip tray, and a tank with a lid.
pub(super) fn coffee_machine(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.12, 0.35), dice.between(0.2, 0.4), dice.between(0.25, 0.45));
    let (low, deep) = (dice.between(0.12, 0.2) * h, dice.between(0.6, 1.0) * d);
    let head = dice.between(0.22, 0.35) * h;
    let front = d / 2.0 - deep;
    let column = cuboid(at(0.0, 0.3 * d, h / 2.0), at(w, 0.4 * d, h));
    let top = cuboid(at(0.0, (front + d / 2.0) / 2.0, h - head / 2.0), at(w, deep, head));
    let foot = shell(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, 0.1 * d, low), 0.06 * low);
    let names = words(&["coffee machine body", "machine body", "base", "housing", "body"]);
    let mut draft = Draft::new(names, column.with(top).with(foot));
    let count = dice.count(1, 4);
    let pitch = w / count as f64;
    for i in 0..count {
        let x = pitch * (i as f64 - (count as f64 - 1.0) / 2.0);
        let r = dice.between(0.12, 0.3) * pitch.min(head);
        let seat = if dice.chance(0.8) {
            Seat::at(at(x, front, h - head / 2.0), to_front(), r)
        } else {
            Seat::at(at(x, front + 0.3 * deep, h), DPose3::IDENTITY, r)
        };
        fitting(&mut draft, dice, &seat, i + 1);
    }
    if dice.chance(0.4) {
        let seat = Seat::at(at(w / 2.0, 0.2 * d, h - head / 2.0), to_side(), 0.2 * head);
        fitting(&mut draft, dice, &seat, count + 1);
    }
    let (g, under) = (dice.between(0.15, 0.3) * w.min(deep), h - head);
    let group = at(0.0, front + 0.35 * deep, under);
    let tall = dice.between(0.1, 0.25) * under;
    draft.add_to_root(lathe(&[(g, -tall), (1.1 * g, 0.0)], group, DVec3::Z));
    if dice.chance(0.5) {
        draft.add_to_root(rim(group - DVec3::Z * tall, 1.05 * g, 0.15 * g));
    }
    if dice.chance(0.6) {
        let brim = group - DVec3::Z * (tall + 0.1 * g);
        let basket = [(0.6 * g, -0.8 * g), (0.95 * g, -0.6 * g), (0.95 * g, 0.0)];
        let middle = brim - DVec3::Z * 0.35 * g;
        let long = DVec3::NEG_Y * dice.between(2.0, 4.0) * g;
        let shape = lathe(&basket, brim, DVec3::Z).with(rod(middle, middle + long, 0.2 * g));
        let motion = hinge(DVec3::NEG_Z, brim, 0.0, dice.between(0.5, 1.2));
        let names = words(&["portafilter", "filter holder", "brew handle", "handle"]);
        draft.add(0, names, vec![motion], shape);
    }
    if dice.chance(0.5) {
        let size = at(0.86 * w, 0.5 * d, 0.7 * low);
        let middle = at(0.0, -d / 2.0 + size.y / 2.0 - 0.01, low / 2.0);
        let grate = cuboid(middle + DVec3::Z * 0.45 * low, at(0.8 * w, 0.45 * d, 0.04 * low));
        let names = words(&["drip tray", "tray", "cup tray"]);
        let motion = slide(DVec3::NEG_Y, middle, dice.between(0.3, 0.5) * d);
        draft.add(0, names, vec![motion], cuboid(middle, size).with(grate));
    }
    hopper(&mut draft, dice, at(0.0, 0.3 * d, h), 0.4 * w.min(0.4 * d));
    draft
}

/// A tank's flap, or a lid that lifts from the collar of a hopper, on top of a machine.
fn hopper(draft: &mut Draft, dice: &mut Dice, top: DVec3, r: f64) {
    let names = words(&["lid", "tank lid", "water tank lid", "hopper lid", "cover"]);
    if dice.chance(0.5) {
        let thick = 0.1 * r;
        let lid = cuboid(top + DVec3::Z * thick / 2.0, at(2.0 * r, 2.0 * r, thick));
        let motion = hinge(DVec3::NEG_X, top + DVec3::Y * r, 0.0, dice.between(1.2, 1.9));
        draft.add(0, names, vec![motion], lid);
    } else {
        let tall = dice.between(0.1, 0.8) * r;
        draft.add_to_root(cup(r, tall, 0.08 * r).at(top.x, top.y, top.z));
        let brim = top + DVec3::Z * tall;
        if dice.chance(0.5) {
            draft.add_to_root(rim(brim - DVec3::Z * 0.1 * r, 1.02 * r, 0.12 * r));
        }
        let lid = lathe(&[(1.05 * r, 0.0), (1.0 * r, 0.15 * r)], brim, DVec3::Z);
        let lid = lid.with(lathe(&[(0.15 * r, 0.15 * r), (0.2 * r, 0.4 * r)], brim, DVec3::Z));
        let lifts = slide(DVec3::Z, brim, dice.between(0.5, 1.5) * r);
        let motion = if dice.chance(0.5) { lifts } else { spin(DVec3::Z, brim) };
        draft.add(0, names, vec![motion], lid);
    }
}

/// A jar or a bottle whose neck, threads and rings are bodies of their own, and what closes it.
pub(super) fn jar(dice: &mut Dice) -> Draft {
    let (r, h) = (dice.between(0.02, 0.06), dice.between(0.05, 0.25));
    let neck = dice.between(0.3, 0.95) * r;
    let tall = dice.between(0.08, 0.25) * h;
    let shoulder = dice.between(0.75, 1.0) * h;
    let profile = [(0.95 * r, 0.0), (r, 0.05 * h), (r, shoulder), (neck, h)];
    let names = words(&["jar", "bottle", "jar body", "bottle body", "container", "base"]);
    let mut draft = Draft::new(names, lathe(&profile, DVec3::ZERO, DVec3::Z));
    draft.add_to_root(lathe(&[(0.93 * neck, 0.0), (0.93 * neck, tall)], at(0.0, 0.0, h), DVec3::Z));
    for i in 0..dice.count(0, 2) {
        let z = h + tall * (0.35 + 0.25 * i as f64);
        draft.add_to_root(rim(at(0.0, 0.0, z), 0.95 * neck, 0.05 * neck));
    }
    let mut low = h + 0.02 * tall;
    if dice.chance(0.6) {
        // What stays on the neck when the cap is taken off.
        let thick = dice.between(0.05, 0.25) * tall;
        let (inner, outer) = (0.94 * neck, dice.between(1.02, 1.25) * neck);
        let band = [(inner, thick), (inner, 0.0), (outer, 0.0), (outer, thick)];
        draft.add_to_root(lathe(&band, at(0.0, 0.0, low), DVec3::Z));
        low += 1.05 * thick;
    }
    let foot = at(0.0, 0.0, low);
    let (outer, high) = (dice.between(1.05, 1.3) * neck, h + tall - low + 0.15 * tall);
    if dice.chance(0.25) {
        draft.add_to_root(cup(outer, high, 0.1 * neck).at(0.0, 0.0, low));
        let stroke = dice.between(0.2, 0.6) * tall;
        let start = foot + DVec3::Z * high;
        let top = start + DVec3::Z * (stroke + 0.1 * tall);
        let knob = lathe(&[(0.5 * neck, 0.0), (0.6 * neck, 0.3 * neck)], top, DVec3::Z);
        let middle = top + DVec3::Z * 0.15 * neck;
        let nozzle = rod(middle, middle - DVec3::Y * dice.between(0.8, 2.5) * neck, 0.12 * neck);
        let names = words(&["pump head", "pump", "dispenser", "push top", "nozzle"]);
        let shape = rod(start, top, 0.25 * neck).with(knob).with(nozzle);
        draft.add(0, names, vec![slide(DVec3::NEG_Z, top, stroke)], shape);
        return draft;
    }
    let mut cap = cup(outer, high, 0.08 * neck).at(0.0, 0.0, low);
    if dice.chance(0.3) {
        let liner = at(0.0, 0.0, low + high - 0.12 * neck);
        cap.add(&lathe(&[(0.85 * outer, 0.0), (0.85 * outer, 0.03 * neck)], liner, DVec3::Z));
    }
    if dice.chance(0.3) {
        let z = low + dice.between(0.1, 0.9) * high;
        cap.add(&rim(at(0.0, 0.0, z), outer, 0.08 * outer));
    }
    if dice.chance(0.2) {
        let top = foot + DVec3::Z * high;
        cap.add(&lathe(&[(0.2 * outer, 0.0), (0.3 * outer, 0.5 * outer)], top, DVec3::Z));
    }
    let names = words(&["cap", "screw cap", "lid", "bottle cap", "jar lid", "stopper"]);
    let up = slide(DVec3::Z, foot, dice.between(1.0, 2.0) * high);
    let motions = match dice.count(0, 3) {
        0 => vec![up, spin(DVec3::Z, foot)],
        1 => vec![up],
        2 => vec![spin(DVec3::Z, foot)],
        _ => {
            let top = at(0.0, outer, low);
            vec![hinge(DVec3::NEG_X, top, 0.0, dice.between(FRAC_PI_2, 2.4))]
        }
    };
    draft.add(0, names, motions, cap);
    draft
}

/// A large appliance with a door and, on the strip above it or on a hood's brow, small fittings.
pub(super) fn appliance(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.4, 1.0), dice.between(0.3, 0.6), dice.between(0.4, 1.2));
    let strip = dice.between(0.08, 0.14).min(0.2 * h);
    let front = -d / 2.0;
    let body = shell(at(-w / 2.0, front, 0.0), at(w / 2.0, d / 2.0, h - strip), 0.02);
    let above = cuboid(at(0.0, 0.0, h - strip / 2.0), at(w, d, strip));
    let names = words(&["appliance body", "oven body", "machine", "housing", "base", "cabinet"]);
    let mut draft = Draft::new(names, body.with(above));
    let high = h - strip;
    let panel = cuboid(at(0.0, front - 0.012, high / 2.0), at(0.98 * w, 0.02, 0.96 * high));
    let motion = if dice.chance(0.5) {
        hinge(DVec3::X, at(0.0, front, 0.02 * high), 0.0, dice.between(1.2, 1.6))
    } else {
        hinge(DVec3::NEG_Z, at(-0.49 * w, front, 0.0), 0.0, dice.between(1.4, 2.4))
    };
    let grip = handle(at(0.0, front - 0.022, 0.9 * high), DVec3::X, 0.6 * w, DVec3::NEG_Y);
    let names = words(&["door", "oven door", "front door", "hatch"]);
    draft.add(0, names, vec![motion], panel.with(grip));
    let (mut root, mut turn) = (at(0.0, front, h - strip / 2.0), to_front());
    if dice.chance(0.3) {
        // A hood hangs above on a back wall; its fittings are on its brow or under it.
        let (z, brow) = (h + dice.between(0.4, 0.7), dice.between(0.05, 0.15));
        draft.add_to_root(cuboid(at(0.0, d / 2.0 - 0.01, (h + z) / 2.0), at(0.9 * w, 0.02, z - h)));
        draft.add_to_root(cuboid(at(0.0, 0.0, z + brow / 2.0), at(w, d, brow)));
        root = at(0.0, front, z + brow / 2.0);
        if dice.chance(0.3) {
            (root, turn) = (at(0.0, 0.5 * front, z), DPose3::rotation(DVec3::X * 2.0 * FRAC_PI_2));
        }
    }
    let count = dice.count(1, 6);
    let pitch = 0.8 * w / count as f64;
    for i in 0..count {
        let x = pitch * (i as f64 - (count as f64 - 1.0) / 2.0);
        let r = dice.between(0.006, 0.022);
        fitting(&mut draft, dice, &Seat::at(root + DVec3::X * x, turn, r), i + 1);
    }
    draft
}
