//! Bodies that are easily taken from the part they belong to: fronts, panels, linings.

use std::f64::consts::FRAC_PI_2;

use object::DVec3;

use super::super::draft::{Dice, at, cuboid, handle, hinge, lathe, shell, slide, tray};
use super::super::shapes::Shape;
use super::sketch::{Sketch, barrels, between};

/// How a chest with drawers is made.
struct Chest {
    category: &'static str,
    body: &'static str,
    /// Fewest and most drawers, one above the other.
    rows: [usize; 2],
    /// Fronts lie before the carcass, or between its boards.
    is_overlaid: bool,
    /// Legs and a top, so that the boxes are seen.
    is_open: bool,
    /// Clicked on the box and not on the grip.
    is_box_clicked: bool,
    has_knob: bool,
    /// Least and most width, depth and height, metres.
    size: [DVec3; 2],
}

const CHESTS: [Chest; 5] = [
    Chest {
        category: "chest of drawers",
        body: "carcass",
        rows: [3, 4],
        is_overlaid: true,
        is_open: false,
        is_box_clicked: false,
        has_knob: false,
        size: [DVec3::new(0.6, 0.4, 0.7), DVec3::new(0.9, 0.5, 1.0)],
    },
    Chest {
        category: "kitchen base unit",
        body: "cabinet body",
        rows: [2, 3],
        is_overlaid: false,
        is_open: false,
        is_box_clicked: false,
        has_knob: true,
        size: [DVec3::new(0.4, 0.5, 0.65), DVec3::new(0.6, 0.6, 0.8)],
    },
    Chest {
        category: "side table",
        body: "table frame",
        rows: [1, 1],
        is_overlaid: false,
        is_open: true,
        is_box_clicked: true,
        has_knob: true,
        size: [DVec3::new(0.45, 0.4, 0.45), DVec3::new(0.7, 0.5, 0.6)],
    },
    Chest {
        category: "desk pedestal",
        body: "pedestal body",
        rows: [2, 3],
        is_overlaid: true,
        is_open: false,
        is_box_clicked: false,
        has_knob: true,
        size: [DVec3::new(0.38, 0.5, 0.5), DVec3::new(0.45, 0.6, 0.6)],
    },
    Chest {
        category: "tool chest",
        body: "chest body",
        rows: [3, 5],
        is_overlaid: false,
        is_open: false,
        is_box_clicked: true,
        has_knob: false,
        size: [DVec3::new(0.5, 0.4, 0.4), DVec3::new(0.7, 0.5, 0.6)],
    },
];

/// How thick the boards of a carcass are, and the legs of a table, metres.
const BOARD: f64 = 0.018;
const LEG: f64 = 0.035;

/// Drawers whose fronts do not touch their boxes.
pub(super) fn front_left_behind(index: usize, dice: &mut Dice) -> Sketch {
    let chest = &CHESTS[index % CHESTS.len()];
    let [least, most] = chest.size;
    let size = at(
        dice.between(least.x, most.x),
        dice.between(least.y, most.y),
        dice.between(least.z, most.z),
    );
    let rows = dice.count(chest.rows[0], chest.rows[1]);
    let (low, high) =
        (at(-size.x / 2.0, -size.y / 2.0, 0.0), at(size.x / 2.0, size.y / 2.0, size.z));
    // What stands on both sides of the drawers.
    let wall = if chest.is_open { LEG } else { BOARD };
    let floor = if chest.is_open { size.z - dice.between(0.12, 0.16) } else { BOARD };
    let body = if chest.is_open { table([low, high], floor) } else { shell(low, high, BOARD) };
    let room = (size.z - BOARD - floor) / rows as f64;
    let rail = |i: usize, side: f64| {
        let middle = at(
            side * (size.x / 2.0 - wall - 0.006),
            0.01,
            size.z - BOARD - room * (i as f64 + 0.5),
        );
        cuboid(middle, at(0.01, 0.8 * size.y, 0.02))
    };
    let body = (0..rows).fold(body, |body, i| body.with(rail(i, -1.0)).with(rail(i, 1.0)));
    let click = at(low.x, 0.0, size.z - 0.5 * BOARD);
    let mut sketch = Sketch::new(chest.category, (chest.body, click), body);
    let (gap, thick, proud) =
        (dice.between(0.001, 0.004), dice.between(0.014, 0.022), dice.between(0.0005, 0.002));
    let reach = dice.between(0.5, 0.75) * size.y;
    for i in 0..rows {
        let top = size.z - BOARD - room * i as f64;
        let [front_low, front_high] = if chest.is_overlaid {
            let y = low.y - proud;
            [at(low.x, y - thick, top - room + 0.002), at(high.x, y, top - 0.001)]
        } else {
            let x = size.x / 2.0 - wall - 0.003;
            [at(-x, low.y, top - room + 0.003), at(x, low.y + thick, top - 0.003)]
        };
        let x = size.x / 2.0 - wall - 0.0125;
        let box_low = at(-x, front_high.y + gap, top - room + 0.012);
        let box_high = at(x, high.y - 0.03, top - 0.012 - 0.2 * room);
        let middle = at(0.0, front_low.y, top - 0.45 * room);
        let (grip, grasped) = if chest.has_knob {
            let profile = [(0.006, 0.0), (0.006, 0.012), (0.015, 0.02), (0.013, 0.028)];
            (lathe(&profile, middle, DVec3::NEG_Y), middle - DVec3::Y * 0.03)
        } else {
            let long = dice.between(0.2, 0.6) * size.x;
            (handle(middle, DVec3::X, long, DVec3::NEG_Y), middle - DVec3::Y * 0.05)
        };
        let side = at(box_high.x, 0.0, (box_low.z + box_high.z) / 2.0);
        let click = if chest.is_box_clicked { side } else { grasped };
        let shape = between(front_low, front_high).with(tray(box_low, box_high, 0.012)).with(grip);
        let motion = slide(DVec3::NEG_Y, front_low, reach);
        sketch.add(0, (called("drawer", i, rows), click), motion, shape);
    }
    sketch
}

/// How one of several things above each other is called.
pub(super) fn called(what: &str, i: usize, count: usize) -> String {
    match (i, count) {
        (_, 1) => what.to_owned(),
        (0, _) => format!("top {what}"),
        (i, _) if i + 1 == count => format!("bottom {what}"),
        (1, 3) => format!("middle {what}"),
        _ => format!("{what} {}", i + 1),
    }
}

/// A top on four legs with an apron on three sides.
fn table([low, high]: [DVec3; 2], apron: f64) -> Shape {
    let leg = LEG;
    let top = between(at(low.x, low.y, high.z - BOARD), high);
    let legs = [
        (low.x, low.y),
        (high.x - leg, low.y),
        (low.x, high.y - leg),
        (high.x - leg, high.y - leg),
    ];
    let body = legs.into_iter().fold(top, |body, (x, y)| {
        body.with(between(at(x, y, 0.0), at(x + leg, y + leg, high.z - BOARD)))
    });
    let (under, thin) = (high.z - BOARD, 0.015);
    body.with(between(at(low.x, low.y + leg, apron), at(low.x + thin, high.y - leg, under)))
        .with(between(at(high.x - thin, low.y + leg, apron), at(high.x, high.y - leg, under)))
        .with(between(at(low.x + leg, high.y - thin, apron), at(high.x - leg, high.y, under)))
}

/// Two stiles, two rails, a panel that is loose between them, and a lining behind, between two corners
/// across y.
fn leaf([min, max]: [DVec3; 2], [stile, gap]: [f64; 2], is_lined: bool) -> Shape {
    let (a, b) = (min, max);
    let (deep, y) = (b.y - a.y, (a.y + b.y) / 2.0);
    let panel = between(
        at(a.x + stile + gap, y - 0.2 * deep, a.z + stile + gap),
        at(b.x - stile - gap, y + 0.2 * deep, b.z - stile - gap),
    );
    let shape = between(a, at(a.x + stile, b.y, b.z))
        .with(between(at(b.x - stile, a.y, a.z), b))
        .with(between(at(a.x + stile, a.y, a.z), at(b.x - stile, b.y, a.z + stile)))
        .with(between(at(a.x + stile, a.y, b.z - stile), at(b.x - stile, b.y, b.z)))
        .with(panel);
    if !is_lined {
        return shape;
    }
    let inset = 0.5 * stile;
    let back = at(a.x + inset, b.y + gap, a.z + inset);
    shape.with(between(back, at(b.x - inset, b.y + gap + 0.006, b.z - inset)))
}

/// A carcass of boards that do not touch: sides, floor, top, a loose back and panels on its sides.
fn loose([low, high]: [DVec3; 2], gap: f64, has_cheeks: bool) -> Shape {
    let (a, b, t) = (low, high, BOARD);
    let body = between(a, at(a.x + t, b.y, b.z))
        .with(between(at(b.x - t, a.y, a.z), b))
        .with(between(at(a.x + t + gap, a.y, a.z), at(b.x - t - gap, b.y - t, a.z + t)))
        .with(between(at(a.x + t + gap, a.y, b.z - t), at(b.x - t - gap, b.y - t, b.z)))
        .with(between(
            at(a.x + t + gap, b.y - 0.008, a.z + gap),
            at(b.x - t - gap, b.y, b.z - gap),
        ));
    if !has_cheeks {
        return body;
    }
    let cheek = |x: f64, out: f64| {
        let (near, far) = (x + out * gap, x + out * (gap + 0.012));
        between(at(near.min(far), a.y, a.z), at(near.max(far), b.y, b.z))
    };
    body.with(cheek(a.x, -1.0)).with(cheek(b.x, 1.0))
}

/// Doors with panels and linings of their own, on carcasses with loose panels.
pub(super) fn panel_to_body(index: usize, dice: &mut Dice) -> Sketch {
    match index % 5 {
        0 => framed(dice, ("cupboard", "cupboard body"), 1, [true, true]),
        1 => framed(dice, ("wall cabinet", "cabinet body"), 2, [true, false]),
        2 => dishwasher(dice),
        3 => fridge(dice),
        _ => framed(dice, ("display cabinet", "cabinet body"), 2, [false, true]),
    }
}

/// One or two doors of frame and panel.
fn framed(
    dice: &mut Dice,
    (category, body): (&'static str, &str),
    doors: usize,
    [is_lined, has_cheeks]: [bool; 2],
) -> Sketch {
    let (w, d, h) = (
        dice.between(0.4, 0.55) * if doors == 2 { 1.7 } else { 1.0 },
        dice.between(0.3, 0.45),
        dice.between(0.6, 1.1),
    );
    let gap = dice.between(0.001, 0.003);
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let mut shape = loose([low, high], gap, has_cheeks);
    let shelf = at(0.0, 0.03, h * dice.between(0.4, 0.6));
    shape = shape.with(cuboid(shelf, at(w - 2.0 * BOARD - 2.0 * gap, d - 0.1, BOARD)));
    let mut sketch = Sketch::new(category, (body, at(0.0, high.y, 0.4 * h)), shape);
    let (thick, stile) = (dice.between(0.018, 0.024), dice.between(0.05, 0.08));
    let first = dice.chance(0.5);
    let wide = w / doors as f64;
    for i in 0..doors {
        let is_left = if doors == 1 { first } else { i == 0 };
        let x = low.x + wide * i as f64;
        let y = low.y - 0.012;
        let corners = [at(x + 0.001, y - thick, 0.002), at(x + wide - 0.001, y, h - 0.002)];
        let (edge, grip, axis) = if is_left {
            (corners[0].x, corners[1].x - stile / 2.0, DVec3::NEG_Z)
        } else {
            (corners[1].x, corners[0].x + stile / 2.0, DVec3::Z)
        };
        let middle = at(grip, corners[0].y, h * dice.between(0.4, 0.6));
        let leaf = leaf(corners, [stile, gap], is_lined).with(handle(
            middle,
            DVec3::Z,
            dice.between(0.1, 0.16),
            DVec3::NEG_Y,
        ));
        let name = match (doors, i) {
            (1, _) => "door",
            (_, 0) => "left door",
            _ => "right door",
        };
        let motion = hinge(axis, at(edge, y, 0.0), 0.0, dice.between(1.5, 2.0));
        sketch.add(0, (name, middle - DVec3::Y * 0.05), motion, leaf);
    }
    sketch
}

/// A door that drops, of a tub, and a panel of the kitchen's own before it.
fn dishwasher(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.45, 0.6), dice.between(0.5, 0.6), dice.between(0.8, 0.87));
    let gap = dice.between(0.001, 0.004);
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h));
    let foot = dice.between(0.08, 0.12);
    let body = loose([low, high], gap, true).with(between(
        at(low.x + BOARD + gap, low.y + 0.04, 0.02),
        at(high.x - BOARD - gap, low.y + 0.055, foot),
    ));
    let mut sketch = Sketch::new("dishwasher", ("dishwasher body", at(low.x, 0.0, 0.5 * h)), body);
    let inner = between(
        at(low.x + 0.003, low.y - 0.03, foot),
        at(high.x - 0.003, low.y - 0.002, h - 0.005),
    );
    let front = -0.03 - gap;
    let panel =
        between(at(low.x, low.y + front - 0.018, foot - 0.01), at(high.x, low.y + front, h - 0.1));
    let lining = between(
        at(low.x + 0.05, low.y + gap, foot + 0.05),
        at(high.x - 0.05, low.y + gap + 0.015, h - 0.06),
    );
    let controls = between(
        at(low.x + 0.003, low.y + front - 0.01, h - 0.095),
        at(high.x - 0.003, low.y + front, h - 0.005),
    );
    let middle = at(0.0, low.y + front - 0.018, h - 0.16);
    let grip = handle(middle, DVec3::X, 0.6 * w, DVec3::NEG_Y);
    let motion = hinge(DVec3::X, at(0.0, low.y - 0.01, foot), 0.0, FRAC_PI_2);
    let click = at(0.1 * w, low.y + front - 0.01, h - 0.05);
    let shape = inner.with(panel).with(lining).with(controls).with(grip);
    sketch.add(0, ("dishwasher door", click), motion, shape);
    sketch
}

/// Two doors, each an outer skin, a seal and a lining with bins.
fn fridge(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.55, 0.65), dice.between(0.5, 0.6), dice.between(1.5, 1.8));
    let gap = dice.between(0.001, 0.003);
    let (low, high) = (at(-w / 2.0, -d / 2.0, 0.03), at(w / 2.0, d / 2.0, h));
    let split = h * dice.between(0.6, 0.7);
    let shelf = cuboid(at(0.0, 0.0, split), at(w - 2.0 * BOARD - 2.0 * gap, d - 0.05, 0.04));
    let body = loose([low, high], gap, true).with(shelf);
    let mut sketch =
        Sketch::new("refrigerator", ("refrigerator body", at(low.x, 0.0, 0.5 * h)), body);
    let is_left = dice.chance(0.5);
    let out = if is_left { 1.0 } else { -1.0 };
    for (name, from, to) in [("upper door", split + 0.004, h), ("lower door", low.z, split - 0.004)]
    {
        let y = low.y - 0.012;
        let skin = between(at(low.x, y - 0.04, from), at(high.x, y, to));
        let seal = |a: DVec3, b: DVec3| between(a, b);
        let (x, near, far) = (w / 2.0 - 0.02, y + gap, low.y - gap);
        let seals = seal(at(-x, near, from + 0.02), at(-x + 0.015, far, to - 0.02))
            .with(seal(at(x - 0.015, near, from + 0.02), at(x, far, to - 0.02)));
        let lining =
            between(at(-x + 0.03, near, from + 0.04), at(x - 0.03, near + 0.03, to - 0.04));
        let bin = |z: f64| {
            let low = at(-x + 0.05, near + 0.03 + gap, z);
            tray(low, low + at(2.0 * x - 0.1, 0.08, 0.07), 0.004)
        };
        let middle = at(out * (w / 2.0 - 0.05), y - 0.04, (from + to) / 2.0);
        let grip = handle(middle, DVec3::Z, dice.between(0.2, 0.35), DVec3::NEG_Y);
        let shape = skin
            .with(seals)
            .with(lining)
            .with(bin(from + 0.08))
            .with(bin((from + to) / 2.0))
            .with(grip);
        let edge = at(-out * w / 2.0, y, from);
        let motion = hinge(DVec3::NEG_Z * out, edge, 0.0, dice.between(1.6, 2.1));
        sketch.add(0, (name, at(0.0, y - 0.04, (from + to) / 2.0)), motion, shape);
    }
    let corner = at(-out * w / 2.0, low.y - 0.02, h + 0.004);
    sketch.draft.add_to_root(barrels([corner, corner + DVec3::Z * 0.03], 1, 0.01));
    sketch
}
