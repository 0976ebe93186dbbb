//! Hinges where one would not look for them: across what is long, and beside what looks like a grip.

use std::f64::consts::FRAC_PI_2;

use object::DVec3;

use super::super::draft::{Dice, at, cuboid, handle, hinge, lathe, rod, shell, tray};
use super::sketch::{Sketch, barrels, between};

/// What is long and turns about its short way.
pub(super) fn axis_along_the_long_direction(index: usize, dice: &mut Dice) -> Sketch {
    match index % 5 {
        0 => bench(dice),
        1 => guillotine(dice),
        2 => barrier(dice),
        3 => ironing_board(dice),
        _ => seesaw(dice),
    }
}

/// A long bench whose lid is hung at its short end.
fn bench(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.9, 1.3), dice.between(0.3, 0.42), dice.between(0.4, 0.5));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let side = if dice.chance(0.5) { 1.0 } else { -1.0 };
    let edge = at(-side * (w / 2.0 + 0.008), 0.0, h + 0.002);
    let pins = barrels([edge - DVec3::Y * 0.4 * d, edge + DVec3::Y * 0.4 * d], 3, 0.008);
    let mut sketch = Sketch::new(
        "storage bench",
        ("bench box", at(0.0, low.y, 0.5 * h)),
        tray(low, high, 0.018).with(pins),
    );
    let lid = between(at(low.x, low.y - 0.01, h + 0.002), at(high.x, high.y + 0.01, h + 0.024));
    let pull = cuboid(
        at(side * (w / 2.0 + 0.012), 0.0, h + 0.012),
        at(0.026, dice.between(0.08, 0.14), 0.012),
    );
    // Up, away from the end where it hangs.
    let motion = hinge(DVec3::NEG_Y * side, edge, 0.0, dice.between(1.2, 1.6));
    let click = at(side * 0.3 * w, 0.0, h + 0.024);
    sketch.add(0, ("bench lid", click), motion, lid.with(pull));
    sketch
}

/// A cutter's arm, pinned at its far end.
fn guillotine(dice: &mut Dice) -> Sketch {
    let (w, long) = (dice.between(0.25, 0.4), dice.between(0.35, 0.5));
    let board = cuboid(at(0.0, 0.0, 0.012), at(w, long, 0.024));
    let fence = cuboid(at(0.0, long / 2.0 - 0.012, 0.03), at(w, 0.02, 0.012));
    let feet = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let body = feet.into_iter().fold(board.with(fence), |body, (x, y)| {
        body.with(cuboid(at(x * 0.45 * w, y * 0.45 * long, -0.006), at(0.02, 0.02, 0.012)))
    });
    let pin = at(w / 2.0 + 0.008, long / 2.0 - 0.03, 0.034);
    let cheek = cuboid(pin + at(0.014, 0.0, -0.014), at(0.006, 0.03, 0.045));
    let bolt = rod(pin - DVec3::X * 0.008, pin + DVec3::X * 0.022, 0.006);
    let mut sketch = Sketch::new(
        "paper cutter",
        ("cutting board", at(-0.2 * w, 0.0, 0.024)),
        body.with(cheek).with(bolt),
    );
    let lift = dice.between(0.1, 0.4);
    let turn =
        object::DPose3::from_translation(pin) * object::DPose3::rotation(DVec3::NEG_X * lift);
    let reach = long + dice.between(0.02, 0.06);
    let blade = cuboid(at(0.0, -reach / 2.0, -0.006), at(0.004, reach, 0.03));
    let back = cuboid(at(0.0, -reach / 2.0, 0.014), at(0.012, reach, 0.01));
    let grip = rod(at(0.0, -reach, 0.01), at(0.0, -reach - 0.1, 0.014), 0.012);
    let motion = hinge(DVec3::NEG_X, pin, -lift, 1.2 - lift);
    let click = turn * at(0.0, -0.6 * reach, 0.019);
    sketch.add(0, ("cutter arm", click), motion, blade.with(back).with(grip).moved(turn));
    sketch
}

/// A boom beside its post.
fn barrier(dice: &mut Dice) -> Sketch {
    let (long, high) = (dice.between(2.0, 3.5), dice.between(0.85, 1.05));
    let post = between(at(-0.15, 0.0, 0.0), at(0.15, 0.25, high + 0.1));
    let foot = cuboid(at(0.0, 0.125, 0.01), at(0.4, 0.35, 0.02));
    let pin = at(0.0, -0.04, high);
    let hub = rod(at(0.0, 0.01, high), at(0.0, -0.012, high), 0.06);
    let mut sketch = Sketch::new(
        "car park barrier",
        ("barrier post", at(0.0, 0.25, 0.5)),
        post.with(foot).with(hub),
    );
    let side = if dice.chance(0.5) { 1.0 } else { -1.0 };
    let boom = cuboid(
        at(side * (long / 2.0 - 0.25), -0.04, high),
        at(long, 0.04, dice.between(0.06, 0.1)),
    );
    let weight = cuboid(at(-side * 0.32, -0.04, high), at(0.22, 0.05, 0.2));
    let cap = rod(at(0.0, -0.061, high), at(0.0, -0.08, high), 0.05);
    let motion = hinge(DVec3::NEG_Y * side, pin, 0.0, dice.between(1.3, FRAC_PI_2));
    let click = at(side * dice.between(0.3, 0.7) * long, -0.06, high);
    sketch.add(0, ("barrier arm", click), motion, boom.with(weight).with(cap));
    sketch
}

/// A board that stands in its cupboard and folds down about its foot.
fn ironing_board(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.34, 0.42), dice.between(0.14, 0.2), dice.between(1.2, 1.4));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let sill = dice.between(0.06, 0.1);
    let pin = at(0.0, low.y + 0.03, sill);
    let shelf = between(at(low.x + 0.018, low.y, 0.018), at(high.x - 0.018, high.y - 0.018, 0.04));
    let ears =
        [-1.0, 1.0].map(|x| cuboid(at(x * (w / 2.0 - 0.03), pin.y, 0.06), at(0.02, 0.03, 0.04)));
    let body = ears
        .into_iter()
        .fold(shell(low, high, 0.018).with(shelf), super::super::shapes::Shape::with);
    let mut sketch =
        Sketch::new("ironing board cupboard", ("cupboard", at(low.x, 0.0, 0.5 * h)), body);
    let (half, tip) = (w / 2.0 - 0.05, h - 0.12);
    let board = between(at(-half, pin.y - 0.01, sill + 0.01), at(half, pin.y + 0.012, tip - 0.1));
    let nose =
        between(at(-0.6 * half, pin.y - 0.01, tip - 0.1), at(0.6 * half, pin.y + 0.012, tip));
    let axle = rod(at(-half - 0.005, pin.y, sill), at(half + 0.005, pin.y, sill), 0.008);
    let strut = cuboid(at(0.0, pin.y + 0.025, 0.5 * tip), at(0.04, 0.02, 0.6 * tip));
    let motion = hinge(DVec3::X, pin, 0.0, dice.between(1.5, FRAC_PI_2));
    let click = at(0.3 * half, pin.y - 0.01, dice.between(0.3, 0.7) * tip);
    sketch.add(0, ("ironing board", click), motion, board.with(nose).with(axle).with(strut));
    sketch
}

/// A plank across a stand, tilted to one side.
fn seesaw(dice: &mut Dice) -> Sketch {
    let (long, wide, high) =
        (dice.between(1.6, 2.4), dice.between(0.2, 0.3), dice.between(0.45, 0.6));
    let pin = at(0.0, 0.0, high);
    let side = |y: f64| {
        let foot = |x: f64| rod(at(x, y, 0.0), at(0.0, y, high), 0.025);
        foot(-0.3).with(foot(0.3)).with(rod(at(-0.32, y, 0.02), at(0.32, y, 0.02), 0.02))
    };
    let y = wide / 2.0 + 0.06;
    let axle = rod(at(0.0, -y - 0.02, high), at(0.0, y + 0.02, high), 0.018);
    let body = side(-y).with(side(y)).with(axle);
    let mut sketch = Sketch::new("seesaw", ("stand", at(-0.2, -y, 0.2)), body);
    let tilt = dice.between(-0.2, 0.2);
    let turn = object::DPose3::from_translation(pin) * object::DPose3::rotation(DVec3::Y * tilt);
    let plank = cuboid(at(0.0, 0.0, 0.04), at(long, wide, 0.035));
    let clip = cuboid(at(0.0, 0.0, 0.0), at(0.08, wide * 0.8, 0.06));
    let seat = |x: f64| {
        let post = rod(
            at(x * (long / 2.0 - 0.4), 0.0, 0.05),
            at(x * (long / 2.0 - 0.4), 0.0, 0.25),
            0.015,
        );
        let bar = at(x * (long / 2.0 - 0.4), 0.0, 0.25);
        post.with(rod(bar - DVec3::Y * 0.15, bar + DVec3::Y * 0.15, 0.012))
    };
    let motion = hinge(DVec3::Y, pin, -0.3 - tilt, 0.3 - tilt);
    let click = turn * at(0.35 * long, 0.0, 0.0575);
    sketch.add(
        0,
        ("plank", click),
        motion,
        plank.with(clip).with(seat(-1.0)).with(seat(1.0)).moved(turn),
    );
    sketch
}

/// Doors on whose hinge side something looks like a grip, or whose grip is in the middle.
pub(super) fn hinge_on_the_handles_side(index: usize, dice: &mut Dice) -> Sketch {
    match index % 5 {
        0 => towel_bar(dice),
        1 => safe(dice),
        2 => letter_gate(dice),
        3 => refrigerator(dice),
        _ => lift_flap(dice),
    }
}

/// The side where a door hangs: −1 left, 1 right.
fn side(dice: &mut Dice) -> f64 {
    if dice.chance(0.5) { -1.0 } else { 1.0 }
}

/// The axis of a door that hangs on a side and opens towards the viewer.
fn upright(side: f64) -> DVec3 {
    DVec3::Z * side
}

/// A cupboard door with a knob near its middle, and a towel bar along the side where it hangs.
fn towel_bar(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.4, 0.55), dice.between(0.3, 0.45), dice.between(0.6, 0.85));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let hung = side(dice);
    let edge = at(hung * (w / 2.0 + 0.006), low.y - 0.01, 0.0);
    let pins = barrels([edge + DVec3::Z * 0.05 * h, edge + DVec3::Z * 0.95 * h], 2, 0.007);
    let mut sketch = Sketch::new(
        "bathroom cupboard",
        ("cupboard body", at(0.0, 0.0, h)),
        shell(low, high, 0.018).with(pins),
    );
    let y = low.y - 0.002;
    let door = between(at(low.x, y - 0.018, 0.004), at(high.x, y, h - 0.004));
    let rail = at(hung * 0.36 * w, y - 0.018, 0.5 * h);
    let bar = handle(rail, DVec3::Z, dice.between(0.4, 0.6) * h, DVec3::NEG_Y);
    let place = at(-hung * dice.between(0.1, 0.42) * w, y - 0.018, dice.between(0.45, 0.65) * h);
    let knob =
        lathe(&[(0.007, 0.0), (0.007, 0.012), (0.016, 0.02), (0.013, 0.03)], place, DVec3::NEG_Y);
    let motion = hinge(upright(hung), edge, 0.0, dice.between(1.5, 2.0));
    sketch.add(0, ("door", rail - DVec3::Y * 0.04), motion, door.with(bar).with(knob));
    sketch
}

/// A safe: a wheel in the middle of its door, a keypad on the side where it hangs.
fn safe(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.35, 0.5), dice.between(0.35, 0.45), dice.between(0.4, 0.6));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let hung = side(dice);
    let (wall, y) = (0.04, low.y);
    let edge = at(hung * (w / 2.0 - wall), y - 0.012, 0.0);
    let pins = barrels([edge + DVec3::Z * 0.12 * h, edge + DVec3::Z * 0.88 * h], 2, 0.012);
    let mut sketch =
        Sketch::new("safe", ("safe body", at(0.0, 0.0, h)), shell(low, high, wall).with(pins));
    let x = w / 2.0 - wall - 0.014;
    let door = between(at(-x, y - 0.004, wall + 0.003), at(x, y + 0.03, h - wall - 0.003));
    let pad = cuboid(at(hung * 0.55 * x, y - 0.014, 0.62 * h), at(0.07, 0.02, 0.1));
    let centre = at(-hung * 0.1 * x, y - 0.004, 0.5 * h);
    let hub = rod(centre, centre - DVec3::Y * 0.03, 0.014);
    let spokes = [0.0_f64, 2.1, 4.2].into_iter().fold(hub, |all, turn| {
        let tip = centre - DVec3::Y * 0.03 + at(turn.sin(), 0.0, turn.cos()) * 0.06;
        all.with(rod(centre - DVec3::Y * 0.03, tip, 0.006))
    });
    let motion = hinge(upright(hung), edge, 0.0, dice.between(1.5, 2.2));
    sketch.add(0, ("safe door", centre - DVec3::Y * 0.035), motion, door.with(pad).with(spokes));
    sketch
}

/// A garden gate between two posts: straps on the gate, a latch, and a letter box by the hinges.
fn letter_gate(dice: &mut Dice) -> Sketch {
    let (w, h) = (dice.between(0.8, 1.1), dice.between(0.9, 1.3));
    let hung = side(dice);
    let post = |x: f64| cuboid(at(x * (w / 2.0 + 0.07), 0.0, 0.55 * h), at(0.1, 0.1, 1.1 * h));
    let edge = at(hung * (w / 2.0 + 0.01), -0.03, 0.0);
    let pins = barrels([edge + DVec3::Z * 0.1 * h, edge + DVec3::Z * 0.9 * h], 2, 0.012);
    let mut sketch = Sketch::new(
        "garden gate",
        ("gate posts", at(w / 2.0 + 0.07, -0.05, 0.5)),
        post(-1.0).with(post(1.0)).with(pins),
    );
    let slats = dice.count(5, 8);
    let pitch = w / slats as f64;
    let rail = |z: f64| cuboid(at(0.0, 0.02, z), at(w - 0.01, 0.03, 0.08));
    let mut gate = rail(0.2 * h).with(rail(0.8 * h));
    for i in 0..slats {
        let x = -w / 2.0 + pitch * (i as f64 + 0.5);
        gate = gate.with(cuboid(at(x, -0.005, 0.5 * h), at(0.75 * pitch, 0.018, h - 0.1)));
    }
    for z in [0.2, 0.8] {
        let strap = at(hung * (w / 2.0 - 0.15), -0.017, z * h);
        gate = gate.with(cuboid(strap, at(0.3, 0.005, 0.03)));
    }
    let letters = cuboid(at(hung * 0.25 * w, -0.055, 0.52 * h), at(0.2, 0.08, 0.18));
    let latch = at(-hung * (w / 2.0 - 0.06), -0.014, 0.6 * h);
    let latch = rod(latch, latch - DVec3::Y * 0.03, 0.01)
        .with(cuboid(latch - at(0.0, 0.035, 0.0), at(0.05, 0.01, 0.02)));
    let motion = hinge(upright(hung), edge, 0.0, dice.between(1.3, 1.8));
    let click = at(hung * 0.25 * w, -0.095, 0.52 * h);
    sketch.add(0, ("gate", click), motion, gate.with(letters).with(latch));
    sketch
}

/// A door with grips along both its edges, hung on brackets at its corners.
fn refrigerator(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.5, 0.6), dice.between(0.5, 0.6), dice.between(0.8, 1.2));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.04), at(w / 2.0, d / 2.0, h));
    let hung = side(dice);
    let x = hung * (w / 2.0 - 0.02);
    let bracket = |z: f64| {
        cuboid(at(x, low.y - 0.02, z), at(0.04, 0.06, 0.008)).with(rod(
            at(x, low.y - 0.03, z - 0.009),
            at(x, low.y - 0.03, z + 0.009),
            0.008,
        ))
    };
    let body = shell(low, high, 0.03).with(bracket(h + 0.006)).with(bracket(0.034));
    let mut sketch =
        Sketch::new("small refrigerator", ("refrigerator body", at(0.0, 0.0, h)), body);
    let door = between(at(low.x, low.y - 0.05, 0.045), at(high.x, low.y - 0.004, h - 0.004));
    let strip =
        |x: f64| cuboid(at(x * (w / 2.0 - 0.02), low.y - 0.06, 0.55 * h), at(0.025, 0.02, 0.5 * h));
    let motion = hinge(upright(hung), at(x, low.y - 0.03, 0.04), 0.0, dice.between(1.5, 2.1));
    let click = at(hung * (w / 2.0 - 0.02), low.y - 0.07, 0.5 * h);
    sketch.add(0, ("door", click), motion, door.with(strip(-1.0)).with(strip(1.0)));
    sketch
}

/// A flap that is lifted, whose bar lies in its upper half.
fn lift_flap(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.6, 0.9), dice.between(0.28, 0.36), dice.between(0.34, 0.45));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let edge = at(0.0, low.y - 0.012, h + 0.006);
    let pins = barrels([edge - DVec3::X * 0.42 * w, edge + DVec3::X * 0.42 * w], 3, 0.007);
    let mut sketch = Sketch::new(
        "wall cabinet",
        ("cabinet body", at(low.x, 0.0, 0.5 * h)),
        shell(low, high, 0.018).with(pins),
    );
    let y = low.y - 0.002;
    let flap = between(at(low.x, y - 0.018, 0.003), at(high.x, y, h - 0.004));
    let middle = at(0.0, y - 0.018, dice.between(0.5, 0.7) * h);
    let bar = handle(middle, DVec3::X, dice.between(0.3, 0.6) * w, DVec3::NEG_Y);
    let motion = hinge(DVec3::NEG_X, edge, 0.0, dice.between(1.3, 1.8));
    sketch.add(0, ("flap door", middle - DVec3::Y * 0.04), motion, flap.with(bar));
    sketch
}
