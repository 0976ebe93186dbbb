//! How far a joint goes one way, by boosted trees.
//!
//! The trees score every amount of motion by what is free, what the part is and how it hangs on
//! its parent. Amounts are radians for a turn, lengths of the part along the axis for a slide. Which ways it
//! goes is asked of other trees ([`crate::classic::joints::ways`]), which stand in the same pack.

use std::f64::consts::{PI, TAU};

use crate::classic::joints::axis_model::{JOINTS, forest_section};
use crate::classic::joints::candidates::directions;
use crate::classic::joints::context::JointContext;
use crate::classic::joints::features::{NAMES, TOLD};
use crate::classic::joints::motion;
use crate::classic::joints::range::{Likely, is_pressed, usual};
use crate::classic::joints::sweep::Axis;
use crate::classic::joints::ways::{self, Way, likeliest_way, way_chances};
use crate::classic::learned::forest::{Forest, mean_chances};
use crate::classic::learned::pack::{Pack, PackError, place};
use crate::classic::learned::shipped::Shipped;
use crate::classic::lexicon::words::{ROLE_NAMES, ROLES, Role};

/// How many forests are asked side by side: what they say is averaged.
pub const FOLDS: usize = 3;
/// How many numbers the trees may ask about: those of the axis, of the amount, of the motion and of the role.
pub const INPUTS: usize = TOLD + AMOUNT_NAMES.len() + motion::COUNT + ROLES.len();
/// What the trees are told of an amount.
pub type Inputs = [f32; INPUTS];
/// What the numbers of the amount are called, in order.
const AMOUNT_NAMES: [&str; 8] = [
    "amount",
    "amount_length",
    "past_firm",
    "past_soft",
    "past_loose",
    "way",
    "usual",
    "past_usual",
];

/// What the numbers that the trees may ask about are called, in order: the range features.
pub fn names() -> Vec<String> {
    let all = NAMES.iter().take(TOLD).chain(&AMOUNT_NAMES).chain(&motion::NAMES);
    let all = all.chain(&ROLE_NAMES);
    all.map(ToString::to_string).collect()
}
/// How far slides are looked at, in lengths of the part: a little more than the largest amount.
const MOST_SLIDE: f64 = 3.7;
/// Less than this, in radians or lengths of the part, is nothing.
pub const NOTHING: f64 = 0.01;
/// Where [`crate::classic::joints::features::NAMES`] says whether the object is a fused mesh.
const FUSED: usize = place(&NAMES, "skin");
/// Amounts this close are one, a share of half a unit and the amount.
const CLOSE: f64 = 0.02;
/// An amount that is off by so much is worth a third of the right one; radians or lengths of the part. Tuned
/// on validation, where 0.05 to 0.8 were tried: boxes around moved points agree best at 0.4 and beyond.
const OFF: f64 = 0.4;
/// How far from the amount that is worth most a half or whole turn is looked for, radians; a guess.
const NEAR: f64 = 0.2;
/// What goes both ways goes as far back as ahead where what is said of either way is so much alike, 0 to 1.
const ALIKE: f64 = 0.5;

static SHIPPED: Shipped<Learned> =
    Shipped::new("ranges", include_bytes!("../../../weights/ranges.pack"), Learned::read);

/// What packs of ranges are called inside.
pub const KIND: &str = "ranges";
/// The table of [`names`].
pub const TABLE: &str = "amount";

/// The forests of slides and of turns, fold by fold: of amounts, and of ways.
#[derive(Debug, Default)]
pub struct Learned {
    amounts: [Vec<Forest<INPUTS>>; 2],
    ways: [Vec<Forest<{ ways::INPUTS }>>; 2],
}

impl Learned {
    /// What a pack of ranges says; its ensembles are those of the amounts of slides and of turns, then of
    /// their ways.
    ///
    /// # Errors
    /// [`PackError`] when it is none for this program.
    pub fn read(pack: &Pack<'_>) -> Result<Self, PackError> {
        pack.is(KIND)?;
        pack.asks(TABLE, &names())?;
        pack.asks(ways::TABLE, &ways::names())?;
        Ok(Self {
            amounts: [folds(pack, 0, JOINTS[0])?, folds(pack, 1, JOINTS[1])?],
            ways: [folds(pack, 2, ways::JOINTS[0])?, folds(pack, 3, ways::JOINTS[1])?],
        })
    }
}

/// The forests of an ensemble.
fn folds<const N: usize>(
    pack: &Pack<'_>,
    place: usize,
    name: &str,
) -> Result<Vec<Forest<N>>, PackError> {
    let folds = 0..pack.ensemble(place)?.folds;
    folds.map(|f| pack.forest(&forest_section(name, f))).collect()
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

/// What the trees are told of a joint.
pub struct Asked {
    /// Of the ways it may go, in the order of [`ways::WAYS`].
    pub ways: [ways::Inputs; 3],
    /// Of every amount, along the axis and against it.
    pub amounts: [Vec<Inputs>; 2],
}

/// What the trees find likely.
pub(crate) struct Said {
    /// Each way, in the order of [`ways::WAYS`].
    pub ways: [f64; 3],
    /// Each amount, along the axis and against it.
    pub amounts: [Vec<f32>; 2],
}

impl JointContext<'_> {
    /// How far the part goes along the axis, which points the way it opens, and how far against it, as
    /// the trees find likeliest: radians, or scene units. What is pressed goes one way alone. Beside it how
    /// likely they find that.
    pub fn reaches(&self, axis: &Axis, role: Role) -> ([f64; 2], Likely) {
        let mut said = self.range_said(axis, role);
        if is_pressed(axis, role) {
            said.ways[2] = 0.0;
        }
        let reaches = likeliest(axis.turns, &said.amounts, &said.ways);
        (reaches.map(|reach| reach * self.length(axis)), likely(&said))
    }

    /// How likely each way and each amount is.
    pub(crate) fn range_said(&self, axis: &Axis, role: Role) -> Said {
        let (learned, turns) = (SHIPPED.get(), usize::from(axis.turns));
        let asked = self.asked(axis, role);
        Said {
            ways: way_chances(&learned.ways[turns], &asked.ways),
            amounts: asked.amounts.map(|rows| mean_chances(&learned.amounts[turns], &rows)),
        }
    }

    /// What the trees are told of a joint about an axis.
    pub fn asked(&self, axis: &Axis, role: Role) -> Asked {
        let directions = directions(&self.sources());
        let mut features = self.features(axis, &directions, self.mirror(axis.direction));
        // What comes as a fused mesh moves as far as what does not.
        features[FUSED] = 0.0;
        let unit = self.length(axis);
        let amounts = amounts(axis.turns);
        let motions = self.motions(axis, if axis.turns { TAU } else { MOST_SLIDE });
        let usual = usual(role, axis.turns);
        let rows = [0, 1].map(|way| {
            let free = motions.free[way];
            let (sign, usual) = if way == 0 { (1.0, usual.open) } else { (-1.0, usual.close) };
            let row = |&a: &f64| {
                let own =
                    [a, a * unit, a - free[0], a - free[1], a - free[2], sign, usual, a - usual];
                let mut row = [0.0; INPUTS];
                let all = features.iter().take(TOLD).chain(&own).chain(&motions.told[way]);
                row.iter_mut().zip(all).for_each(|(to, from)| *to = *from as f32);
                let role = ROLES.iter().position(|&r| r == role).unwrap_or(0);
                row[TOLD + own.len() + motion::COUNT + role] = 1.0;
                row
            };
            amounts.iter().map(row).collect()
        });
        Asked { ways: ways::rows(&features, &motions.told, role), amounts: rows }
    }
}

/// How far a joint goes both ways, by the chances of all [`amounts`] each way, the first of which is
/// nothing, and of the ways it goes. First it is chosen which ways it goes, then how far; where it may well go
/// as far back as ahead, it does.
pub fn likeliest(turns: bool, chances: &[Vec<f32>; 2], ways: &[f64; 3]) -> [f64; 2] {
    let [ahead, back] = chances.each_ref().map(|c| moving(c));
    let both: Vec<f64> = ahead.iter().zip(&back).map(|(a, b)| (a * b).sqrt()).collect();
    match likeliest_way(ways) {
        Way::Both if both.iter().sum::<f64>() > ALIKE => [best(turns, &both); 2],
        Way::Both => [best(turns, &ahead), best(turns, &back)],
        Way::Ahead => [best(turns, &ahead), 0.0],
        Way::Back => [0.0, best(turns, &back)],
    }
}

/// How likely what is taken is: the way, and the amount that way.
fn likely(said: &Said) -> Likely {
    let (way, next) = said.ways.iter().fold((0.0, 0.0), |(best, next), &chance| {
        if chance > best { (chance, best) } else { (best, f64::max(next, chance)) }
    });
    let back = usize::from(likeliest_way(&said.ways) == Way::Back);
    let amount = moving(&said.amounts[back]).into_iter().fold(0.0, f64::max);
    Likely { way, next, both: said.ways[2], amount }
}

/// The chances of all amounts of what moves.
fn moving(chances: &[f32]) -> Vec<f64> {
    let rest = chances.iter().skip(1).map(|&c| f64::from(c));
    let all = rest.clone().sum::<f64>().max(f64::MIN_POSITIVE);
    std::iter::once(0.0).chain(rest.map(|c| c / all)).collect()
}

/// The amount, other than nothing, that is worth most: the right one is worth 1, and the farther off, the
/// less. A half or whole turn near it is taken instead where nothing near is likelier: what goes that far
/// goes exactly so far.
fn best(turns: bool, chances: &[f64]) -> f64 {
    let amounts = amounts(turns);
    let worth = |a: f64| {
        let near = amounts.iter().zip(chances).map(|(b, c)| (-(a - b).abs() / OFF).exp() * c);
        near.sum::<f64>()
    };
    let most = |all: &mut dyn Iterator<Item = (f64, f64)>| {
        all.reduce(|best, next| if next.0 > best.0 { next } else { best }).map_or(0.0, |b| b.1)
    };
    let best = most(&mut amounts.iter().skip(1).map(|&a| (worth(a), a)));
    let near = amounts.iter().zip(chances).skip(1).filter(|(a, _)| (*a - best).abs() <= NEAR);
    let likeliest = most(&mut near.map(|(&a, &chance)| (chance, a)));
    if turns && (likeliest == PI || likeliest == TAU) { likeliest } else { best }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pack_that_ships_is_whole() {
        SHIPPED.check().unwrap();
        for forests in &SHIPPED.get().amounts {
            assert_eq!(forests.len(), FOLDS);
            assert!(forests.iter().all(|f| !f.trees.is_empty()));
        }
        for forests in &SHIPPED.get().ways {
            assert!(forests.len() == FOLDS && forests.iter().all(|f| !f.trees.is_empty()));
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

    const AHEAD: [f64; 3] = [0.5, 0.2, 0.3];
    const BACK: [f64; 3] = [0.2, 0.5, 0.3];
    const BOTH: [f64; 3] = [0.2, 0.2, 0.6];

    #[test]
    fn what_moves_goes_the_likeliest_way_as_far_as_is_worth_most() {
        let spread = chances(&[(0.5, 0.12), (1.0, 0.08), (1.05, 0.12), (1.1, 0.08)]);
        let rests = chances(&[(0.5, 0.3)]);
        assert_eq!(likeliest(true, &[spread.clone(), rests.clone()], &AHEAD), [1.05, 0.0]);
        assert_eq!(likeliest(true, &[rests, spread], &BACK), [0.0, 1.05]);
    }

    #[test]
    fn what_goes_both_ways_goes_as_far_back_as_ahead_if_it_may() {
        let ahead = chances(&[(0.5, 0.5), (1.35, 0.4)]);
        let back = chances(&[(0.5, 0.3), (1.35, 0.4), (1.75, 0.2)]);
        assert_eq!(likeliest(true, &[ahead.clone(), back], &BOTH), [1.35, 1.35]);
        let else_where = chances(&[(1.75, 0.9)]);
        assert_eq!(likeliest(true, &[ahead, else_where], &BOTH), [0.5, 1.75]);
    }

    #[test]
    fn half_a_turn_is_not_a_little_less() {
        let round = chances(&[(2.85, 0.12), (2.9, 0.14), (2.95, 0.16), (PI, 0.3)]);
        assert_eq!(likeliest(true, &[round.clone(), round], &BOTH), [PI, PI]);
    }
}
