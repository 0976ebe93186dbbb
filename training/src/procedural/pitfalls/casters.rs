//! Casters: a fork that swivels about the vertical, and a wheel in it that rolls.

use std::f64::consts::{PI, TAU};

use object::DVec3;

use super::super::draft::{Dice, at, cuboid, lathe, rod, shell, slide, spin, tray};
use super::super::shapes::Shape;
use super::sketch::{Sketch, between};

/// What carts, chairs and stools run on.
pub(super) fn swivel_taken_for_roll(index: usize, dice: &mut Dice) -> Sketch {
    match index % 5 {
        0 => cart(dice),
        1 => chair(dice),
        2 => trolley(dice),
        3 => stool(dice),
        _ => pedestal(dice),
    }
}

/// A caster as it is bought: radius of its wheel, width, how far its axle trails the swivel, metres.
#[derive(Clone, Copy)]
struct Caster {
    radius: f64,
    wide: f64,
    trail: f64,
}

impl Caster {
    fn drawn(dice: &mut Dice, [least, most]: [f64; 2]) -> Self {
        let radius = dice.between(least, most);
        Self {
            radius,
            wide: dice.between(0.4, 0.7) * radius,
            trail: dice.between(0.3, 0.6) * radius,
        }
    }

    /// How high the swivel's top lies above the floor.
    fn high(self) -> f64 {
        2.4 * self.radius
    }

    /// The way an axle points where the wheel trails that way, and the axle's middle under a place on the floor.
    fn axle(self, place: DVec3, heading: f64) -> [DVec3; 2] {
        let back = at(heading.cos(), heading.sin(), 0.0);
        [back.cross(DVec3::Z), at(place.x, place.y, self.radius) + back * self.trail]
    }

    /// Crown, bridge and cheeks.
    fn fork(self, place: DVec3, heading: f64) -> Shape {
        let top = at(place.x, place.y, self.high());
        let crown = lathe(
            &[(0.35 * self.radius, -0.16 * self.radius), (0.5 * self.radius, 0.0)],
            top,
            DVec3::Z,
        );
        let bridge = at(0.0, 0.0, self.high() - 0.22 * self.radius);
        let (half, thin) = (self.wide / 2.0 + 0.05 * self.radius, 0.08 * self.radius);
        let deep = 0.7 * self.radius;
        let cheek = |side: f64| {
            let x = side * (half + thin / 2.0);
            let upper = at(0.4 * self.trail, x, 1.72 * self.radius);
            let lower = at(0.8 * self.trail, x, 1.15 * self.radius);
            cuboid(upper, at(deep, thin, 0.9 * self.radius))
                .with(cuboid(lower, at(0.8 * deep, thin, 0.7 * self.radius)))
        };
        let across =
            cuboid(bridge + DVec3::X * 0.4 * self.trail, at(deep, 2.0 * half, 0.12 * self.radius));
        let turn = object::DPose3::from_translation(at(place.x, place.y, 0.0))
            * object::DPose3::rotation(DVec3::Z * heading);
        crown.with(across.with(cheek(1.0)).with(cheek(-1.0)).moved(turn))
    }

    fn wheel(self, place: DVec3, heading: f64) -> Shape {
        let [axis, middle] = self.axle(place, heading);
        let (r, half) = (self.radius, self.wide / 2.0);
        let tyre = [(0.85 * r, -half), (r, -0.6 * half), (r, 0.6 * half), (0.85 * r, half)];
        let pin = axis * (half + 0.1 * r);
        lathe(&tyre, middle, axis).with(rod(middle - pin, middle + pin, 0.12 * r))
    }

    /// Adds fork and wheel under a place, each a part.
    fn add(self, sketch: &mut Sketch, place: DVec3, heading: f64, name: &str) {
        let [axis, middle] = self.axle(place, heading);
        let pivot = at(place.x, place.y, self.high());
        let side =
            middle + axis * (self.wide / 2.0 + 0.13 * self.radius) + DVec3::Z * 0.7 * self.radius;
        let fork = self.fork(place, heading);
        let fork =
            sketch.add(0, (format!("{name} caster fork"), side), spin(DVec3::Z, pivot), fork);
        let tread = middle - DVec3::Z * 0.2 * self.radius + axis.cross(DVec3::Z) * self.radius;
        let wheel = self.wheel(place, heading);
        sketch.add(fork, (format!("{name} caster wheel"), tread), spin(axis, middle), wheel);
    }
}

const CORNERS: [(&str, f64, f64); 4] = [
    ("front left", -1.0, -1.0),
    ("front right", 1.0, -1.0),
    ("rear left", -1.0, 1.0),
    ("rear right", 1.0, 1.0),
];

/// A plate that a caster is screwed to.
fn plate(caster: Caster, place: DVec3, top: f64) -> Shape {
    let low = caster.high() + 0.02 * caster.radius;
    let wide = 1.1 * caster.radius;
    between(at(place.x - wide, place.y - wide, low), at(place.x + wide, place.y + wide, top))
}

/// A flat cart on four swivel casters, each turned its own way.
fn cart(dice: &mut Dice) -> Sketch {
    let (w, d) = (dice.between(0.45, 0.6), dice.between(0.7, 0.95));
    let caster = Caster::drawn(dice, [0.045, 0.07]);
    let low = caster.high() + 0.012;
    let place = |x: f64, y: f64| at(x * (w / 2.0 - 0.09), y * (d / 2.0 - 0.09), 0.0);
    let deck = between(at(-w / 2.0, -d / 2.0, low), at(w / 2.0, d / 2.0, low + 0.03));
    let post = |x: f64| rod(at(x, d / 2.0 - 0.03, low + 0.03), at(x, d / 2.0 - 0.03, 0.85), 0.014);
    let bar = rod(
        at(-w / 2.0 + 0.03, d / 2.0 - 0.03, 0.85),
        at(w / 2.0 - 0.03, d / 2.0 - 0.03, 0.85),
        0.014,
    );
    let body = deck.with(post(-w / 2.0 + 0.03)).with(post(w / 2.0 - 0.03)).with(bar);
    let body =
        CORNERS.iter().fold(body, |body, (_, x, y)| body.with(plate(caster, place(*x, *y), low)));
    let mut sketch = Sketch::new("platform cart", ("cart deck", at(0.0, 0.0, low + 0.03)), body);
    for (name, x, y) in CORNERS {
        let heading = dice.between(0.0, TAU);
        caster.add(&mut sketch, place(x, y), heading, name);
    }
    sketch
}

/// A chair's star on five casters.
fn chair(dice: &mut Dice) -> Sketch {
    let (reach, seat) = (dice.between(0.27, 0.33), dice.between(0.42, 0.5));
    let caster = Caster::drawn(dice, [0.024, 0.032]);
    let low = caster.high() + 0.01;
    let hub = rod(at(0.0, 0.0, low), at(0.0, 0.0, seat - 0.06), 0.03);
    let foot = |i: usize| {
        let turn = TAU * i as f64 / 5.0 + 0.3;
        at(reach * turn.cos(), reach * turn.sin(), 0.0)
    };
    let body = (0..5).fold(hub, |body, i| {
        let end = foot(i) + DVec3::Z * (low + 0.014);
        let socket = rod(foot(i) + DVec3::Z * (caster.high() + 0.001), end, 0.011);
        body.with(rod(at(0.0, 0.0, low + 0.03), end, 0.018)).with(socket)
    });
    let mut sketch =
        Sketch::new("office chair", ("star base with column", at(0.03, 0.0, 0.2)), body);
    let wide = dice.between(0.42, 0.5);
    let cushion = cuboid(at(0.0, 0.0, seat), at(wide, wide, 0.07));
    let back = cuboid(at(0.0, wide / 2.0 + 0.02, seat + 0.3), at(0.85 * wide, 0.05, 0.45));
    let stay = cuboid(at(0.0, wide / 2.0 - 0.02, seat + 0.04), at(0.08, 0.12, 0.03));
    let plate = cuboid(at(0.0, 0.0, seat - 0.045), at(0.2, 0.2, 0.02));
    let shape = cushion.with(back).with(stay).with(plate);
    sketch.add(
        0,
        ("swivel seat", at(0.0, -0.1, seat + 0.035)),
        spin(DVec3::Z, at(0.0, 0.0, seat)),
        shape,
    );
    for i in 0..5 {
        let heading = dice.between(0.0, TAU);
        caster.add(
            &mut sketch,
            foot(i),
            heading,
            ["first", "second", "third", "fourth", "fifth"][i],
        );
    }
    sketch
}

/// A serving trolley: casters in front, fixed wheels behind.
fn trolley(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.4, 0.5), dice.between(0.6, 0.8), dice.between(0.75, 0.9));
    let caster = Caster::drawn(dice, [0.04, 0.06]);
    let low = caster.high() + 0.012;
    let tub = |z: f64| tray(at(-w / 2.0, -d / 2.0, z), at(w / 2.0, d / 2.0, z + 0.06), 0.012);
    let body = CORNERS.iter().fold(tub(low).with(tub(h - 0.06)), |body, (_, x, y)| {
        let post = at(x * (w / 2.0 + 0.008), y * (d / 2.0 + 0.008), 0.0);
        body.with(rod(post + DVec3::Z * low, post + DVec3::Z * (h + 0.02), 0.012))
    });
    let place = |x: f64, y: f64| at(x * (w / 2.0 - 0.07), y * (d / 2.0 - 0.09), 0.0);
    let still = |x: f64| {
        // A fixed fork is of the trolley.
        caster.fork(place(x, 1.0), PI / 2.0).with(plate(caster, place(x, 1.0), low))
    };
    let body = [-1.0, 1.0]
        .into_iter()
        .fold(body, |body, x| body.with(plate(caster, place(x, -1.0), low)).with(still(x)));
    let mut sketch =
        Sketch::new("serving trolley", ("trolley frame", at(0.0, 0.0, h - 0.048)), body);
    for (name, x, y) in CORNERS {
        if y < 0.0 {
            let heading = dice.between(0.0, TAU);
            caster.add(&mut sketch, place(x, y), heading, name);
            continue;
        }
        let [axis, middle] = caster.axle(place(x, y), PI / 2.0);
        let tread = middle + axis.cross(DVec3::Z) * caster.radius;
        let wheel = caster.wheel(place(x, y), PI / 2.0);
        sketch.add(0, (format!("{name} wheel"), tread), spin(axis, middle), wheel);
    }
    sketch
}

/// A stool on four ball casters: each swivels, and what rolls in it is not asked for.
fn stool(dice: &mut Dice) -> Sketch {
    let (half, seat) = (dice.between(0.15, 0.2), dice.between(0.4, 0.55));
    let caster = Caster::drawn(dice, [0.025, 0.035]);
    let low = caster.high() + 0.004;
    let place = |x: f64, y: f64| at(x * half, y * half, 0.0);
    let top = lathe(
        &[(half + 0.04, 0.0), (half + 0.05, 0.02), (half + 0.03, 0.05)],
        at(0.0, 0.0, seat - 0.05),
        DVec3::Z,
    );
    let body = CORNERS.iter().fold(top, |body, (_, x, y)| {
        let foot = place(*x, *y) + DVec3::Z * low;
        body.with(rod(foot, at(0.5 * x * half, 0.5 * y * half, seat - 0.05), 0.014))
    });
    let mut sketch =
        Sketch::new("rolling stool", ("stool frame with seat", at(0.0, 0.0, seat)), body);
    for (name, x, y) in CORNERS {
        let heading = dice.between(0.0, TAU);
        let [axis, middle] = caster.axle(place(x, y), heading);
        let whole = caster.fork(place(x, y), heading).with(caster.wheel(place(x, y), heading));
        let click = middle + axis.cross(DVec3::Z) * caster.radius;
        let pivot = place(x, y) + DVec3::Z * caster.high();
        sketch.add(0, (format!("{name} swivel caster"), click), spin(DVec3::Z, pivot), whole);
    }
    sketch
}

/// A drawer pedestal on casters that stand under it.
fn pedestal(dice: &mut Dice) -> Sketch {
    let (w, d, h) = (dice.between(0.38, 0.45), dice.between(0.5, 0.58), dice.between(0.5, 0.62));
    let caster = Caster::drawn(dice, [0.022, 0.03]);
    let low = caster.high() + 0.006;
    let (a, b) = (at(-w / 2.0, -d / 2.0, low), at(w / 2.0, d / 2.0, h));
    let place = |x: f64, y: f64| at(x * (w / 2.0 - 0.06), y * (d / 2.0 - 0.06), 0.0);
    let body = CORNERS
        .iter()
        .fold(shell(a, b, 0.016), |body, (_, x, y)| body.with(plate(caster, place(*x, *y), low)));
    let mut sketch = Sketch::new("mobile pedestal", ("pedestal body", at(0.0, 0.0, h)), body);
    let front = between(at(a.x, a.y - 0.02, low + 0.004), at(b.x, a.y - 0.002, h - 0.004));
    let boxed =
        tray(at(a.x + 0.03, a.y - 0.002, low + 0.03), at(b.x - 0.03, b.y - 0.05, h - 0.15), 0.008);
    let lip = cuboid(at(0.0, a.y - 0.028, h - 0.02), at(0.5 * w, 0.016, 0.014));
    let motion = slide(DVec3::NEG_Y, at(0.0, a.y, h / 2.0), dice.between(0.5, 0.7) * d);
    let click = at(0.2 * w, a.y - 0.02, 0.5 * h);
    sketch.add(0, ("file drawer", click), motion, front.with(boxed).with(lip));
    for (name, x, y) in CORNERS {
        let heading = dice.between(0.0, TAU);
        caster.add(&mut sketch, place(x, y), heading, name);
    }
    sketch
}
