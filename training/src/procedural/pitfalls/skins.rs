//! Objects that come as one closed skin over all parts, on which seams are shallow.

use std::f64::consts::FRAC_PI_2;

use object::DVec3;

use super::super::draft::{Dice, at, cuboid, handle, hinge, lathe, rod, shell, slide, spin, tray};
use super::fronts::called;
use super::sketch::{Sketch, barrels, between};

/// The skins of the recipe that confidence is fitted with.
const SKINS: [&str; 2] = ["96", "160:35000:0.85:1.5"];

/// Fused objects: a part leaks where its edge is a step or a shallow groove.
pub(super) fn leak_into_the_parent(index: usize, dice: &mut Dice) -> Sketch {
    let mut sketch = match index % 5 {
        0 => nightstand(dice),
        1 => freezer(dice),
        2 => washer(dice),
        3 => sideboard(dice),
        _ => bin(dice),
    };
    sketch.skin = Some(SKINS[index % SKINS.len()]);
    sketch
}

/// Drawers whose fronts lie before the carcass.
fn nightstand(dice: &mut Dice) -> Sketch {
    let size = at(dice.between(0.4, 0.5), dice.between(0.35, 0.45), dice.between(0.45, 0.6));
    let (low, high) =
        (at(-size.x / 2.0, -size.y / 2.0, 0.0), at(size.x / 2.0, size.y / 2.0, size.z));
    let top =
        between(at(low.x - 0.01, low.y - 0.025, high.z), at(high.x + 0.01, high.y, high.z + 0.02));
    let click = at(0.0, 0.0, high.z + 0.02);
    let mut sketch =
        Sketch::new("nightstand", ("nightstand body", click), shell(low, high, 0.018).with(top));
    let rows = dice.count(2, 3);
    let room = (size.z - 0.03) / rows as f64;
    let (thick, y) = (dice.between(0.014, 0.02), low.y - 0.001);
    for i in 0..rows {
        let upper = size.z - room * i as f64 - 0.006;
        let (a, b) =
            (at(low.x + 0.008, y - thick, upper - room + 0.008), at(high.x - 0.008, y, upper));
        let boxed = tray(
            at(low.x + 0.03, y, a.z + 0.02),
            at(high.x - 0.03, high.y - 0.04, b.z - 0.04),
            0.012,
        );
        let middle = at(0.0, a.y, (a.z + b.z) / 2.0);
        let knob = lathe(
            &[(0.012, 0.0), (0.012, 0.012), (0.022, 0.022), (0.018, 0.034)],
            middle,
            DVec3::NEG_Y,
        );
        let click = middle + at(dice.between(-0.35, 0.35) * size.x, 0.0, 0.0);
        let motion = slide(DVec3::NEG_Y, middle, dice.between(0.5, 0.7) * size.y);
        sketch.add(
            0,
            (called("drawer", i, rows), click),
            motion,
            between(a, b).with(boxed).with(knob),
        );
    }
    sketch
}

/// A tub with a lid that stands a little over.
fn freezer(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.7, 1.1), dice.between(0.55, 0.7), dice.between(0.65, 0.8));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let grille = cuboid(at(0.3 * w, low.y, 0.12), at(0.25 * w, 0.012, 0.12));
    let body = tray(low, high, 0.05).with(grille);
    let mut sketch = Sketch::new("chest freezer", ("freezer body", at(0.0, low.y, 0.4 * h)), body);
    let (over, thick) = (dice.between(0.006, 0.014), dice.between(0.05, 0.08));
    let (a, b) =
        (at(low.x - over, low.y - over, h + 0.003), at(high.x + over, high.y, h + 0.003 + thick));
    let grip = cuboid(at(0.0, a.y - 0.012, h + 0.03), at(dice.between(0.15, 0.3), 0.03, 0.025));
    let motion = hinge(DVec3::NEG_X, at(0.0, high.y, h + 0.003), 0.0, dice.between(1.2, 1.6));
    let click = at(dice.between(-0.3, 0.3) * w, 0.0, b.z);
    sketch.add(0, ("freezer lid", click), motion, between(a, b).with(grip));
    sketch
}

/// A porthole, a soap drawer and a knob on one front.
fn washer(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (0.6, dice.between(0.5, 0.6), dice.between(0.82, 0.88));
    let front = -d / 2.0;
    let body = cuboid(at(0.0, 0.0, h / 2.0), at(w, d, h));
    let mut sketch = Sketch::new("washing machine", ("machine body", at(0.0, 0.0, h)), body);
    let (r, z) = (dice.between(0.15, 0.19), dice.between(0.38, 0.42));
    let centre = at(0.0, front, z);
    let ring = lathe(
        &[(r, 0.002), (r, 0.025), (0.9 * r, 0.035), (0.6 * r, 0.03), (0.5 * r, 0.015)],
        centre,
        DVec3::NEG_Y,
    );
    let is_left = dice.chance(0.5);
    let out = if is_left { 1.0 } else { -1.0 };
    let grip = cuboid(centre + at(out * 0.9 * r, -0.045, 0.0), at(0.03, 0.025, 0.1));
    let hung = centre - DVec3::X * out * (r + 0.01);
    let motion = hinge(DVec3::NEG_Z * out, hung - DVec3::Y * 0.015, 0.0, dice.between(1.6, 2.4));
    sketch.draft.add_to_root(barrels(
        [hung - at(0.0, 0.015, 0.06), hung + at(0.0, -0.015, 0.06)],
        2,
        0.014,
    ));
    sketch.add(0, ("round door", centre - at(0.0, 0.03, 0.5 * r)), motion, ring.with(grip));
    let soap = cuboid(at(-0.2, front - 0.006, h - 0.08), at(0.16, 0.016, 0.09));
    let bath = cuboid(at(-0.2, front + 0.1, h - 0.08), at(0.14, 0.19, 0.06));
    let lip = cuboid(at(-0.2, front - 0.022, h - 0.115), at(0.1, 0.02, 0.018));
    let motion = slide(DVec3::NEG_Y, at(-0.2, front, h - 0.08), dice.between(0.12, 0.18));
    sketch.add(
        0,
        ("detergent drawer", at(-0.2, front - 0.014, h - 0.06)),
        motion,
        soap.with(bath).with(lip),
    );
    let place = at(dice.between(0.0, 0.2), front, h - 0.08);
    let dial = lathe(&[(0.035, 0.001), (0.03, 0.028)], place, DVec3::NEG_Y);
    let mark = cuboid(place + at(0.0, -0.03, 0.018), at(0.006, 0.01, 0.02));
    sketch.add(
        0,
        ("programme knob", place - DVec3::Y * 0.028),
        spin(DVec3::NEG_Y, place),
        dial.with(mark),
    );
    sketch
}

/// A drawer between two doors.
fn sideboard(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(1.1, 1.5), dice.between(0.38, 0.45), dice.between(0.6, 0.75));
    let foot = 0.12;
    let (low, high) = (at(-w / 2.0, -d / 2.0, foot), at(w / 2.0, d / 2.0, h));
    let mut body = shell(low, high, 0.02);
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let top = at(x * (w / 2.0 - 0.06), y * (d / 2.0 - 0.06), foot);
        body = body.with(rod(top - DVec3::Z * foot, top, 0.02));
    }
    let post = dice.between(0.14, 0.2) * w;
    for x in [-post, post] {
        body = body.with(cuboid(at(x, 0.0, (foot + h) / 2.0), at(0.02, d - 0.04, h - foot - 0.04)));
    }
    let shelf = cuboid(at(0.0, 0.0, (foot + h) / 2.0), at(2.0 * post, d - 0.04, 0.02));
    let mut sketch =
        Sketch::new("sideboard", ("sideboard body", at(0.0, 0.0, h)), body.with(shelf));
    let (thick, y) = (dice.between(0.016, 0.022), low.y - 0.001);
    let gap = dice.between(0.008, 0.014);
    for (name, out) in [("left door", -1.0), ("right door", 1.0)] {
        let (near, far) = (out * (post + gap), out * (w / 2.0 - 0.008));
        let (a, b) = (at(near.min(far), y - thick, foot + 0.008), at(near.max(far), y, h - 0.008));
        let middle = at(near + out * 0.05, a.y, (foot + h) / 2.0);
        let grip = handle(middle, DVec3::Z, dice.between(0.12, 0.2), DVec3::NEG_Y);
        let motion = hinge(DVec3::Z * out, at(far, y, foot), 0.0, dice.between(1.5, 1.9));
        let click = middle + at(out * 0.1, 0.0, dice.between(-0.1, 0.1));
        sketch.add(0, (name, click), motion, between(a, b).with(grip));
    }
    for (i, (from, to)) in
        [((foot + h) / 2.0 + 0.006, h - 0.008), (foot + 0.008, (foot + h) / 2.0 - 0.006)]
            .into_iter()
            .enumerate()
    {
        let (a, b) = (at(-post + 0.002, y - thick, from), at(post - 0.002, y, to));
        let boxed =
            tray(at(-post + 0.025, y, from + 0.02), at(post - 0.025, 0.4 * d, to - 0.04), 0.01);
        let middle = at(0.0, a.y, (from + to) / 2.0);
        let knob =
            lathe(&[(0.01, 0.0), (0.01, 0.012), (0.02, 0.02), (0.016, 0.03)], middle, DVec3::NEG_Y);
        let motion = slide(DVec3::NEG_Y, middle, 0.6 * d);
        sketch.add(
            0,
            (called("drawer", i, 2), middle - DVec3::Y * 0.03),
            motion,
            between(a, b).with(boxed).with(knob),
        );
    }
    sketch
}

/// A bin under a hood with a flap, and a door behind which the bag hangs.
fn bin(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.3, 0.45), dice.between(0.3, 0.4), dice.between(0.7, 1.0));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let split = dice.between(0.68, 0.75) * h;
    let rail = cuboid(at(0.0, low.y + 0.01, split), at(w - 0.04, 0.02, 0.03));
    let mut sketch = Sketch::new(
        "litter bin",
        ("bin housing", at(0.0, 0.0, h)),
        shell(low, high, 0.02).with(rail),
    );
    let thick = dice.between(0.012, 0.018);
    let flap = between(
        at(low.x + 0.03, low.y - 0.006, split + 0.025),
        at(high.x - 0.03, low.y - 0.006 + thick, h - 0.03),
    );
    let word = cuboid(at(0.0, low.y - 0.011, split + 0.07), at(0.4 * w, 0.01, 0.03));
    // Pushed inward at its lower edge.
    let motion = hinge(DVec3::X, at(0.0, low.y, h - 0.03), 0.0, dice.between(0.7, 1.1));
    let click = at(0.3 * w, low.y - 0.006, (split + h) / 2.0);
    sketch.add(0, ("push flap", click), motion, flap.with(word));
    let is_left = dice.chance(0.5);
    let out = if is_left { 1.0 } else { -1.0 };
    let door = between(
        at(low.x + 0.01, low.y - thick, 0.03),
        at(high.x - 0.01, low.y - 0.001, split - 0.025),
    );
    let lock = lathe(
        &[(0.016, 0.0), (0.014, 0.015)],
        at(out * 0.38 * w, low.y - thick, 0.5 * split),
        DVec3::NEG_Y,
    );
    let motion =
        hinge(DVec3::NEG_Z * out, at(-out * (w / 2.0 - 0.01), low.y, 0.03), 0.0, FRAC_PI_2);
    sketch.add(
        0,
        ("service door", at(0.1 * w, low.y - thick, 0.25 * split)),
        motion,
        door.with(lock),
    );
    sketch
}
