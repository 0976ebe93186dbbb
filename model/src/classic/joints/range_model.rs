//! How far a joint goes one way, by boosted trees.
//!
//! The trees score every amount of motion by what is free, what the part is and how it hangs on
//! its parent. Amounts are radians for a turn, lengths of the part along the axis for a slide.

use std::f64::consts::{PI, TAU};

use object::DVec3;

use crate::classic::joints::axis_model::{JOINTS, forest_section};
use crate::classic::joints::candidates::directions;
use crate::classic::joints::context::JointContext;
use crate::classic::joints::features::NAMES;
use crate::classic::joints::range::{is_pressed, usual};
use crate::classic::joints::sweep::{Axis, Sweep};
use crate::classic::learned::forest::{Forest, mean_chances};
use crate::classic::learned::pack::{Pack, PackError, place};
use crate::classic::learned::shipped::Shipped;
use crate::classic::lexicon::words::{ROLE_NAMES, ROLES, Role};

/// How many forests are asked side by side: what they say is averaged.
pub const FOLDS: usize = 3;
/// How many of [`crate::classic::joints::features::NAMES`], from the first on, the trees ask about: those before this one.
const TOLD: usize = place(&NAMES, "pin_own");
/// How many numbers the trees may ask about: those of the axis, the role, and 19 of the amount.
pub const INPUTS: usize = TOLD + ROLES.len() + 19;
/// What the trees are told of an amount.
pub type Inputs = [f32; INPUTS];
/// What the numbers of the amount are called, in order.
const AMOUNT_NAMES: [&str; 19] = [
    "amount",
    "amount_length",
    "free_firm",
    "free_soft",
    "free_loose",
    "past_firm",
    "past_soft",
    "past_loose",
    "back_firm",
    "back_soft",
    "back_loose",
    "way",
    "shut",
    "to_the_eye",
    "leaves",
    "usual",
    "past_usual",
    "lever",
    "parent_length",
];

/// What the numbers that the trees may ask about are called, in order: the range features.
pub fn names() -> Vec<String> {
    let all = NAMES.iter().take(TOLD).chain(&AMOUNT_NAMES).chain(&ROLE_NAMES);
    all.map(ToString::to_string).collect()
}
/// Step of the sweep that is looked at, share of the diagonal.
const STEP: f64 = 0.006;
/// Shares of probes that may be stopped: nearly none, a tenth, a third.
const SHARES: [f64; 3] = [0.02, 0.1, 0.33];
/// Less than this, in radians or lengths of the part, is nothing.
pub const NOTHING: f64 = 0.01;
/// Where [`crate::classic::joints::features::NAMES`] says whether the object is a fused mesh.
const FUSED: usize = place(&NAMES, "skin");
/// Amounts this close are one, a share of half a unit and the amount.
const CLOSE: f64 = 0.02;
/// An amount that is off by so much is worth a third of the right one.
const OFF: f64 = 0.1;
/// What goes both ways goes as far back as ahead where what is said of either way is so much alike, 0 to 1.
const ALIKE: f64 = 0.5;

static SHIPPED: Shipped<Learned> =
    Shipped::new("ranges", include_bytes!("../../../weights/ranges.pack"), Learned::read);

/// What packs of ranges are called inside.
pub const KIND: &str = "ranges";
/// The table of [`names`].
pub const TABLE: &str = "amount";

/// The forests of slides and of turns, fold by fold.
#[derive(Debug, Default)]
pub struct Learned([Vec<Forest<INPUTS>>; 2]);

impl Learned {
    /// What a pack of ranges says; its first ensemble is that of slides, its second that of turns.
    ///
    /// # Errors
    /// [`PackError`] when it is none for this program.
    pub fn read(pack: &Pack<'_>) -> Result<Self, PackError> {
        pack.is(KIND)?;
        pack.asks(TABLE, &names())?;
        let one = |place: usize| {
            let folds = 0..pack.ensemble(place)?.folds;
            folds.map(|f| pack.forest(&forest_section(JOINTS[place], f))).collect::<Result<_, _>>()
        };
        Ok(Self([one(0)?, one(1)?]))
    }
}

/// Refuses a pack that this program cannot read.
///
/// # Errors
/// [`PackError`].
pub(crate) fn check() -> Result<(), PackError> {
    SHIPPED.check()
}

/// The name and the digest of the pack.
pub(crate) fn digest_of_pack() -> (&'static str, String) {
    SHIPPED.digest()
}

/// Every amount that is asked about: radians, or lengths of the part along the axis.
pub fn amounts(turns: bool) -> Vec<f64> {
    if turns {
        let steps = (0..60).map(|k| 0.05 * f64::from(k));
        steps.chain([PI, 3.6, 4.2, 5.0, TAU]).collect()
    } else {
        (0..48).map(|k| 0.015 * (1.06_f64.powi(k) - 1.0) / 0.06).collect()
    }
}

/// How near two amounts are, 1 the same, 0 far apart; not to move at all is near nothing else.
pub fn likeness(a: f64, b: f64) -> f64 {
    if (a == 0.0) != (b == 0.0) {
        return 0.0;
    }
    let off = (a - b) / (CLOSE * (0.5 + a.max(b)));
    (-0.5 * off * off).exp()
}

impl JointContext<'_> {
    /// How far the part goes along the axis, which points the way it opens, and how far against it, as
    /// the trees find likeliest: radians, or scene units. What is pressed goes one way alone.
    pub fn reaches(&self, axis: &Axis, role: Role) -> [f64; 2] {
        let chances = self.range_chances(axis, role);
        let reaches = if is_pressed(axis, role) {
            [best(axis.turns, &moving(&chances[0])), 0.0]
        } else {
            likeliest(axis.turns, &chances)
        };
        reaches.map(|reach| reach * self.length(axis))
    }

    /// How likely each amount is, along the axis and against it.
    pub(crate) fn range_chances(&self, axis: &Axis, role: Role) -> [Vec<f32>; 2] {
        let forests = &SHIPPED.get().0[usize::from(axis.turns)];
        self.asked(axis, role).map(|rows| mean_chances(forests, &rows))
    }

    /// What the trees are told of every amount, along the axis and against it.
    pub fn asked(&self, axis: &Axis, role: Role) -> [Vec<Inputs>; 2] {
        let directions = directions(&self.sources());
        let mut features = self.features(axis, &directions, self.mirror(axis.direction));
        // What comes as a fused mesh moves as far as what does not.
        features[FUSED] = 0.0;
        let unit = self.length(axis);
        let amounts = amounts(axis.turns);
        let most = amounts.last().copied().unwrap_or(0.0);
        let sweep =
            Sweep { scene: self.scene, probes: &self.probes, still: &self.still, step: STEP };
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
                let mut row = [0.0; INPUTS];
                let all = features.iter().take(TOLD).chain(&own);
                row.iter_mut().zip(all).for_each(|(to, from)| *to = *from as f32);
                let role = ROLES.iter().position(|&r| r == role).unwrap_or(0);
                row[TOLD + own.len() + role] = 1.0;
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

/// How far a joint goes both ways, by the chances of all [`amounts`] each way, the first of which is
/// nothing. What moves goes one way at least: first it is chosen which ways it goes, then how far; where it
/// may well go as far back as ahead, it does.
pub fn likeliest(turns: bool, chances: &[Vec<f32>; 2]) -> [f64; 2] {
    let rests = [0, 1].map(|way| chances[way].first().copied().unwrap_or(1.0));
    let [ahead, back] = rests.map(|rests| 1.0 - rests);
    let ways = [
        ([true, false], ahead * rests[1]),
        ([false, true], rests[0] * back),
        ([true, true], ahead * back),
    ];
    let likelier = ways.into_iter().reduce(|a, b| if b.1 > a.1 { b } else { a });
    let goes = likelier.map_or([true; 2], |likelier| likelier.0);
    let [ahead, back] = chances.each_ref().map(|c| moving(c));
    let both: Vec<f64> = ahead.iter().zip(&back).map(|(a, b)| (a * b).sqrt()).collect();
    if goes == [true; 2] && both.iter().sum::<f64>() > ALIKE {
        return [best(turns, &both); 2];
    }
    let far = [ahead, back].map(|chances| best(turns, &chances));
    [0, 1].map(|way| if goes[way] { far[way] } else { 0.0 })
}

/// The chances of all amounts of what moves.
fn moving(chances: &[f32]) -> Vec<f64> {
    let rest = chances.iter().skip(1).map(|&c| f64::from(c));
    let all = rest.clone().sum::<f64>().max(f64::MIN_POSITIVE);
    std::iter::once(0.0).chain(rest.map(|c| c / all)).collect()
}

/// The amount, other than nothing, that is worth most: the right one is worth 1, and the farther off, the
/// less.
fn best(turns: bool, chances: &[f64]) -> f64 {
    let amounts = amounts(turns);
    let worth = |a: f64| {
        let near = amounts.iter().zip(chances).map(|(b, c)| (-(a - b).abs() / OFF).exp() * c);
        near.sum::<f64>()
    };
    let all = amounts.iter().skip(1).map(|&a| (worth(a), a));
    all.reduce(|best, next| if next.0 > best.0 { next } else { best }).map_or(0.0, |b| b.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pack_that_ships_is_whole() {
        SHIPPED.check().unwrap();
        for forests in &SHIPPED.get().0 {
            assert_eq!(forests.len(), FOLDS);
            assert!(forests.iter().all(|f| !f.trees.is_empty()));
        }
    }

    #[test]
    fn the_number_that_is_kept_from_the_trees_is_that_of_skins() {
        assert_eq!(NAMES[FUSED], "skin");
    }

    #[test]
    fn amounts_rise_from_nothing() {
        for turns in [false, true] {
            let amounts = amounts(turns);
            assert_eq!(amounts[0], 0.0);
            assert!(amounts.windows(2).all(|pair| pair[0] < pair[1]), "{amounts:?}");
        }
    }

    /// Chances of amounts of turns, whatever is left being that of nothing.
    fn chances(said: &[(f64, f32)]) -> Vec<f32> {
        let amounts = amounts(true);
        let mut all = vec![0.0; amounts.len()];
        all[0] = 1.0 - said.iter().map(|s| s.1).sum::<f32>();
        for (amount, chance) in said {
            let place = amounts.iter().position(|a| (a - amount).abs() < 1e-9).unwrap();
            all[place] = *chance;
        }
        all
    }

    #[test]
    fn what_moves_goes_one_way_at_least_and_as_far_as_is_worth_most() {
        let spread = chances(&[(0.5, 0.12), (1.0, 0.08), (1.05, 0.12), (1.1, 0.08)]);
        let rests = chances(&[(0.5, 0.3)]);
        assert_eq!(likeliest(true, &[spread.clone(), rests.clone()]), [1.05, 0.0]);
        assert_eq!(likeliest(true, &[rests, spread]), [0.0, 1.05]);
    }

    #[test]
    fn what_goes_both_ways_goes_as_far_back_as_ahead_if_it_may() {
        let ahead = chances(&[(0.5, 0.5), (1.35, 0.4)]);
        let back = chances(&[(0.5, 0.3), (1.35, 0.4), (1.75, 0.2)]);
        assert_eq!(likeliest(true, &[ahead.clone(), back]), [1.35, 1.35]);
        let else_where = chances(&[(1.75, 0.9)]);
        assert_eq!(likeliest(true, &[ahead, else_where]), [0.5, 1.75]);
    }

    #[test]
    fn half_a_turn_is_not_a_little_less() {
        let round = chances(&[(2.85, 0.12), (2.9, 0.14), (2.95, 0.16), (PI, 0.3)]);
        assert_eq!(likeliest(true, &[round.clone(), round]), [PI, PI]);
    }
}
