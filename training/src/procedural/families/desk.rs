//! What stands or lies on a desk.

use std::f64::consts::{FRAC_PI_2, TAU};

use object::{DPose3, DVec3};

use super::super::draft::{Dice, Draft, at, cuboid, hinge, lathe, rod, slide, spin, words};

pub(super) fn laptop(dice: &mut Dice) -> Draft {
    let (w, d) = (dice.between(0.28, 0.4), dice.between(0.2, 0.27));
    let keys = cuboid(at(0.0, 0.02, 0.0175), at(0.85 * w, 0.45 * d, 0.003));
    let pad = cuboid(at(0.0, -0.32 * d, 0.0165), at(0.3 * w, 0.22 * d, 0.001));
    let body = cuboid(at(0.0, 0.0, 0.008), at(w, d, 0.016)).with(keys).with(pad);
    let mut draft =
        Draft::new(words(&["laptop base", "keyboard base", "base with keyboard"]), body);
    let open = dice.between(0.0, 2.0);
    let hinge_line = at(0.0, d / 2.0, 0.018);
    let turn = DPose3::from_translation(hinge_line) * DPose3::rotation(DVec3::NEG_X * open);
    let screen = cuboid(at(0.0, -d / 2.0, 0.005), at(w, d, 0.008)).moved(turn);
    let motion = hinge(DVec3::NEG_X, hinge_line, -open, 2.3 - open);
    draft.add(0, words(&["screen", "laptop lid", "display", "lid"]), vec![motion], screen);
    draft
}

pub(super) fn lamp(dice: &mut Dice) -> Draft {
    let (lower, upper) = (dice.between(0.2, 0.4), dice.between(0.2, 0.4));
    let foot = lathe(&[(0.09, 0.0), (0.09, 0.015), (0.05, 0.025)], DVec3::ZERO, DVec3::Z);
    let post = rod(at(0.0, 0.0, 0.02), at(0.0, 0.0, 0.06), 0.012);
    let names = words(&["lamp base", "base", "weighted foot"]);
    let mut draft = Draft::new(names, foot.with(post));
    let (a, lean) = (at(0.0, 0.0, 0.06), dice.between(-0.4, 0.6));
    let b = a + at(0.0, lower * lean.sin(), lower * lean.cos());
    let names = words(&["lower arm", "first arm"]);
    let bottom = draft.add(0, names, vec![hinge(DVec3::X, a, -0.8, 0.8)], rod(a, b, 0.008));
    let bend = dice.between(0.8, 1.8);
    let c = b + at(0.0, -upper * bend.sin(), upper * bend.cos());
    let joint = rod(b - DVec3::X * 0.014, b + DVec3::X * 0.014, 0.012);
    let names = words(&["upper arm", "second arm"]);
    let motion = hinge(DVec3::X, b, -1.2, 1.2);
    let top = draft.add(bottom, names, vec![motion], rod(b, c, 0.007).with(joint));
    let shade = [(0.015, -0.02), (0.025, 0.02), (0.07, 0.1)];
    let tip = lathe(&shade, c, at(0.0, -0.4, -0.9).normalize());
    let motion = hinge(DVec3::X, c, -0.9, 0.9);
    draft.add(top, words(&["lamp head", "lamp shade", "shade"]), vec![motion], tip);
    draft
}

pub(super) fn scissors(dice: &mut Dice) -> Draft {
    let (long, grip, open) =
        (dice.between(0.06, 0.14), dice.between(0.05, 0.09), dice.between(0.05, 0.5));
    let half = |side: f64, z: f64| {
        let blade = cuboid(at(side * 0.004, long / 2.0, z), at(0.014, long, 0.002));
        let shank = rod(at(0.0, 0.0, z), at(-side * 0.02, -grip * 0.6, z), 0.004);
        let ring = (0..8).fold(blade.with(shank), |shape, k| {
            let point = |k: i32| {
                let turn = TAU * f64::from(k) / 8.0;
                at(-side * 0.026 + 0.018 * turn.cos(), -grip + 0.022 * turn.sin(), z)
            };
            shape.with(rod(point(k), point(k + 1), 0.004))
        });
        ring.moved(DPose3::rotation(DVec3::Z * (-side * open / 2.0)))
    };
    let screw = rod(at(0.0, 0.0, -0.004), at(0.0, 0.0, 0.004), 0.005);
    let names = words(&["fixed blade", "lower half", "scissor blade with pivot"]);
    let mut draft = Draft::new(names, half(-1.0, -0.0015).with(screw));
    let motion = hinge(DVec3::Z, DVec3::ZERO, -(0.9 - open).max(0.0), open);
    let names = words(&["moving blade", "upper half", "second blade"]);
    draft.add(0, names, vec![motion], half(1.0, 0.0015));
    draft
}

pub(super) fn stapler(dice: &mut Dice) -> Draft {
    let (long, wide) = (dice.between(0.12, 0.2), dice.between(0.025, 0.04));
    let base = cuboid(at(0.0, 0.0, 0.004), at(wide, long, 0.008));
    let post = cuboid(at(0.0, long / 2.0 - 0.012, 0.018), at(wide, 0.02, 0.02));
    let mut draft = Draft::new(words(&["stapler base", "base", "bottom plate"]), base.with(post));
    let (pivot, lift) = (at(0.0, long / 2.0 - 0.012, 0.024), dice.between(0.05, 0.3));
    let turn = DPose3::from_translation(pivot) * DPose3::rotation(DVec3::NEG_X * lift);
    let rail = cuboid(at(0.0, -long / 2.0 + 0.012, 0.004), at(0.7 * wide, long - 0.01, 0.01));
    let motion = hinge(DVec3::NEG_X, pivot, -lift, 1.4 - lift);
    let names = words(&["magazine", "staple tray", "staple rail"]);
    let rail = draft.add(0, names, vec![motion], rail.moved(turn));
    let turn = DPose3::from_translation(pivot) * DPose3::rotation(DVec3::NEG_X * (lift + 0.08));
    let cover = cuboid(at(0.0, -long / 2.0 + 0.01, 0.02), at(wide, long, 0.014)).moved(turn);
    let motion = hinge(DVec3::NEG_X, pivot, -0.08, 1.3);
    draft.add(rail, words(&["top cover", "stapler arm", "handle"]), vec![motion], cover);
    draft
}

pub(super) fn keypad(dice: &mut Dice) -> Draft {
    let (columns, rows, pitch) = (dice.count(2, 4), dice.count(2, 5), dice.between(0.014, 0.022));
    let size = at(pitch * (columns as f64 + 0.6), 0.02, pitch * (rows as f64 + 1.8));
    let body = cuboid(at(0.0, 0.01, 0.0), size);
    let screen =
        cuboid(at(0.0, -0.001, size.z / 2.0 - 0.6 * pitch), at(0.8 * size.x, 0.002, 0.8 * pitch));
    let names = words(&["keypad housing", "panel", "keypad body"]);
    let mut draft = Draft::new(names, body.with(screen));
    let round = dice.chance(0.4);
    for i in 0..rows * columns {
        let x = pitch * ((i % columns) as f64 - (columns as f64 - 1.0) / 2.0);
        let z = size.z / 2.0 - pitch * ((i / columns) as f64 + 1.8);
        let middle = at(x, -0.002, z);
        let key = if round {
            lathe(&[(0.4 * pitch, 0.0), (0.4 * pitch, 0.005)], at(x, 0.0, z), DVec3::NEG_Y)
        } else {
            cuboid(middle, at(0.8 * pitch, 0.006, 0.75 * pitch))
        };
        let names = vec![format!("button {}", i + 1), format!("key {}", i + 1)];
        draft.add(0, names, vec![slide(DVec3::Y, middle, 0.003)], key);
    }
    draft
}

pub(super) fn globe(dice: &mut Dice) -> Draft {
    let (r, tilt) = (dice.between(0.1, 0.18), dice.between(0.2, 0.45));
    let centre = at(0.0, 0.0, r + 0.08);
    let axis = at(tilt.sin(), 0.0, tilt.cos());
    let foot = lathe(
        &[(0.7 * r, 0.0), (0.7 * r, 0.012), (0.015, 0.03), (0.012, 0.06)],
        DVec3::ZERO,
        DVec3::Z,
    );
    let point = |k: usize| {
        let turn = -FRAC_PI_2 + std::f64::consts::PI * k as f64 / 10.0;
        let side = at(axis.z, 0.0, -axis.x);
        centre + (axis * turn.sin() + side * turn.cos()) * (r + 0.015)
    };
    let bow = (0..10).fold(foot, |shape, k| shape.with(rod(point(k), point(k + 1), 0.005)));
    let mut draft = Draft::new(words(&["globe stand", "stand with bow", "base"]), bow);
    let ring = |k: usize| {
        let turn = -FRAC_PI_2 + std::f64::consts::PI * (k as f64 + 0.5) / 16.0;
        (r * turn.cos(), r * turn.sin())
    };
    let ball = lathe(&(0..16).map(ring).collect::<Vec<_>>(), centre, axis);
    let pin = rod(centre - axis * (r + 0.02), centre + axis * (r + 0.02), 0.004);
    let names = words(&["globe ball", "sphere", "globe"]);
    draft.add(0, names, vec![spin(axis, centre)], ball.with(pin));
    draft
}
