//! What slides where one would not look for it, and what is shown open.

use std::f64::consts::FRAC_PI_2;

use object::DVec3;

use super::super::draft::{Dice, at, cuboid, handle, hinge, lathe, rod, shell, slide, tray};
use super::super::shapes::Shape;
use super::fronts::called;
use super::sketch::{Sketch, between};

/// Drawers at unusual sides or without a grip, and what is truly pushed in.
pub(super) fn slides_inward(index: usize, dice: &mut Dice) -> Sketch {
    match index % 5 {
        0 => side_rack(dice),
        1 => till(dice),
        2 => recessed(dice),
        3 => writing_slide(dice),
        _ => push_panel(dice),
    }
}

/// A tall narrow rack that comes out of a cabinet's side.
fn side_rack(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.5, 0.7), dice.between(0.18, 0.28), dice.between(0.9, 1.3));
    let out = if dice.chance(0.5) { 1.0 } else { -1.0 };
    let t = 0.018;
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let far = -out * (w / 2.0 - t / 2.0);
    let body = between(low, at(high.x, low.y + t, h))
        .with(between(at(low.x, high.y - t, 0.0), high))
        .with(between(at(low.x, low.y + t, 0.0), at(high.x, high.y - t, t)))
        .with(between(at(low.x, low.y + t, h - t), at(high.x, high.y - t, h)))
        .with(cuboid(at(far, 0.0, h / 2.0), at(t, d - 2.0 * t, h - 2.0 * t)));
    let mut sketch = Sketch::new("pull-out pantry", ("pantry body", at(0.0, low.y, 0.5 * h)), body);
    let face = out * (w / 2.0 + 0.001);
    let front = cuboid(at(face + out * 0.009, 0.0, h / 2.0), at(0.018, d - 0.004, h - 0.006));
    let long = w - 2.0 * t - 0.03;
    let shelf = |z: f64| {
        let middle = face - out * (0.002 + long / 2.0);
        let half = at(long / 2.0, d / 2.0 - t - 0.006, 0.0);
        tray(at(middle, 0.0, z) - half, at(middle, 0.0, z + 0.08) + half, 0.008)
    };
    let shelves = dice.count(2, 4);
    let place = |i: usize| 0.04 + (h - 0.2) * i as f64 / shelves as f64;
    let rack = (0..shelves).fold(front, |rack, i| rack.with(shelf(place(i))));
    let middle = at(face + out * 0.018, 0.0, dice.between(0.5, 0.7) * h);
    let grip = handle(middle, DVec3::Z, dice.between(0.15, 0.3), DVec3::X * out);
    let motion = slide(DVec3::X * out, middle, dice.between(0.6, 0.85) * long);
    sketch.add(0, ("pull-out rack", middle + DVec3::X * out * 0.04), motion, rack.with(grip));
    sketch
}

/// A till on a counter whose money drawer opens to the back.
fn till(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.35, 0.45), dice.between(0.35, 0.45), dice.between(0.1, 0.13));
    let t = 0.008;
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let half_turn = object::DPose3::rotation(DVec3::Z * std::f64::consts::PI);
    let screen = cuboid(at(0.0, -0.05, h + 0.17), at(0.3, 0.02, 0.2));
    let post = rod(at(0.0, -0.05, h), at(0.0, -0.05, h + 0.08), 0.02);
    let body = shell(low, high, t).moved(half_turn).with(screen).with(post);
    let mut sketch = Sketch::new("cash register", ("till housing", at(0.0, -0.06, h + 0.17)), body);
    let front = between(
        at(low.x + t + 0.002, high.y - 0.012, t + 0.002),
        at(high.x - t - 0.002, high.y, h - t - 0.002),
    );
    let boxed = tray(
        at(low.x + t + 0.006, low.y + 0.05, t + 0.004),
        at(high.x - t - 0.006, high.y - 0.012, h - t - 0.02),
        0.004,
    );
    let cups = (1..4).fold(boxed, |all, i| {
        let x = low.x + t + 0.006 + (w - 2.0 * t - 0.012) * f64::from(i) / 4.0;
        all.with(cuboid(at(x, 0.02, h / 2.0), at(0.003, d - 0.1, 0.5 * h)))
    });
    let lock = lathe(&[(0.012, 0.0), (0.01, 0.006)], at(0.3 * w, high.y, 0.6 * h), DVec3::Y);
    let motion = slide(DVec3::Y, at(0.0, high.y, h / 2.0), dice.between(0.5, 0.75) * d);
    sketch.add(
        0,
        ("cash drawer", at(-0.1 * w, high.y, 0.5 * h)),
        motion,
        front.with(cups).with(lock),
    );
    sketch
}

/// Drawers that stand back in their openings, with a hole for a finger instead of a grip.
fn recessed(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.4, 0.7), dice.between(0.3, 0.4), dice.between(0.35, 0.6));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let (rows, t) = (dice.count(1, 3), 0.018);
    let room = (h - t) / rows as f64;
    let shelf =
        |i: usize| cuboid(at(0.0, -t / 2.0, room * i as f64 + t / 2.0), at(w - 2.0 * t, d - t, t));
    let body = (1..rows).fold(shell(low, high, t), |body, i| body.with(shelf(i)));
    let mut sketch = Sketch::new("toy shelf", ("shelf", at(0.0, 0.0, h)), body);
    let (back, x) = (dice.between(0.02, 0.05), w / 2.0 - t - 0.004);
    for i in 0..rows {
        let (from, to) = (h - room * (i as f64 + 1.0) + 0.003, h - room * i as f64 - t - 0.02);
        let y = low.y + back;
        let slot = [0.22 * x, 0.022];
        let top = to - 0.04;
        let front = between(at(-x, y, from), at(x, y + 0.012, top - slot[1]))
            .with(between(at(-x, y, top - slot[1]), at(-slot[0], y + 0.012, top)))
            .with(between(at(slot[0], y, top - slot[1]), at(x, y + 0.012, top)))
            .with(between(at(-x, y, top), at(x, y + 0.012, to)));
        let boxed = tray(at(-x, y + 0.012, from), at(x, high.y - t - 0.01, to - 0.01), 0.01);
        let motion = slide(DVec3::NEG_Y, at(0.0, y, from), dice.between(0.6, 0.8) * d);
        let click = at(0.4 * x, y, from + 0.02);
        sketch.add(0, (called("toy drawer", i, rows), click), motion, front.with(boxed));
    }
    sketch
}

/// A thin leaf in a slot beneath a desk's top, at a side or in front.
fn writing_slide(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.9, 1.3), dice.between(0.5, 0.65), dice.between(0.7, 0.76));
    let out = if dice.chance(0.5) { 1.0 } else { -1.0 };
    let (t, slot) = (0.022, 0.024);
    let top = cuboid(at(0.0, 0.0, h - t / 2.0), at(w, d, t));
    let cheek = |x: f64, high: f64| cuboid(at(x, 0.0, high / 2.0), at(t, d - 0.02, high));
    let under = cuboid(at(0.0, 0.0, h - t - slot - t / 2.0), at(w - 0.04, d - 0.04, t));
    let stays = [-1.0, 1.0].map(|y| {
        cuboid(at(0.0, y * (d / 2.0 - 0.03), h - t - slot / 2.0), at(w - 0.04, 0.018, slot))
    });
    let inner = w / 2.0 - 0.04;
    let body = top
        .with(cheek(inner, h - 2.0 * t - slot))
        .with(cheek(-inner, h - 2.0 * t - slot))
        .with(under);
    let body = stays.into_iter().fold(body, Shape::with);
    let mut sketch = Sketch::new("writing desk", ("desk", at(0.0, 0.0, h)), body);
    let (long, start) = (dice.between(0.3, 0.42), out * (w / 2.0 - 0.005));
    let middle = at(start - out * long / 2.0, 0.0, h - t - slot / 2.0);
    let leaf = cuboid(middle, at(long, d - 0.12, 0.018));
    let grip = at(start, dice.between(-0.1, 0.1), middle.z);
    let knob = lathe(
        &[(0.004, 0.0), (0.004, 0.012), (0.009, 0.018), (0.007, 0.026)],
        grip,
        DVec3::X * out,
    );
    let motion = slide(DVec3::X * out, grip, dice.between(0.6, 0.8) * long);
    sketch.add(0, ("writing slide", grip + DVec3::X * out * 0.026), motion, leaf.with(knob));
    sketch
}

/// Buttons that go in, and a drawer for coins that comes out.
fn push_panel(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.25, 0.4), dice.between(0.2, 0.3), dice.between(0.4, 0.6));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let split = 0.35 * h;
    let block = between(at(low.x, low.y + 0.004, split), high);
    let body = shell(low, at(high.x, high.y, split), 0.012).with(block);
    let mut sketch = Sketch::new("ticket machine", ("machine housing", at(0.0, 0.0, h)), body);
    let rows = dice.count(2, 3);
    for i in 0..rows {
        let place = at(
            dice.between(-0.3, 0.3) * w,
            low.y + 0.004,
            split + (h - split) * (i as f64 + 0.5) / rows as f64,
        );
        let (r, high) = (dice.between(0.014, 0.025), dice.between(0.008, 0.016));
        let cap = lathe(&[(r, -0.01), (r, 0.8 * high), (0.85 * r, high)], place, DVec3::NEG_Y);
        let ring = lathe(&[(1.3 * r, 0.0), (1.2 * r, 0.3 * high)], place, DVec3::NEG_Y);
        sketch.draft.add_to_root(ring);
        let motion = slide(DVec3::Y, place, 0.6 * high);
        sketch.add(0, (format!("push button {}", i + 1), place - DVec3::Y * high), motion, cap);
    }
    let front =
        between(at(low.x + 0.016, low.y, 0.016), at(high.x - 0.016, low.y + 0.01, split - 0.016));
    let boxed = tray(
        at(low.x + 0.018, low.y + 0.01, 0.018),
        at(high.x - 0.018, high.y - 0.03, split - 0.05),
        0.005,
    );
    let lip = cuboid(at(0.0, low.y - 0.008, split - 0.03), at(0.5 * w, 0.016, 0.008));
    let motion = slide(DVec3::NEG_Y, at(0.0, low.y, split / 2.0), dice.between(0.5, 0.7) * d);
    let click = at(0.3 * w, low.y, 0.4 * split);
    sketch.add(0, ("coin drawer", click), motion, front.with(boxed).with(lip));
    sketch
}

/// Doors, drawers and lids that are not shut: their range leads back.
pub(super) fn shown_open(index: usize, dice: &mut Dice) -> Sketch {
    match index % 5 {
        0 => open_door(dice),
        1 => open_drawer(dice),
        2 => open_chest(dice),
        3 => open_oven(dice),
        _ => open_window(dice),
    }
}

fn open_door(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.4, 0.6), dice.between(0.3, 0.5), dice.between(0.6, 1.2));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let shelf = cuboid(at(0.0, 0.0, 0.5 * h), at(w - 0.036, d - 0.03, 0.018));
    let body = shell(low, high, 0.018).with(shelf);
    let mut sketch = Sketch::new("cupboard", ("cupboard body", at(0.0, 0.0, h)), body);
    let hung = if dice.chance(0.5) { 1.0 } else { -1.0 };
    let y = low.y - 0.002;
    let door = between(at(low.x, y - 0.018, 0.003), at(high.x, y, h - 0.003));
    let middle = at(-hung * (w / 2.0 - 0.045), y - 0.018, 0.5 * h);
    let grip = handle(middle, DVec3::Z, dice.between(0.1, 0.2), DVec3::NEG_Y);
    let most = dice.between(1.6, 2.1);
    let motion = hinge(DVec3::Z * hung, at(hung * w / 2.0, y, 0.0), 0.0, most);
    let click = at(0.0, y - 0.018, dice.between(0.3, 0.8) * h);
    let part = sketch.add(0, ("door", click), motion, door.with(grip));
    sketch.open.push((part, dice.between(0.3, 0.8) * most));
    sketch
}

fn open_drawer(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.4, 0.8), dice.between(0.38, 0.5), dice.between(0.5, 0.9));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let mut sketch = Sketch::new(
        "chest of drawers",
        ("carcass", at(low.x, 0.0, 0.5 * h)),
        shell(low, high, 0.018),
    );
    let rows = dice.count(2, 4);
    let pulled = dice.count(0, rows - 1);
    let room = (h - 0.036) / rows as f64;
    for i in 0..rows {
        let (from, to) =
            (h - 0.018 - room * (i as f64 + 1.0) + 0.003, h - 0.018 - room * i as f64 - 0.003);
        let x = w / 2.0 - 0.021;
        let front = between(at(-x, low.y, from), at(x, low.y + 0.018, to));
        let boxed = tray(
            at(-x + 0.01, low.y + 0.018, from + 0.008),
            at(x - 0.01, high.y - 0.04, to - 0.2 * room),
            0.01,
        );
        let middle = at(0.0, low.y, (from + to) / 2.0);
        let knob = lathe(
            &[(0.006, 0.0), (0.006, 0.014), (0.014, 0.02), (0.012, 0.028)],
            middle,
            DVec3::NEG_Y,
        );
        let most = dice.between(0.55, 0.75) * d;
        let motion = slide(DVec3::NEG_Y, middle, most);
        let click = middle + at(0.25 * w, 0.0, 0.0);
        let part =
            sketch.add(0, (called("drawer", i, rows), click), motion, front.with(boxed).with(knob));
        if i == pulled {
            sketch.open.push((part, dice.between(0.3, 0.9) * most));
        }
    }
    sketch
}

fn open_chest(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.6, 1.1), dice.between(0.35, 0.5), dice.between(0.35, 0.5));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let plinth = cuboid(at(0.0, low.y - 0.006, 0.03), at(w + 0.02, 0.012, 0.06));
    let mut sketch = Sketch::new(
        "blanket chest",
        ("chest box", at(0.0, low.y, 0.5 * h)),
        tray(low, high, 0.02).with(plinth),
    );
    let lid =
        between(at(low.x - 0.01, low.y - 0.015, h + 0.002), at(high.x + 0.01, high.y, h + 0.024));
    let clasp = cuboid(at(0.0, low.y - 0.019, h - 0.01), at(0.05, 0.006, 0.06));
    let most = dice.between(1.5, 1.9);
    let motion = hinge(DVec3::NEG_X, at(0.0, high.y, h + 0.002), 0.0, most);
    let click = at(0.2 * w, 0.0, h + 0.024);
    let part = sketch.add(0, ("lid", click), motion, lid.with(clasp));
    sketch.open.push((part, dice.between(0.92, 1.0) * most));
    sketch
}

fn open_oven(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.55, 0.62), dice.between(0.5, 0.6), dice.between(0.55, 0.65));
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let top = h - dice.between(0.09, 0.13);
    let panel = between(at(low.x, low.y - 0.02, top + 0.004), at(high.x, low.y, h));
    let rack = cuboid(at(0.0, 0.0, 0.4 * h), at(w - 0.08, d - 0.06, 0.012));
    let mut sketch = Sketch::new(
        "oven",
        ("oven body", at(0.0, low.y - 0.02, h - 0.04)),
        shell(low, high, 0.04).with(panel).with(rack),
    );
    let door =
        between(at(low.x + 0.004, low.y - 0.03, 0.03), at(high.x - 0.004, low.y - 0.002, top));
    let glass = cuboid(at(0.0, low.y - 0.033, 0.5 * top), at(0.7 * w, 0.006, 0.5 * top));
    let middle = at(0.0, low.y - 0.03, top - 0.04);
    let grip = handle(middle, DVec3::X, 0.7 * w, DVec3::NEG_Y);
    let motion = hinge(DVec3::X, at(0.0, low.y - 0.016, 0.03), 0.0, FRAC_PI_2);
    let click = at(0.38 * w, low.y - 0.002, 0.5 * top);
    let part = sketch.add(0, ("oven door", click), motion, door.with(glass).with(grip));
    sketch.open.push((part, dice.between(0.5, 1.0) * FRAC_PI_2));
    sketch
}

/// A casement that stands out from its frame.
fn open_window(dice: &mut Dice) -> Sketch {
    let (w, h) = (dice.between(0.5, 0.8), dice.between(0.7, 1.2));
    let frame = |[x, z]: [f64; 2], wide: f64, [y, deep]: [f64; 2]| {
        let bar = |a: f64, b: f64, c: f64, e: f64| between(at(a, y, c), at(b, y + deep, e));
        bar(-x, -x + wide, -z, z)
            .with(bar(x - wide, x, -z, z))
            .with(bar(-x + wide, x - wide, -z, -z + wide))
            .with(bar(-x + wide, x - wide, z - wide, z))
    };
    let sill = cuboid(at(0.0, -0.06, -h / 2.0 - 0.01), at(w + 0.1, 0.14, 0.02));
    let body = frame([w / 2.0, h / 2.0], 0.05, [0.0, 0.07]).with(sill);
    let mut sketch =
        Sketch::new("casement window", ("window frame", at(0.0, 0.0, h / 2.0 - 0.02)), body);
    let (x, z) = (w / 2.0 - 0.053, h / 2.0 - 0.053);
    let hung = if dice.chance(0.5) { 1.0 } else { -1.0 };
    let pane = cuboid(at(0.0, 0.02, 0.0), at(2.0 * x - 0.08, 0.006, 2.0 * z - 0.08));
    let lever = cuboid(at(-hung * (x - 0.022), 0.05, 0.0), at(0.02, 0.03, 0.12));
    let most = dice.between(1.2, 1.7);
    let motion = hinge(DVec3::Z * hung, at(hung * x, 0.0, 0.0), 0.0, most);
    let click = at(-hung * (x - 0.02), 0.0, 0.3 * h);
    let sash = frame([x, z], 0.042, [0.0, 0.04]).with(pane).with(lever);
    let part = sketch.add(0, ("casement sash", click), motion, sash);
    sketch.open.push((part, dice.between(0.3, 0.9) * most));
    sketch
}
