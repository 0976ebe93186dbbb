//! How far a joint goes one way: boosted trees ask every amount about what is free, what the part is and
//! how it hangs.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use object::DVec3;

use super::candidates::directions;
use super::features::COUNT;
use super::forest::{Forest, forests, mean_chances};
use super::range::usual;
use super::setting::Setting;
use super::sweep::{Axis, Sweep};
use super::words::{ROLES, Role};

/// How many forests are asked side by side: what they say is averaged.
pub const VOICES: usize = 3;
/// How many numbers the trees may ask about: those of the axis, the role, and 19 of the amount.
pub const NUMBERS: usize = COUNT + ROLES.len() + 19;
/// What the trees are told of an amount.
pub type Numbers = [f32; NUMBERS];
/// Step of the sweep that is looked at, share of the diagonal.
const STEP: f64 = 0.006;
/// Shares of probes that may be stopped: nearly none, a tenth, a third.
const SHARES: [f64; 3] = [0.02, 0.1, 0.33];
/// Where [`super::features::NAMES`] says whether the object is a skin.
const SKIN: usize = 68;
/// Amounts lie this close: the kernel over which chances are gathered, as a share of 1 + amount.
const CLOSE: f64 = 0.05;

/// The forests of slides and of turns, voice by voice.
static GROWN: [&[u8]; 2] = [
    include_bytes!("../../weights/slides_reach.trees"),
    include_bytes!("../../weights/turns_reach.trees"),
];
static FORESTS: LazyLock<[Vec<Forest<NUMBERS>>; 2]> = LazyLock::new(|| GROWN.map(forests));

/// Every amount that is asked about: radians, or lengths of the part along the axis.
pub fn amounts(turns: bool) -> Vec<f64> {
    if turns {
        let steps = (0..60).map(|k| 0.05 * f64::from(k));
        steps.chain([PI, 3.6, 4.2, 5.0, TAU]).collect()
    } else {
        (0..48).map(|k| 0.01 * (1.07_f64.powi(k) - 1.0) / 0.07).collect()
    }
}

/// How near two amounts are, 1 the same, 0 far apart.
pub fn likeness(a: f64, b: f64) -> f64 {
    let off = (a - b) / (CLOSE * (0.5 + a.max(b)));
    (-0.5 * off * off).exp()
}

/// The trees by what is in them, shortened.
pub fn digest() -> String {
    let mut hasher = blake3::Hasher::new();
    for grown in GROWN {
        hasher.update(grown);
    }
    hasher.finalize().to_hex().chars().take(12).collect()
}

impl Setting<'_> {
    /// How far the part goes along the axis and how far against it, as the trees find likeliest:
    /// radians, or scene units.
    pub fn reaches(&self, axis: &Axis, role: Role) -> [f64; 2] {
        let amounts = amounts(axis.turns);
        self.asked(axis, role).map(|rows| {
            let chances = mean_chances(&FORESTS[usize::from(axis.turns)], &rows);
            likeliest(&amounts, &chances) * self.length(axis)
        })
    }

    /// What the trees are told of every amount, along the axis and against it.
    pub fn asked(&self, axis: &Axis, role: Role) -> [Vec<Numbers>; 2] {
        let directions = directions(&self.sources());
        let mut features = self.features(axis, &directions, self.mirror(axis.direction));
        // What comes as a skin moves as far as what does not.
        features[SKIN] = 0.0;
        let unit = self.length(axis);
        let amounts = amounts(axis.turns);
        let most = amounts.last().copied().unwrap_or(0.0);
        let sweep = Sweep { scene: self.scene, probes: &self.few, still: &self.still, step: STEP };
        let free =
            [*axis, axis.reversed()].map(|a| sweep.free(&a, most * unit, SHARES).map(|f| f / unit));
        let usual = usual(role, axis.turns);
        let eye = self.comes_to_the_eye(axis).map_or(0.0, |comes| if comes { 1.0 } else { -1.0 });
        let shut = f64::from(u8::from(self.is_shut(axis)));
        let lever = self.probes.iter().map(|p| axis.radius(p.start)).fold(0.0, f64::max);
        let leaves = self.leaves(axis);
        let (low, high) = self.parent.extent(axis.direction);
        [0, 1].map(|way| {
            let (ahead, back) = (free[way], free[1 - way]);
            let sign = if way == 0 { 1.0 } else { -1.0 };
            let usual = if way == 0 { usual.open } else { usual.close };
            let row = |&a: &f64| {
                let own = [
                    a,
                    a * unit,
                    ahead[0],
                    ahead[1],
                    ahead[2],
                    a - ahead[0],
                    a - ahead[1],
                    a - ahead[2],
                    back[0],
                    back[1],
                    back[2],
                    sign,
                    shut,
                    sign * eye,
                    sign * leaves,
                    usual,
                    a - usual,
                    lever,
                    (high - low) / unit,
                ];
                let mut row = [0.0; NUMBERS];
                let all = features.iter().chain(&own);
                row.iter_mut().zip(all).for_each(|(to, from)| *to = *from as f32);
                let role = ROLES.iter().position(|&r| r == role).unwrap_or(0);
                row[COUNT + own.len() + role] = 1.0;
                row
            };
            amounts.iter().map(row).collect()
        })
    }

    /// How straight the part sets off away from its parent, −1 to 1.
    fn leaves(&self, axis: &Axis) -> f64 {
        let away = self.body.centroid - self.parent.bounds.centre();
        let unit = |v: DVec3| v.normalize_or_zero();
        unit(axis.velocity(self.body.centroid)).dot(unit(away))
    }
}

/// The amount with most chances about it.
pub fn likeliest(amounts: &[f64], chances: &[f32]) -> f64 {
    let about = |a: f64| {
        let near = amounts.iter().zip(chances).map(|(b, c)| likeness(a, *b) * f64::from(*c));
        near.sum::<f64>()
    };
    let all = amounts.iter().map(|&a| (about(a), a));
    all.reduce(|best, next| if next.0 > best.0 { next } else { best }).map_or(0.0, |b| b.1)
}

#[cfg(test)]
mod tests {
    use super::super::features::NAMES;
    use super::*;

    #[test]
    fn the_forests_that_ship_are_whole() {
        for (grown, forests) in GROWN.iter().zip(&*FORESTS) {
            assert_eq!(forests.len(), VOICES);
            let mut bytes = Vec::new();
            forests.iter().for_each(|f| f.write(&mut bytes));
            assert_eq!(bytes, *grown);
        }
    }

    #[test]
    fn the_number_that_is_kept_from_the_trees_is_that_of_skins() {
        assert_eq!(NAMES[SKIN], "skin");
    }

    #[test]
    fn amounts_rise_from_nothing() {
        for turns in [false, true] {
            let amounts = amounts(turns);
            assert_eq!(amounts[0], 0.0);
            assert!(amounts.windows(2).all(|pair| pair[0] < pair[1]), "{amounts:?}");
        }
    }

    #[test]
    fn many_near_chances_are_likelier_than_one_alone() {
        let amounts = [0.0, 0.5, 1.0, 1.05, 1.1];
        assert_eq!(likeliest(&amounts, &[0.4, 0.0, 0.2, 0.2, 0.2]), 1.05);
        assert_eq!(likeliest(&amounts, &[0.7, 0.0, 0.1, 0.1, 0.1]), 0.0);
    }
}
