//! Which part each piece belongs to: a small network asks every piece about every part, in rounds.
//!
//! The first round starts from what merging says; each later one from what the round before believed
//! of a piece, its neighbours and its copies. The weights are fitted by
//! `training/examples/fit_belonging.rs` on objects with known parts, none of them an evaluation case
//! (see `weights/README.md`).

mod layout;

use std::sync::LazyLock;

use rayon::prelude::*;

pub(super) use layout::Known;
pub use layout::{Beliefs, Layout, NUMBERS, Numbers};

/// How many networks are asked side by side, each in its own rounds: what they believe is averaged.
const VOICES: usize = 3;
/// How often the pieces are asked.
pub const ROUNDS: usize = 4;
/// Hidden units of a network.
const UNITS: usize = 32;
/// Numbers further from the mean than this many spreads count as this far.
const FAR: f32 = 8.0;

/// Where the weights of units begin.
pub const FIRST_UNIT: usize = NUMBERS;

/// Little-endian numbers of all rounds of every voice.
static FITTED: &[u8; 4 * Net::size(UNITS) * ROUNDS * VOICES] =
    include_bytes!("../../../weights/belonging.f32le");
static NETS: LazyLock<Vec<Net>> = LazyLock::new(|| {
    let (numbers, _) = FITTED.as_chunks::<4>();
    let numbers: Vec<f32> = numbers.iter().map(|b| f32::from_le_bytes(*b)).collect();
    numbers.chunks_exact(Net::size(UNITS)).filter_map(Net::new).collect()
});

/// The network of one round: mean and spread of each number, then its weights, those of the numbers
/// alone, of each unit (numbers, then one), and what units are worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Net {
    numbers: Vec<f32>,
    units: usize,
}

impl Net {
    /// How many numbers a network of so many units is made of.
    pub const fn size(units: usize) -> usize {
        3 * NUMBERS + units * (NUMBERS + 2)
    }

    /// A network of these numbers; `None` if their count is that of no network.
    pub fn new(numbers: &[f32]) -> Option<Self> {
        let units = numbers.len().checked_sub(3 * NUMBERS)? / (NUMBERS + 2);
        (numbers.len() == Self::size(units)).then(|| Self { numbers: numbers.to_vec(), units })
    }

    /// The numbers it is made of.
    pub fn as_slice(&self) -> &[f32] {
        &self.numbers
    }

    /// Its weights, without the scale of the numbers.
    pub fn weights(&self) -> &[f32] {
        &self.numbers[2 * NUMBERS..]
    }

    /// The same, to be changed.
    pub fn weights_mut(&mut self) -> &mut [f32] {
        &mut self.numbers[2 * NUMBERS..]
    }

    /// How many units it has.
    pub fn units(&self) -> usize {
        self.units
    }

    /// Where in its weights it stands what units are worth.
    pub fn worth(&self) -> usize {
        FIRST_UNIT + self.units * (NUMBERS + 1)
    }

    /// Brings numbers to mean 0 and spread 1.
    pub fn scale(&self, numbers: &mut Numbers) {
        let (mean, spread) = self.numbers[..2 * NUMBERS].split_at(NUMBERS);
        for ((n, mean), spread) in numbers.iter_mut().zip(mean).zip(spread) {
            *n = ((*n - mean) / spread).clamp(-FAR, FAR);
        }
    }

    /// Log-odds of scaled numbers, up to a constant for the piece; `bent` becomes what the units say.
    pub fn score(&self, scaled: &Numbers, bent: &mut [f32]) -> f32 {
        let weights = self.weights();
        let mut sum = dot(scaled, &weights[..NUMBERS]);
        let units = weights[FIRST_UNIT..self.worth()].chunks(NUMBERS + 1);
        for ((unit, worth), bent) in units.zip(&weights[self.worth()..]).zip(bent) {
            *bent = (dot(scaled, &unit[..NUMBERS]) + unit[NUMBERS]).tanh();
            sum += worth * *bent;
        }
        sum
    }

    /// What is believed of every piece after it was asked in the light of `beliefs`.
    pub fn answers(&self, layout: &Layout, beliefs: &Beliefs) -> Beliefs {
        let clusters = layout.clusters(beliefs);
        let mut known = layout.prompts();
        known.par_iter_mut().enumerate().for_each(|(piece, row)| {
            if layout.seed(piece).is_some() {
                return;
            }
            let mut bent = vec![0.0; self.units];
            let numbers = layout.numbers(piece, &clusters).into_iter().enumerate();
            let asked: Vec<(usize, Numbers)> = numbers.filter_map(|(p, n)| Some((p, n?))).collect();
            let score = |(_, numbers): &(usize, Numbers)| {
                let mut scaled = *numbers;
                self.scale(&mut scaled);
                self.score(&scaled, &mut bent)
            };
            let scores: Vec<f32> = asked.iter().map(score).collect();
            for ((part, _), chance) in asked.iter().zip(chances(&scores)) {
                row[*part] = chance;
            }
        });
        known
    }
}

/// Log-odds as chances that add up to 1.
pub fn chances(scores: &[f32]) -> Vec<f32> {
    let best = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let likely: Vec<f32> = scores.iter().map(|s| (s - best).exp()).collect();
    let all: f32 = likely.iter().sum();
    likely.into_iter().map(|l| l / all).collect()
}

/// What is believed of every piece after all rounds.
pub(super) fn believed(layout: &Layout) -> Beliefs {
    let rounds = |nets: &[Net]| {
        nets.iter().fold(layout.first(), |beliefs, net| net.answers(layout, &beliefs))
    };
    let mut voices = NETS.chunks(ROUNDS).map(rounds);
    let mut sum = voices.next().unwrap_or_else(|| layout.first());
    for beliefs in voices {
        for (sum, more) in sum.iter_mut().flatten().zip(beliefs.iter().flatten()) {
            *sum += more;
        }
    }
    sum.iter_mut().flatten().for_each(|chance| *chance /= VOICES as f32);
    sum
}

/// The fitted weights by what is in them, shortened.
pub fn digest() -> String {
    let hex = blake3::hash(FITTED).to_hex();
    hex.chars().take(12).collect()
}

/// Eight sums side by side, as the processor adds them.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let ((a8, a_rest), (b8, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0f32; 8];
    for (x, y) in a8.iter().zip(b8) {
        for ((sum, x), y) in sums.iter_mut().zip(x).zip(y) {
            *sum += x * y;
        }
    }
    sums.iter().sum::<f32>() + a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum::<f32>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights that count one number alone, unscaled.
    fn counts(number: usize, unit_worth: f32) -> Net {
        let mut numbers = vec![0.0; Net::size(3)];
        numbers[NUMBERS..2 * NUMBERS].fill(1.0);
        let mut net = Net::new(&numbers).unwrap();
        let worth = net.worth();
        let weights = net.weights_mut();
        (weights[number], weights[FIRST_UNIT + number], weights[worth]) = (2.0, 1.0, unit_worth);
        net
    }

    #[test]
    fn a_network_has_a_whole_number_of_units() {
        assert_eq!(Net::new(&vec![0.0; Net::size(5)]).map(|n| n.units()), Some(5));
        assert_eq!(Net::new(&vec![0.0; Net::size(5) + 1]), None);
        assert_eq!(Net::new(&[]), None);
    }

    #[test]
    fn a_score_is_the_sum_of_numbers_and_what_units_are_worth() {
        let mut numbers = [0.0; NUMBERS];
        numbers[3] = 0.5;
        let mut bent = [0.0; 3];
        let score = counts(3, 10.0).score(&numbers, &mut bent);
        assert_eq!(bent[0], 0.5f32.tanh());
        assert_eq!(score, 1.0 + 10.0 * 0.5f32.tanh());
        assert_eq!(counts(4, 10.0).score(&numbers, &mut bent), 0.0);
    }

    #[test]
    fn what_is_far_from_the_mean_counts_as_eight_spreads() {
        let mut numbers = [0.0; NUMBERS];
        (numbers[0], numbers[1]) = (1e30, -3.0);
        counts(0, 0.0).scale(&mut numbers);
        assert_eq!((numbers[0], numbers[1]), (8.0, -3.0));
    }

    #[test]
    fn chances_add_up_however_large_the_scores() {
        let chances = chances(&[1000.0, 1000.0, -1000.0]);
        assert_eq!(chances, [0.5, 0.5, 0.0]);
    }

    #[test]
    fn the_weights_that_ship_are_numbers() {
        assert_eq!(NETS.len(), ROUNDS * VOICES);
        assert!(NETS.iter().flat_map(Net::as_slice).all(|w| w.is_finite()));
        let spreads = NETS.iter().flat_map(|n| &n.as_slice()[NUMBERS..2 * NUMBERS]);
        assert!(spreads.into_iter().all(|s| *s > 0.0));
    }
}
