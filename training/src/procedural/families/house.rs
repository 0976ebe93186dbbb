//! What a house is fitted with: doors, windows, switches, boxes and bins.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use object::{DPose3, DVec3};

use super::super::draft::{
    Dice, Draft, at, cuboid, handle, hinge, lathe, placed, rod, slide, spin, tray, words,
};
use super::super::shapes::Shape;

/// A frame around an opening in the plane y = 0, standing on z = 0.
fn frame(w: f64, h: f64, bar: f64, depth: f64) -> Shape {
    let upright = |x: f64| cuboid(at(x * (w + bar) / 2.0, 0.0, h / 2.0), at(bar, depth, h));
    let beam = |z: f64| cuboid(at(0.0, 0.0, z), at(w + 2.0 * bar, depth, bar));
    upright(-1.0).with(upright(1.0)).with(beam(h + bar / 2.0)).with(beam(-bar / 2.0))
}

pub(super) fn door(dice: &mut Dice) -> Draft {
    let (w, h) = (dice.between(0.65, 1.0), dice.between(1.9, 2.2));
    let body = frame(w, h, dice.between(0.05, 0.1), 0.12);
    let mut draft = Draft::new(words(&["door frame", "frame", "door casing"]), body);
    let left = dice.chance(0.5);
    let side = if left { -1.0 } else { 1.0 };
    let mut panel = cuboid(at(0.0, -0.02, h / 2.0), at(w - 0.006, 0.04, h - 0.006));
    let motion =
        hinge(DVec3::Z * side, at(side * w / 2.0, -0.04, 0.0), 0.0, dice.between(1.5, 2.8));
    let lever = at(-side * (w / 2.0 - 0.07), -0.04, 1.0);
    if dice.chance(0.5) {
        panel = panel.with(lathe(&[(0.027, 0.0), (0.025, 0.008)], lever, DVec3::NEG_Y));
    }
    let panel = draft.add(0, words(&["door", "door leaf", "door panel"]), vec![motion], panel);
    if dice.chance(0.6) {
        let end = lever + DVec3::NEG_Y * 0.05;
        let mut shape = rod(lever, end, 0.01).with(rod(end, end + DVec3::X * side * 0.12, 0.009));
        if dice.chance(0.5) {
            let hub = lever + DVec3::NEG_Y * 0.009;
            shape = shape.with(lathe(&[(0.018, 0.0), (0.014, 0.03)], hub, DVec3::NEG_Y));
        }
        let motion = hinge(DVec3::Y * side, lever, 0.0, FRAC_PI_4);
        draft.add(panel, words(&["door handle", "lever handle", "handle"]), vec![motion], shape);
    } else {
        let shape =
            lathe(&[(0.012, 0.0), (0.012, 0.03), (0.03, 0.045), (0.02, 0.07)], lever, DVec3::NEG_Y);
        draft.add(panel, words(&["door knob", "knob"]), vec![spin(DVec3::NEG_Y, lever)], shape);
    }
    draft
}

pub(super) fn casement(dice: &mut Dice) -> Draft {
    let (w, h) = (dice.between(0.7, 1.4), dice.between(0.7, 1.4));
    let body = frame(w, h, dice.between(0.04, 0.07), 0.08);
    let mut draft = Draft::new(words(&["window frame", "fixed frame", "casing"]), body);
    for (place, side) in [("left", -1.0), ("right", 1.0)] {
        let pane = frame(w / 2.0 - 0.08, h - 0.08, 0.035, 0.03);
        let glass = cuboid(at(0.0, 0.0, h / 2.0 - 0.04), at(w / 2.0 - 0.08, 0.006, h - 0.08));
        let shape = pane.with(glass).at(side * w / 4.0, -0.02, 0.04);
        let motion =
            hinge(DVec3::Z * side, at(side * w / 2.0, -0.035, 0.0), 0.0, dice.between(1.2, 1.8));
        let names = placed(&[place], &["sash", "window", "casement", "window pane"]);
        draft.add(0, names, vec![motion], shape);
    }
    draft
}

pub(super) fn sash(dice: &mut Dice) -> Draft {
    let (w, h) = (dice.between(0.5, 1.0), dice.between(0.9, 1.6));
    let body = frame(w, h, 0.06, 0.12);
    let mut draft = Draft::new(words(&["window frame", "fixed frame", "window casing"]), body);
    for (place, z, y, way) in [("lower", 0.0, -0.03, 1.0), ("upper", 1.0, 0.02, -1.0)] {
        let pane = frame(w - 0.08, h / 2.0 - 0.06, 0.035, 0.03);
        let glass = cuboid(at(0.0, 0.0, h / 4.0 - 0.03), at(w - 0.08, 0.006, h / 2.0 - 0.06));
        let shape = pane.with(glass).at(0.0, y, 0.04 + z * (h / 2.0 - 0.02));
        let motion = slide(DVec3::Z * way, at(0.0, y, h / 2.0), 0.45 * h);
        draft.add(
            0,
            placed(&[place], &["sash", "window pane", "sliding sash"]),
            vec![motion],
            shape,
        );
    }
    draft
}

pub(super) fn switch(dice: &mut Dice) -> Draft {
    let (count, pitch) = (dice.count(1, 4), 0.045);
    let wide = pitch * count as f64 + 0.03;
    let plate = cuboid(at(0.0, 0.004, 0.0), at(wide, 0.008, 0.12));
    let mut draft = Draft::new(words(&["wall plate", "switch plate", "cover plate"]), plate);
    let (lies, toggles) = (dice.chance(0.3), dice.chance(0.5));
    for i in 0..count {
        let x = pitch * (i as f64 - (count as f64 - 1.0) / 2.0);
        if toggles {
            toggle(&mut draft, dice, i, (x, lies));
            continue;
        }
        let tilt = DPose3::rotation(DVec3::X * 0.12);
        let rocker = cuboid(DVec3::ZERO, at(0.032, 0.01, 0.066)).moved(tilt).at(x, -0.004, 0.0);
        let names = vec![format!("rocker {}", i + 1), format!("switch {}", i + 1)];
        draft.add(0, names, vec![hinge(DVec3::NEG_X, at(x, 0.0, 0.0), 0.0, 0.24)], rocker);
    }
    draft
}

/// A stick in a collar, which goes up and down or, where the switch lies on its side, left and right.
fn toggle(draft: &mut Draft, dice: &mut Dice, i: usize, (x, lies): (f64, bool)) {
    let root = at(x, 0.0, 0.0);
    draft.add_to_root(lathe(&[(0.014, 0.0), (0.011, 0.004)], root, DVec3::NEG_Y));
    let (lean, side) = (dice.between(0.25, 0.45), if dice.chance(0.5) { 1.0 } else { -1.0 });
    let aside = side * if lies { DVec3::X } else { DVec3::Z };
    let way = DVec3::NEG_Y * lean.cos() + aside * lean.sin();
    let ball = lathe(&[(0.004, -0.006), (0.007, 0.0), (0.004, 0.006)], root, DVec3::NEG_Y);
    let (thin, long) = (dice.between(0.002, 0.0045), dice.between(0.014, 0.03));
    let stick = rod(root, root + way * long, thin);
    let tip = root + way * long;
    let stick = stick.with(rod(tip - way * 0.3 * long, tip, dice.between(1.2, 1.8) * thin));
    // It leans one way and goes as far the other.
    let motion = hinge(aside.cross(DVec3::NEG_Y), root, 0.0, 2.0 * lean);
    let names =
        vec![format!("toggle {}", i + 1), format!("switch {}", i + 1), format!("lever {}", i + 1)];
    draft.add(0, names, vec![motion], ball.with(stick));
}

pub(super) fn ceiling_fan(dice: &mut Dice) -> Draft {
    let (blades, reach) = (dice.count(3, 6), dice.between(0.4, 0.7));
    let stem = rod(at(0.0, 0.0, 0.08), at(0.0, 0.0, 0.4), 0.012);
    let rose = lathe(&[(0.06, 0.0), (0.08, 0.03)], at(0.0, 0.0, 0.4), DVec3::Z);
    let motor = lathe(&[(0.06, 0.0), (0.11, 0.03), (0.1, 0.07)], at(0.0, 0.0, 0.02), DVec3::Z);
    let names = words(&["ceiling mount with motor", "fan body", "mount and stem"]);
    let mut draft = Draft::new(names, stem.with(rose).with(motor));
    let hub = lathe(&[(0.05, -0.03), (0.09, -0.005), (0.09, 0.012)], DVec3::ZERO, DVec3::Z);
    let blade = |i: usize| {
        let turn = DPose3::rotation(DVec3::Z * (TAU * i as f64 / blades as f64));
        let pitch = DPose3::rotation(DVec3::X * 0.2);
        let flat = cuboid(at(0.07 + reach / 2.0, 0.0, 0.0), at(reach, 0.12, 0.006));
        flat.moved(turn * pitch)
    };
    let rotor = (0..blades).map(blade).fold(hub, Shape::with);
    let names = words(&["fan blades", "rotor", "blade assembly"]);
    draft.add(0, names, vec![spin(DVec3::Z, DVec3::ZERO)], rotor);
    let chain = rod(at(0.06, 0.0, -0.1), at(0.06, 0.0, 0.02), 0.003);
    let bob = lathe(&[(0.008, 0.0), (0.008, 0.02)], at(0.06, 0.0, -0.12), DVec3::Z);
    let motion = slide(DVec3::NEG_Z, at(0.06, 0.0, 0.0), 0.03);
    draft.add(0, words(&["pull chain", "pull cord"]), vec![motion], chain.with(bob));
    draft
}

pub(super) fn storage_box(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.2, 0.7), dice.between(0.15, 0.5), dice.between(0.1, 0.4));
    let body = tray(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h), 0.012);
    let mut draft = Draft::new(words(&["box", "box body", "chest", "case bottom"]), body);
    if dice.chance(0.5) {
        let lid = cuboid(at(0.0, 0.0, h + 0.012), at(w, d, 0.022));
        let motion = hinge(DVec3::NEG_X, at(0.0, d / 2.0, h), 0.0, dice.between(1.4, 2.2));
        let lid =
            draft.add(0, words(&["lid", "box lid", "hinged lid", "cover"]), vec![motion], lid);
        let middle = at(0.0, -d / 2.0 - 0.006, h);
        let hasp = cuboid(middle, at(0.1 * w, 0.01, 0.06));
        let motion = hinge(DVec3::X, middle + DVec3::Z * 0.02, 0.0, FRAC_PI_2);
        draft.add(lid, words(&["latch", "clasp", "hasp"]), vec![motion], hasp);
    } else {
        for (place, side) in [("left", -1.0), ("right", 1.0)] {
            let flap = cuboid(at(side * w / 4.0, 0.0, h + 0.004), at(w / 2.0 - 0.004, d, 0.006));
            let motion = hinge(
                DVec3::Y * side,
                at(side * w / 2.0, 0.0, h),
                0.0,
                dice.between(1.5, 3.6).min(PI),
            );
            draft.add(0, placed(&[place], &["flap", "box flap", "half lid"]), vec![motion], flap);
        }
    }
    draft
}

pub(super) fn waste_bin(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.25, 0.5), dice.between(0.25, 0.5), dice.between(0.4, 0.9));
    let body = tray(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h), 0.01);
    let mut draft = Draft::new(words(&["bin body", "trash can", "waste bin", "container"]), body);
    let ring = |y: f64| cuboid(at(0.0, y, h + 0.02), at(w, 0.04, 0.04));
    let sides = |x: f64| cuboid(at(x, 0.0, h + 0.02), at(0.03, d - 0.08, 0.04));
    if dice.chance(0.5) {
        let rim = ring(-d / 2.0 + 0.02).with(ring(d / 2.0 - 0.02));
        let rim = rim.with(sides(-w / 2.0 + 0.015)).with(sides(w / 2.0 - 0.015));
        let rim = draft.add(0, words(&["rim", "bin collar"]), vec![], rim);
        let flap = cuboid(at(0.0, 0.0, h + 0.02), at(w - 0.07, d - 0.09, 0.008));
        let motion = hinge(DVec3::X, at(0.0, 0.0, h + 0.02), -1.0, 1.0);
        draft.add(rim, words(&["swing flap", "swing lid", "flap"]), vec![motion], flap);
    } else {
        let lid = cuboid(at(0.0, 0.0, h + 0.016), at(w + 0.01, d + 0.01, 0.03));
        let grip = handle(at(0.0, -d / 2.0 - 0.005, h + 0.016), DVec3::X, 0.4 * w, DVec3::NEG_Y);
        let motion = hinge(DVec3::NEG_X, at(0.0, d / 2.0, h), 0.0, dice.between(1.2, 2.4));
        draft.add(0, words(&["lid", "bin lid", "cover"]), vec![motion], lid.with(grip));
        for (place, side) in [("left", -1.0), ("right", 1.0)] {
            let hub = at(side * (w / 2.0 + 0.02), d / 2.0, 0.06);
            let wheel = rod(hub - DVec3::X * 0.015, hub + DVec3::X * 0.015, 0.06);
            draft.add(
                0,
                placed(&[place], &["wheel", "bin wheel"]),
                vec![spin(DVec3::X, hub)],
                wheel,
            );
        }
    }
    draft
}
