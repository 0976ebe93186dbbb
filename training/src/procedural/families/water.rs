//! Taps and valves, toilets, kettles and bottles.

use std::f64::consts::FRAC_PI_2;

use object::DVec3;

use super::super::draft::{
    Dice, Draft, at, cuboid, hinge, lathe, placed, rim, rod, slide, spin, words,
};

/// What water comes out of, or is shut off by.
pub(super) fn faucet(dice: &mut Dice) -> Draft {
    match dice.count(0, 3) {
        0 | 1 => basin_tap(dice),
        2 => pillar_tap(dice),
        _ => pipe_valve(dice),
    }
}

/// A swivelling spout, with a lever at its neck or a valve at either side.
fn basin_tap(dice: &mut Dice) -> Draft {
    let (tall, reach, r) =
        (dice.between(0.12, 0.3), dice.between(0.1, 0.22), dice.between(0.012, 0.02));
    let foot = lathe(&[(0.03, 0.0), (0.03, 0.01), (0.024, 0.02)], DVec3::ZERO, DVec3::Z);
    let two = dice.chance(0.5);
    let plate = cuboid(at(0.0, 0.0, 0.004), at(if two { 0.24 } else { 0.07 }, 0.055, 0.008));
    let names = words(&["faucet base", "tap body", "base plate"]);
    let mut draft = Draft::new(names, foot.with(plate));
    let top = at(0.0, 0.0, tall);
    let tip = at(0.0, -reach, tall - 0.02);
    let spout = rod(at(0.0, 0.0, 0.021), top, r).with(rod(top, tip, 0.9 * r));
    let spout = spout.with(rod(tip, tip - DVec3::Z * 0.03, 0.8 * r));
    let motion =
        hinge(DVec3::Z, at(0.0, 0.0, 0.02), -dice.between(0.8, 2.0), dice.between(0.8, 2.0));
    let spout = draft.add(0, words(&["spout", "swivel spout", "faucet neck"]), vec![motion], spout);
    if !two {
        let neck = at(r + 0.002, 0.0, 0.6 * tall);
        let lever = rod(neck - DVec3::X * 0.01, neck + DVec3::X * 0.02, 0.012);
        let lever = lever.with(rod(neck + DVec3::X * 0.015, neck + at(0.03, 0.0, 0.09), 0.005));
        let motion = hinge(DVec3::X, neck, 0.0, dice.between(0.4, 1.0));
        draft.add(spout, words(&["lever", "faucet handle", "mixer lever"]), vec![motion], lever);
        return draft;
    }
    for (place, side) in [("left", -1.0), ("right", 1.0)] {
        let foot = at(side * 0.09, 0.0, 0.008);
        let stem =
            lathe(&[(0.016, 0.0), (0.014, 0.03), (0.02, 0.04), (0.018, 0.05)], foot, DVec3::Z);
        let bar = |d: DVec3| rod(foot + DVec3::Z * 0.045 - d, foot + DVec3::Z * 0.045 + d, 0.005);
        let cross = stem.with(bar(DVec3::X * 0.03)).with(bar(DVec3::Y * 0.03));
        let names = placed(&[place], &["handle", "tap handle", "valve"]);
        draft.add(0, names, vec![hinge(DVec3::Z * side, foot, 0.0, dice.between(1.5, 3.0))], cross);
    }
    draft
}

/// A pillar with a spout that stands still; what is turned sits on top of it and carries its lever.
fn pillar_tap(dice: &mut Dice) -> Draft {
    let (r, tall) = (dice.between(0.011, 0.024), dice.between(0.05, 0.18));
    let (wide, thick) = (dice.between(1.5, 2.8) * r, dice.between(0.006, 0.02));
    let foot = lathe(&[(wide, 0.0), (wide, thick), (0.9 * wide, thick)], DVec3::ZERO, DVec3::Z);
    let mut body = foot.with(rod(at(0.0, 0.0, thick), at(0.0, 0.0, tall), r));
    if dice.chance(0.7) {
        let (root, reach) = (dice.between(0.5, 0.85) * tall, dice.between(0.06, 0.16));
        let tip = at(0.0, -reach, root + dice.between(-0.01, 0.03));
        body = body.with(rod(at(0.0, 0.0, root), tip, 0.7 * r));
        body = body.with(rod(tip, tip - DVec3::Z * 0.02, 0.6 * r));
    }
    let (hub, high) = (dice.between(0.9, 2.0) * r, dice.between(0.015, 0.045));
    if dice.chance(0.6) {
        let neck = tall + dice.between(0.1, 0.6) * high;
        body = body.with(rod(at(0.0, 0.0, tall), at(0.0, 0.0, neck), dice.between(0.4, 0.8) * r));
    }
    let mut draft = Draft::new(words(&["tap body", "base", "faucet body", "pillar"]), body);
    let top = at(0.0, 0.0, tall + dice.between(0.0005, 0.004));
    let shoulder = dice.between(0.5, 1.0) * hub;
    let cap = lathe(&[(hub, 0.0), (hub, 0.75 * high), (shoulder, high)], top, DVec3::Z);
    let middle = top + DVec3::Z * dice.between(0.4, 0.7) * high;
    let turn = dice.between(-1.0, 1.0) * FRAC_PI_2;
    let (out, up) = (at(turn.sin(), -turn.cos(), 0.0), dice.between(-0.1, 0.6));
    let way = (out + DVec3::Z * up).normalize();
    let long = hub + dice.between(0.03, 0.13);
    let thin = dice.between(0.15, 0.35) * hub.min(0.025);
    let arm = |way: DVec3| {
        let grip = rod(middle + way * 0.55 * long, middle + way * long, 1.8 * thin);
        rod(middle + way * 0.6 * hub, middle + way * 0.6 * long, thin).with(grip)
    };
    let mut handle = cap.with(arm(way));
    let names = if dice.chance(0.3) {
        handle = handle.with(arm(at(-way.x, -way.y, way.z)));
        words(&["tap handle", "valve", "handle"])
    } else {
        words(&["lever", "faucet handle", "tap lever", "handle"])
    };
    let (back, ahead) = (dice.between(0.0, 1.6), dice.between(0.8, 1.6));
    draft.add(0, names, vec![hinge(DVec3::Z, top, -back, ahead)], handle);
    draft
}

/// A pipe with a valve, whose nut carries a lever or a wheel.
fn pipe_valve(dice: &mut Dice) -> Draft {
    let (r, half) = (dice.between(0.012, 0.03), dice.between(0.05, 0.12));
    let end = |side: f64| {
        let from = at(side * half, 0.0, 0.0);
        rod(from, from - DVec3::X * side * 0.35 * half, 1.25 * r)
    };
    let pipe = rod(at(-half, 0.0, 0.0), at(half, 0.0, 0.0), r).with(end(-1.0)).with(end(1.0));
    let rise = dice.between(1.6, 2.6) * r;
    let bonnet = lathe(&[(1.3 * r, 0.0), (1.1 * r, 0.7 * rise)], DVec3::ZERO, DVec3::Z);
    let stem = rod(at(0.0, 0.0, 0.7 * rise), at(0.0, 0.0, rise), 0.5 * r);
    let body = pipe.with(bonnet).with(stem);
    let mut draft = Draft::new(words(&["valve body", "pipe", "base"]), body);
    let top = at(0.0, 0.0, rise + 0.001);
    let (hub, high) = (dice.between(0.6, 1.2) * r, dice.between(0.3, 0.8) * r);
    let nut = lathe(&[(hub, 0.0), (hub, high)], top, DVec3::Z);
    let middle = top + DVec3::Z * 0.5 * high;
    if dice.chance(0.5) {
        let long = dice.between(3.0, 6.0) * r;
        let blade = cuboid(middle + DVec3::X * 0.5 * long, at(long, hub, 0.3 * high));
        let names = words(&["valve lever", "lever", "shut-off handle", "valve handle"]);
        draft.add(0, names, vec![hinge(DVec3::Z, top, 0.0, FRAC_PI_2)], nut.with(blade));
        return draft;
    }
    let (wide, thick) = (dice.between(1.8, 3.0) * r, 0.5 * r);
    let mut wheel = nut.with(rim(middle, wide, thick));
    for spoke in 0..4 {
        let turn = f64::from(spoke) * FRAC_PI_2;
        let way = at(turn.cos(), turn.sin(), 0.0);
        wheel = wheel.with(rod(middle + way * 0.7 * hub, middle + way * wide, 0.3 * thick));
    }
    let names = words(&["handwheel", "valve wheel", "wheel handle"]);
    draft.add(0, names, vec![hinge(DVec3::Z, top, 0.0, dice.between(1.5, 6.0))], wheel);
    draft
}

pub(super) fn toilet(dice: &mut Dice) -> Draft {
    let (w, bowl, h) = (dice.between(0.34, 0.4), dice.between(0.42, 0.5), dice.between(0.38, 0.43));
    let profile =
        [(0.12, 0.0), (0.1, 0.15), (0.17, h - 0.05), (0.19, h), (0.15, h), (0.1, h - 0.15)];
    let pot = lathe(&profile, at(0.0, -0.05, 0.0), DVec3::Z);
    let (z, y) = (h + dice.between(0.3, 0.4), bowl / 2.0 + 0.02);
    let tank = cuboid(at(0.0, y, (h + z) / 2.0 - 0.02), at(w, 0.18, z - h));
    let bridge = cuboid(at(0.0, 0.16, h - 0.08), at(0.2, 0.24, 0.1));
    let names = words(&["toilet body", "toilet bowl and tank", "toilet"]);
    let mut draft = Draft::new(names, pot.with(tank).with(bridge));
    let pivot = at(0.0, 0.15, h + 0.012);
    let ring = lathe(
        &[(0.12, 0.0), (0.195, 0.0), (0.195, 0.02), (0.12, 0.02)],
        at(0.0, -0.05, h + 0.003),
        DVec3::Z,
    );
    let names = words(&["toilet seat", "seat", "seat ring"]);
    draft.add(0, names, vec![hinge(DVec3::NEG_X, pivot, 0.0, dice.between(1.5, 1.8))], ring);
    let lid =
        lathe(&[(0.198, 0.0), (0.19, 0.015), (0.1, 0.02)], at(0.0, -0.05, h + 0.026), DVec3::Z);
    let names = words(&["toilet lid", "lid", "seat cover"]);
    let above = pivot + DVec3::Z * 0.02;
    draft.add(0, names, vec![hinge(DVec3::NEG_X, above, 0.0, dice.between(1.4, 1.8))], lid);
    if dice.chance(0.5) {
        let knob = at(0.0, y, z - 0.02);
        let button = lathe(&[(0.025, 0.0), (0.022, 0.012)], knob, DVec3::Z);
        let names = words(&["flush button", "button"]);
        draft.add(0, names, vec![slide(DVec3::NEG_Z, knob, 0.008)], button);
    } else {
        let knob = at(-w / 2.0 + 0.05, y - 0.09, z - 0.08);
        let end = knob + at(0.0, -0.02, 0.0);
        let lever = rod(knob, end, 0.008).with(rod(end, end + DVec3::X * 0.08, 0.006));
        let names = words(&["flush lever", "flush handle"]);
        draft.add(0, names, vec![hinge(DVec3::Y, knob, 0.0, 0.6)], lever);
    }
    draft
}

pub(super) fn kettle(dice: &mut Dice) -> Draft {
    let (r, h) = (dice.between(0.07, 0.1), dice.between(0.16, 0.24));
    let side = dice.between(0.65, 0.95);
    let jug = lathe(
        &[(r, 0.0), (r, 0.3 * h), (side * r, h), (side * r - 0.006, h), (0.8 * r, 0.02)],
        DVec3::ZERO,
        DVec3::Z,
    );
    let spout = rod(at(-0.8 * r, 0.0, 0.7 * h), at(-1.4 * r, 0.0, 0.95 * h), 0.014);
    let grip = |a: [f64; 2], b: [f64; 2]| {
        rod(at(a[0] * r, 0.0, a[1] * h), at(b[0] * r, 0.0, b[1] * h), 0.011)
    };
    let body = jug.with(spout).with(grip([side, 0.9], [1.6, 0.85]));
    let body = body.with(grip([1.6, 0.85], [1.6, 0.25])).with(grip([1.6, 0.25], [0.95, 0.2]));
    let names = words(&["kettle body", "kettle", "jug with handle"]);
    let mut draft = Draft::new(names, body);
    let lid = lathe(
        &[(side * r - 0.002, 0.0), (side * r - 0.004, 0.01), (0.02, 0.02), (0.015, 0.035)],
        at(0.0, 0.0, h + 0.001),
        DVec3::Z,
    );
    let motion = if dice.chance(0.6) {
        hinge(DVec3::NEG_Y, at(side * r, 0.0, h), 0.0, dice.between(1.0, 1.6))
    } else {
        slide(DVec3::Z, at(0.0, 0.0, h), 0.08)
    };
    // With the hinge at the handle's side, opening lifts the spout's side.
    let motion = object::JointMotion {
        axis: if motion.kind.turns() { DVec3::Y } else { motion.axis },
        ..motion
    };
    draft.add(0, words(&["lid", "kettle lid", "cover"]), vec![motion], lid);
    let middle = at(1.6 * r, 0.0, 0.85 * h + 0.012);
    let switch = cuboid(middle, at(0.02, 0.012, 0.012));
    if dice.chance(0.5) {
        let names = words(&["lid release button", "button", "power button"]);
        draft.add(0, names, vec![slide(DVec3::NEG_Z, middle, 0.006)], switch);
    } else {
        let names = words(&["power switch", "switch", "toggle"]);
        draft.add(0, names, vec![hinge(DVec3::Y, middle, -0.25, 0.25)], switch);
    }
    draft
}

pub(super) fn bottle(dice: &mut Dice) -> Draft {
    let (r, h, neck) =
        (dice.between(0.03, 0.05), dice.between(0.14, 0.3), dice.between(0.012, 0.022));
    let profile = [
        (r, 0.0),
        (r, 0.65 * h),
        (neck, 0.85 * h),
        (neck, h),
        (neck - 0.003, h),
        (r - 0.004, 0.6 * h),
        (r - 0.004, 0.01),
    ];
    let names = words(&["bottle body", "bottle", "flask"]);
    let mut draft = Draft::new(names, lathe(&profile, DVec3::ZERO, DVec3::Z));
    let foot = at(0.0, 0.0, 0.93 * h);
    if dice.chance(0.25) {
        let collar = [(neck + 0.001, 0.0), (neck + 0.004, 0.0), (neck + 0.002, 0.1 * h)];
        draft.add_to_root(lathe(&collar, foot, DVec3::Z));
        let (low, stroke) = (at(0.0, 0.0, 1.01 * h), dice.between(0.01, 0.03));
        let head = low + DVec3::Z * (stroke + 0.01);
        let stem = rod(low, head, 0.4 * neck);
        let top = lathe(&[(0.7 * neck, 0.0), (0.9 * neck, 0.012)], head, DVec3::Z);
        let middle = head + DVec3::Z * 0.006;
        let nozzle = rod(middle, middle - DVec3::Y * dice.between(1.5, 3.0) * neck, 0.005);
        let names = words(&["pump head", "dispenser pump", "pump", "press top"]);
        let motion = slide(DVec3::NEG_Z, head, stroke);
        draft.add(0, names, vec![motion], stem.with(top).with(nozzle));
        return draft;
    }
    let cap =
        lathe(&[(neck + 0.001, 0.0), (neck + 0.004, 0.0), (neck + 0.004, 0.1 * h)], foot, DVec3::Z);
    match dice.count(0, 2) {
        0 => {
            let motions = vec![slide(DVec3::Z, foot, 0.05), spin(DVec3::Z, foot)];
            draft.add(0, words(&["screw cap", "bottle cap", "cap"]), motions, cap);
        }
        1 => {
            let motions = vec![spin(DVec3::Z, foot)];
            draft.add(0, words(&["twist cap", "cap", "screw top"]), motions, cap);
        }
        _ => {
            let top = at(0.0, neck + 0.006, 1.03 * h);
            let motion = hinge(DVec3::NEG_X, top, 0.0, dice.between(FRAC_PI_2, 2.4));
            draft.add(0, words(&["flip cap", "flip-top lid", "hinged cap"]), vec![motion], cap);
        }
    }
    draft
}
