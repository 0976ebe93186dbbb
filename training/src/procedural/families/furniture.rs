//! Drawers, doors, tables and chairs.

use std::f64::consts::{FRAC_PI_2, TAU};

use object::DVec3;

use super::super::draft::{
    Dice, Draft, at, cuboid, handle, hinge, lathe, placed, rod, shell, slide, spin, tray, words,
};
use super::super::shapes::Shape;

/// A drawer between two corners of its front; it runs back `deep`.
fn drawer_shape(min: DVec3, max: DVec3, deep: f64, dice: &mut Dice) -> Shape {
    let (size, front) = (max - min, 0.018);
    let panel = cuboid((min + max) / 2.0 + DVec3::Y * front / 2.0, at(size.x, front, size.z));
    let low = at(min.x + 0.01, min.y + front, min.z + 0.01);
    let high = at(max.x - 0.01, min.y + deep, max.z - 0.25 * size.z);
    let middle = at((min.x + max.x) / 2.0, min.y, (min.z + max.z) / 2.0);
    let grip = if dice.chance(0.5) {
        handle(middle, DVec3::X, 0.4 * size.x, DVec3::NEG_Y)
    } else {
        lathe(&[(0.006, 0.0), (0.014, 0.02), (0.012, 0.028)], middle, DVec3::NEG_Y)
    };
    panel.with(tray(low, high, 0.01)).with(grip)
}

const DRAWER: [&str; 3] = ["drawer", "sliding drawer", "pull-out drawer"];
const DOOR: [&str; 3] = ["door", "hinged door", "cabinet door"];

/// How a row of several is called, from the top or the left.
fn rank(i: usize, count: usize, ends: [&'static str; 2]) -> &'static str {
    match i {
        0 => ends[0],
        _ if i + 1 == count => ends[1],
        1 if count == 3 => "middle",
        1 => "second",
        _ => ["third", "fourth", "fifth", "sixth"][(i - 2).min(3)],
    }
}

/// Cupboards wider than this have two drawers side by side, metres.
const TWO_DRAWERS: f64 = 0.75;

pub(super) fn drawer_unit(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.35, 0.8), dice.between(0.35, 0.55), dice.between(0.5, 1.2));
    let (rows, t) = (dice.count(2, 5), 0.02);
    let body = shell(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h), t);
    let names = words(&["chest of drawers", "drawer unit body", "cabinet body", "carcass"]);
    let mut draft = Draft::new(names, body);
    let high = (h - 2.0 * t) / rows as f64;
    for i in 0..rows {
        let top = h - t - high * i as f64;
        let min = at(-w / 2.0 + t + 0.003, -d / 2.0, top - high + 0.003);
        let max = at(w / 2.0 - t - 0.003, -d / 2.0, top - 0.003);
        let shape = drawer_shape(min, max, d - 0.06, dice);
        let place = rank(i, rows, ["top", "bottom"]);
        let motion = slide(DVec3::NEG_Y, min, dice.between(0.5, 0.8) * d);
        draft.add(0, placed(&[place], &DRAWER), vec![motion], shape);
    }
    draft
}

/// A door before a front, hung on its left or right side.
fn door(
    draft: &mut Draft,
    dice: &mut Dice,
    [min, max]: [DVec3; 2],
    left: bool,
    names: Vec<String>,
) {
    let (size, thick) = (max - min, 0.02);
    let panel = cuboid((min + max) / 2.0 - DVec3::Y * thick / 2.0, at(size.x, thick, size.z));
    let (edge, grip, axis) =
        if left { (min.x, max.x - 0.05, DVec3::NEG_Z) } else { (max.x, min.x + 0.05, DVec3::Z) };
    let middle = at(grip, min.y - thick, (min.z + max.z) / 2.0);
    let shape = panel.with(handle(middle, DVec3::Z, dice.between(0.1, 0.3) * size.z, DVec3::NEG_Y));
    let motion = hinge(axis, at(edge, min.y - thick, min.z), 0.0, dice.between(1.4, 2.2));
    draft.add(0, names, vec![motion], shape);
}

/// Drawers above, doors below; a wide one has two drawers side by side.
pub(super) fn cupboard(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.5, 1.0), dice.between(0.3, 0.6), dice.between(0.6, 1.2));
    let (t, split) = (0.02, h * dice.between(0.65, 0.85));
    let (is_wide, post, gap) = (w > TWO_DRAWERS, 0.5 * t, 0.003);
    let shelf = cuboid(at(0.0, 0.0, split), at(w - 2.0 * t, d - t, t));
    let mut body = shell(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h), t).with(shelf);
    if is_wide {
        let high = h - split - 1.5 * t;
        let middle = at(0.0, -t / 2.0, split + t / 2.0 + high / 2.0);
        body = body.with(cuboid(middle, at(2.0 * post, d - t, high)));
    }
    let mut draft = Draft::new(words(&["cupboard body", "cabinet body", "cabinet frame"]), body);
    let fronts = if is_wide {
        let (side, inner) = (w / 2.0 - t - gap, post + gap);
        vec![
            (placed(&["left"], &DRAWER), -side, -inner),
            (placed(&["right"], &DRAWER), inner, side),
        ]
    } else {
        vec![(words(&DRAWER), -w / 2.0 + t + gap, w / 2.0 - t - gap)]
    };
    for (names, from, to) in fronts {
        let (low, high) = (at(from, -d / 2.0, split + t), at(to, -d / 2.0, h - t - gap));
        let drawer = drawer_shape(low, high, d - 0.06, dice);
        draft.add(0, names, vec![slide(DVec3::NEG_Y, low, 0.6 * d)], drawer);
    }
    let corners = |a: f64, b: f64| [at(a, -d / 2.0, 0.01), at(b, -d / 2.0, split)];
    if dice.chance(0.6) {
        let (gap, half) = (0.002, w / 2.0);
        door(&mut draft, dice, corners(-half, -gap), true, placed(&["left"], &DOOR));
        door(&mut draft, dice, corners(gap, half), false, placed(&["right"], &DOOR));
    } else {
        let left = dice.chance(0.5);
        door(&mut draft, dice, corners(-w / 2.0, w / 2.0), left, words(&DOOR));
    }
    draft
}

pub(super) fn desk(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(1.0, 1.6), dice.between(0.5, 0.8), dice.between(0.68, 0.78));
    let (side, top) = (dice.between(0.25, 0.4), 0.03);
    let drawer_high = dice.between(0.1, 0.25);
    let board = cuboid(at(0.0, 0.0, h - top / 2.0), at(w, d, top));
    let leg = |x: f64, y: f64| cuboid(at(x, y, (h - top) / 2.0), at(0.05, 0.05, h - top));
    let legs = [-1.0, 1.0].into_iter().flat_map(|x| [-1.0, 1.0].map(|y| (x, y)));
    let body =
        legs.fold(board, |b, (x, y)| b.with(leg(x * (w / 2.0 - 0.03), y * (d / 2.0 - 0.03))));
    let mut draft = Draft::new(words(&["desk", "desk frame", "table", "desk body"]), body);
    for (place, x) in [("left", -1.0), ("right", 1.0)] {
        let centre = x * (w / 2.0 - 0.07 - side / 2.0);
        let min = at(centre - side / 2.0, -d / 2.0 + 0.01, h - top - drawer_high);
        let max = at(centre + side / 2.0, -d / 2.0 + 0.01, h - top - 0.003);
        let shape = drawer_shape(min, max, d - 0.1, dice);
        let motion = slide(DVec3::NEG_Y, min, dice.between(0.4, 0.7) * d);
        draft.add(0, placed(&[place], &DRAWER), vec![motion], shape);
    }
    draft
}

pub(super) fn wardrobe(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(1.0, 1.8), dice.between(0.5, 0.65), dice.between(1.7, 2.3));
    let body = shell(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h), 0.025);
    let mut draft = Draft::new(words(&["wardrobe", "wardrobe body", "closet frame"]), body);
    let sliding = dice.chance(0.5);
    for (place, x) in [("left", -1.0), ("right", 1.0)] {
        let corners = [
            at(if x < 0.0 { -w / 2.0 } else { 0.003 }, -d / 2.0, 0.02),
            at(if x < 0.0 { -0.003 } else { w / 2.0 }, -d / 2.0, h - 0.02),
        ];
        if !sliding {
            door(&mut draft, dice, corners, x < 0.0, placed(&[place], &["door", "wardrobe door"]));
            continue;
        }
        let depth = -d / 2.0 - if x < 0.0 { 0.015 } else { 0.04 };
        let middle = at((corners[0].x + corners[1].x) / 2.0, depth, h / 2.0);
        let panel = cuboid(middle, at(w / 2.0 + 0.03, 0.02, h - 0.04));
        let names = placed(&[place], &["sliding door", "wardrobe door", "door panel"]);
        draft.add(0, names, vec![slide(DVec3::X * -x, middle, w / 2.0 - 0.05)], panel);
    }
    draft
}

pub(super) fn folding_table(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.6, 0.9), dice.between(0.6, 0.9), dice.between(0.6, 0.78));
    let leaf = dice.between(0.25, 0.45);
    let board = cuboid(at(0.0, 0.0, h), at(w, d, 0.025));
    let leg = |x: f64, y: f64| {
        let top = at(x * (w / 2.0 - 0.05), y * (d / 2.0 - 0.05), h - 0.012);
        rod(top - DVec3::Z * (h - 0.012), top, 0.02)
    };
    let body =
        board.with(leg(-1.0, -1.0)).with(leg(1.0, -1.0)).with(leg(-1.0, 1.0)).with(leg(1.0, 1.0));
    let mut draft = Draft::new(words(&["table", "table top with legs", "fixed table top"]), body);
    for (place, x) in [("left", -1.0), ("right", 1.0)] {
        let edge = x * (w / 2.0 + 0.004);
        let shape = cuboid(at(edge + x * leaf / 2.0, 0.0, h), at(leaf, d, 0.025));
        let motion = hinge(DVec3::Y * x, at(edge, 0.0, h - 0.012), 0.0, FRAC_PI_2);
        draft.add(
            0,
            placed(&[place], &["leaf", "folding leaf", "table flap"]),
            vec![motion],
            shape,
        );
    }
    draft
}

pub(super) fn office_chair(dice: &mut Dice) -> Draft {
    let (feet, reach, seat) = (dice.count(4, 6), dice.between(0.25, 0.34), dice.between(0.4, 0.5));
    let hub = rod(at(0.0, 0.0, 0.06), at(0.0, 0.0, seat - 0.12), 0.03);
    let foot = |i: usize| {
        let turn = TAU * i as f64 / feet as f64;
        at(reach * turn.cos(), reach * turn.sin(), 0.08)
    };
    let body = (0..feet).fold(hub, |b, i| b.with(rod(at(0.0, 0.0, 0.1), foot(i), 0.018)));
    let mut draft = Draft::new(words(&["chair base", "five-star base", "base with column"]), body);
    let wide = dice.between(0.42, 0.52);
    let cushion = cuboid(at(0.0, 0.0, seat), at(wide, wide, 0.07));
    let column = rod(at(0.0, 0.0, seat - 0.12), at(0.0, 0.0, seat - 0.03), 0.018);
    let motions =
        vec![slide(DVec3::Z, at(0.0, 0.0, seat), 0.12), spin(DVec3::Z, at(0.0, 0.0, seat))];
    let chair =
        draft.add(0, words(&["seat", "swivel seat", "chair seat"]), motions, cushion.with(column));
    let tall = dice.between(0.4, 0.6);
    let back =
        cuboid(at(0.0, wide / 2.0 + 0.03, seat + 0.1 + tall / 2.0), at(wide * 0.9, 0.05, tall));
    let arm =
        rod(at(0.0, wide / 2.0 + 0.03, seat - 0.02), at(0.0, wide / 2.0 + 0.03, seat + 0.12), 0.02);
    let tilt = hinge(DVec3::NEG_X, at(0.0, wide / 2.0 + 0.03, seat), 0.0, dice.between(0.3, 0.6));
    draft.add(
        chair,
        words(&["backrest", "chair back", "reclining back"]),
        vec![tilt],
        back.with(arm),
    );
    for i in 0..feet {
        let p = foot(i);
        let tangent = DVec3::Z.cross(p).normalize();
        let rim = at(p.x, p.y, 0.03);
        let wheel = rod(rim - tangent * 0.015, rim + tangent * 0.015, 0.03);
        let names = vec![format!("caster wheel {}", i + 1), format!("wheel {}", i + 1)];
        draft.add(0, names, vec![spin(tangent, rim)], wheel);
    }
    draft
}
