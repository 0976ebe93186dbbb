//! Machines of the kitchen: boxes with doors, racks, knobs and buttons.

use std::f64::consts::{FRAC_PI_2, TAU};

use object::{DPose3, DVec3};

use super::super::draft::{
    Dice, Draft, at, cuboid, handle, hinge, lathe, placed, rod, shell, slide, spin, tray, words,
};
use super::super::shapes::Shape;
use super::workshop::Slotted;

/// A knob on a front.
fn knob(middle: DVec3, radius: f64) -> Shape {
    let profile = [(radius, 0.0), (radius, 0.012), (0.8 * radius, 0.02)];
    let mark =
        cuboid(middle + at(0.0, -0.021, 0.5 * radius), at(0.2 * radius, 0.004, 0.7 * radius));
    lathe(&profile, middle, DVec3::NEG_Y).with(mark)
}

/// A front panel that hangs on an edge: `left` and `right` edges turn about z, `bottom` about x.
fn front(
    draft: &mut Draft,
    names: &[&str],
    [min, max]: [DVec3; 2],
    edge: &str,
    reach: f64,
) -> usize {
    let (size, thick) = (max - min, 0.03);
    let middle = (min + max) / 2.0;
    let panel = cuboid(middle - DVec3::Y * thick / 2.0, at(size.x, thick, size.z));
    let face = min.y - thick;
    let (axis, pivot, grip) = match edge {
        "left" => (DVec3::NEG_Z, at(min.x, face, min.z), at(max.x - 0.04, face, middle.z)),
        "right" => (DVec3::Z, at(max.x, face, min.z), at(min.x + 0.04, face, middle.z)),
        _ => (DVec3::X, at(min.x, min.y, min.z), at(middle.x, face, max.z - 0.04)),
    };
    let along = if edge == "bottom" { DVec3::X } else { DVec3::Z };
    let shape = panel.with(handle(grip, along, 0.6 * size.dot(along), DVec3::NEG_Y));
    draft.add(0, words(names), vec![hinge(axis, pivot, 0.0, reach)], shape)
}

pub(super) fn microwave(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.42, 0.58), dice.between(0.3, 0.42), dice.between(0.24, 0.34));
    let split = w * dice.between(0.18, 0.26);
    let panel = cuboid(at(w / 2.0 - split / 2.0, -d / 2.0 + 0.15, h / 2.0), at(split, 0.3, h));
    let body = shell(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h), 0.02).with(panel);
    let mut draft = Draft::new(words(&["microwave body", "microwave", "oven body"]), body);
    let corners = [at(-w / 2.0, -d / 2.0, 0.005), at(w / 2.0 - split - 0.003, -d / 2.0, h - 0.005)];
    front(
        &mut draft,
        &["door", "microwave door", "glass door"],
        corners,
        "left",
        dice.between(1.5, 2.0),
    );
    let plate =
        lathe(&[(0.03, 0.0), (0.13, 0.008), (0.14, 0.014)], at(-split / 2.0, 0.0, 0.025), DVec3::Z);
    let names = words(&["turntable", "glass plate", "rotating plate"]);
    draft.add(0, names, vec![spin(DVec3::Z, at(-split / 2.0, 0.0, 0.025))], plate);
    let x = w / 2.0 - split / 2.0;
    if dice.chance(0.5) {
        let middle = at(x, -d / 2.0, 0.6 * h);
        let names = words(&["timer knob", "dial", "control knob"]);
        draft.add(0, names, vec![spin(DVec3::NEG_Y, middle)], knob(middle, 0.3 * split));
    }
    let middle = at(x, -d / 2.0 - 0.004, 0.18 * h);
    let names = words(&["door button", "open button", "release button"]);
    let button = cuboid(middle, at(0.6 * split, 0.012, 0.12 * h));
    draft.add(0, names, vec![slide(DVec3::Y, middle, 0.005)], button);
    draft
}

pub(super) fn oven(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.5, 0.75), dice.between(0.5, 0.65), dice.between(0.55, 0.9));
    let panel_high = dice.between(0.1, 0.16);
    let board = cuboid(at(0.0, -d / 2.0 + 0.02, h - panel_high / 2.0), at(w, 0.04, panel_high));
    let body = shell(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h), 0.03).with(board);
    let mut draft = Draft::new(words(&["oven body", "oven", "oven housing"]), body);
    let corners = [at(-w / 2.0, -d / 2.0, 0.02), at(w / 2.0, -d / 2.0, h - panel_high - 0.004)];
    front(&mut draft, &["oven door", "door", "drop-down door"], corners, "bottom", FRAC_PI_2);
    for i in 0..dice.count(1, 2) {
        let z = 0.2 * h + 0.2 * h * i as f64;
        let rack = (0..8).map(|k| {
            let x = (-0.42 + 0.12 * f64::from(k)) * w;
            rod(at(x, -0.4 * d, z), at(x, 0.42 * d, z), 0.004)
        });
        let cross =
            [-0.4, 0.42].map(|y| rod(at(-0.46 * w, y * d, z), at(0.46 * w, y * d, z), 0.005));
        let rack = rack.chain(cross).fold(Shape::default(), Shape::with);
        let names = placed(&[["lower", "upper"][i]], &["rack", "oven rack", "shelf"]);
        draft.add(0, names, vec![slide(DVec3::NEG_Y, at(0.0, 0.0, z), 0.5 * d)], rack);
    }
    let knobs = dice.count(2, 5);
    for i in 0..knobs {
        let x = w * ((i as f64 + 0.5) / knobs as f64 - 0.5) * 0.8;
        let middle = at(x, -d / 2.0, h - panel_high / 2.0);
        let names = vec![format!("knob {}", i + 1), format!("oven knob {}", i + 1)];
        let motion = hinge(DVec3::NEG_Y, middle, 0.0, dice.between(2.0, 4.8).min(3.1));
        draft.add(0, names, vec![motion], knob(middle, 0.02));
    }
    draft
}

pub(super) fn fridge(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.5, 0.9), dice.between(0.5, 0.7), dice.between(1.3, 2.0));
    let body = shell(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h), 0.04);
    let mut draft = Draft::new(words(&["fridge body", "refrigerator body", "fridge"]), body);
    let reach = dice.between(1.5, 2.2);
    let corners = |x: [f64; 2], z: [f64; 2]| [at(x[0], -d / 2.0, z[0]), at(x[1], -d / 2.0, z[1])];
    if dice.chance(0.4) {
        let names = ["left door", "left refrigerator door"];
        front(&mut draft, &names, corners([-w / 2.0, -0.003], [0.02, h]), "left", reach);
        let names = ["right door", "right refrigerator door"];
        front(&mut draft, &names, corners([0.003, w / 2.0], [0.02, h]), "right", reach);
    } else {
        let (split, edge) =
            (h * dice.between(0.25, 0.7), if dice.chance(0.5) { "left" } else { "right" });
        let names = ["lower door", "bottom door", "lower refrigerator door"];
        let wide = [-w / 2.0, w / 2.0];
        front(&mut draft, &names, corners(wide, [0.02, split - 0.004]), edge, reach);
        let names = ["upper door", "top door", "upper refrigerator door"];
        front(&mut draft, &names, corners(wide, [split + 0.004, h]), edge, reach);
    }
    let (low, high) =
        (at(-w / 2.0 + 0.06, -d / 2.0 + 0.03, 0.06), at(w / 2.0 - 0.06, d / 2.0 - 0.06, 0.25));
    let names = words(&["crisper drawer", "vegetable drawer", "drawer inside"]);
    draft.add(0, names, vec![slide(DVec3::NEG_Y, low, 0.6 * d)], tray(low, high, 0.008));
    draft
}

pub(super) fn dishwasher(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.44, 0.6), dice.between(0.5, 0.6), dice.between(0.7, 0.88));
    let body = shell(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h), 0.03);
    let mut draft = Draft::new(words(&["dishwasher body", "dishwasher", "dishwasher tub"]), body);
    let corners = [at(-w / 2.0, -d / 2.0, 0.06), at(w / 2.0, -d / 2.0, h)];
    let names = ["dishwasher door", "door", "front door"];
    front(&mut draft, &names, corners, "bottom", dice.between(1.3, FRAC_PI_2));
    for (place, z) in [("lower", 0.1), ("upper", 0.45)] {
        let low = at(-w / 2.0 + 0.04, -d / 2.0 + 0.02, z * h);
        let high = at(w / 2.0 - 0.04, d / 2.0 - 0.05, (z + 0.22) * h);
        let names = placed(&[place], &["rack", "basket", "dish rack"]);
        draft.add(0, names, vec![slide(DVec3::NEG_Y, low, 0.7 * d)], tray(low, high, 0.006));
    }
    let middle = at(0.0, 0.0, 0.06 * h);
    let arm = cuboid(middle, at(0.8 * w, 0.04, 0.015));
    let names = words(&["spray arm", "rotating spray arm"]);
    draft.add(0, names, vec![spin(DVec3::Z, middle)], arm);
    draft
}

pub(super) fn washing_machine(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.55, 0.65), dice.between(0.45, 0.62), dice.between(0.8, 0.9));
    let body = shell(at(-w / 2.0, -d / 2.0, 0.0), at(w / 2.0, d / 2.0, h), 0.02);
    let panel = cuboid(at(0.0, -d / 2.0 + 0.01, h - 0.07), at(w - 0.04, 0.02, 0.14));
    let foot = cuboid(at(0.0, -d / 2.0 + 0.01, 0.06), at(w - 0.04, 0.02, 0.1));
    let names = words(&["washing machine body", "washer housing", "washing machine"]);
    let mut draft = Draft::new(names, body.with(panel).with(foot));
    let (r, z) = (dice.between(0.16, 0.2), 0.45 * h);
    let centre = at(0.0, -d / 2.0, z);
    let ring = [(r, 0.0), (r + 0.02, 0.02), (r, 0.045), (0.6 * r, 0.05)];
    let left = dice.chance(0.5);
    let side = if left { -1.0 } else { 1.0 };
    let motion = hinge(
        DVec3::Z * side,
        at(side * (r + 0.02), -d / 2.0 - 0.02, z),
        0.0,
        dice.between(1.5, 2.6),
    );
    let names = words(&["porthole door", "round door", "door", "washing machine door"]);
    draft.add(0, names, vec![motion], lathe(&ring, centre, DVec3::NEG_Y));
    let drum =
        lathe(&[(0.9 * r, 0.0), (r, 0.02), (r, 0.3)], at(0.0, d / 2.0 - 0.06, z), DVec3::NEG_Y);
    draft.add(0, words(&["drum", "wash drum"]), vec![spin(DVec3::NEG_Y, at(0.0, 0.0, z))], drum);
    let middle = at(0.1, -d / 2.0, h - 0.07);
    let names = words(&["program dial", "selector knob", "dial"]);
    draft.add(0, names, vec![spin(DVec3::NEG_Y, middle)], knob(middle, 0.03));
    let (low, high) = (at(-w / 2.0 + 0.03, -d / 2.0 - 0.01, h - 0.12), at(-0.08, 0.1, h - 0.03));
    let names = words(&["detergent drawer", "soap drawer", "dispenser drawer"]);
    draft.add(0, names, vec![slide(DVec3::NEG_Y, low, 0.15)], tray(low, high, 0.008));
    draft
}

pub(super) fn stove(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.5, 0.9), dice.between(0.45, 0.6), dice.between(0.08, 0.2));
    let mut body = cuboid(at(0.0, 0.0, h / 2.0), at(w, d, h));
    for (x, y) in [(-0.25, -0.22), (0.25, -0.22), (-0.25, 0.22), (0.25, 0.22)] {
        let ring = [(0.05, 0.0), (0.08, 0.006), (0.06, 0.014)];
        body = body.with(lathe(&ring, at(x * w, y * d, h), DVec3::Z));
    }
    let mut draft = Draft::new(words(&["stove", "cooktop", "hob body"]), body);
    let knobs = dice.count(3, 6);
    for i in 0..knobs {
        let x = w * ((i as f64 + 0.5) / knobs as f64 - 0.5) * 0.9;
        let middle = at(x, -d / 2.0, 0.5 * h);
        let names = vec![format!("burner knob {}", i + 1), format!("stove knob {}", i + 1)];
        draft.add(0, names, vec![spin(DVec3::NEG_Y, middle)], knob(middle, 0.35 * h.min(0.08)));
    }
    draft
}

pub(super) fn toaster(dice: &mut Dice) -> Draft {
    let (w, d, h) = (dice.between(0.25, 0.34), dice.between(0.14, 0.2), dice.between(0.16, 0.22));
    let wall = |y: f64| cuboid(at(0.0, y * d * 0.38, h / 2.0), at(w, 0.24 * d, h));
    let size = at(0.52 * d, 0.02, h);
    // Through its end or before it goes the lever.
    let (slotted, upper) = (dice.chance(0.5), dice.between(0.75, 0.85) * h);
    let slot = if slotted {
        let (hole, off) = ([0.014, 0.62 * h], [0.0, upper - 0.77 * h]);
        let plate = Slotted { middle: at(0.0, 0.01 - w / 2.0, h / 2.0), size, hole, off };
        plate.shape().moved(DPose3::rotation(DVec3::Z * FRAC_PI_2))
    } else {
        cuboid(at(w / 2.0 - 0.01, 0.0, h / 2.0), at(0.02, 0.52 * d, h))
    };
    let end = cuboid(at(0.01 - w / 2.0, 0.0, h / 2.0), at(0.02, 0.52 * d, h));
    let foot = cuboid(at(0.0, 0.0, 0.01), at(w - 0.04, 0.52 * d, 0.02));
    let body = wall(-1.0).with(wall(1.0)).with(end).with(slot).with(foot);
    let mut draft = Draft::new(words(&["toaster body", "toaster", "housing"]), body);
    let side = w / 2.0;
    let middle = at(side + 0.02, 0.0, upper);
    let mut lever = cuboid(middle, at(0.04, 0.03, 0.015));
    if slotted {
        lever = lever.with(rod(middle, middle - DVec3::X * dice.between(0.03, 0.06), 0.005));
    }
    let names = words(&["lever", "toaster lever", "push-down lever"]);
    draft.add(0, names, vec![slide(DVec3::NEG_Z, middle, 0.45 * h)], lever);
    let centre = at(side, -0.3 * d, 0.3 * h);
    let dial = lathe(&[(0.014, 0.0), (0.012, 0.015)], centre, DVec3::X);
    let names = words(&["browning dial", "knob", "timer knob"]);
    draft.add(0, names, vec![hinge(DVec3::X, centre, -TAU / 3.0, TAU / 3.0)], dial);
    let low = at(-w / 2.0 + 0.03, -0.24 * d, 0.022);
    let high = at(w / 2.0 - 0.03, 0.24 * d, 0.035);
    let names = words(&["crumb tray", "tray"]);
    draft.add(0, names, vec![slide(DVec3::NEG_X, low, 0.8 * w)], tray(low, high, 0.003));
    draft
}
