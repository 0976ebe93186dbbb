//! Which part each piece belongs to: boosted trees ask every piece about every part, in rounds.
//!
//! The first round starts from what merging says; each later one from what the round before believed
//! of a piece, its neighbours and its copies. Skins and other objects have trees of their own. Both
//! are grown by `training/examples/fit_belonging` on objects with known parts, none of them an
//! evaluation case (see `weights/README.md`).

mod layout;
pub(super) mod strays;

use std::sync::LazyLock;

use rayon::prelude::*;

use super::super::forest::{Forest, forests, mean_chances};
pub(super) use layout::Known;
pub use layout::{Beliefs, Layout, NUMBERS, Numbers};

/// How many forests are asked side by side in each round: what they believe is averaged.
pub const VOICES: usize = 3;
/// How often the pieces are asked.
pub const ROUNDS: usize = 3;

/// The forests of all rounds, voice by voice: for objects of several components, and for skins.
static GROWN: [&[u8]; 2] = [
    include_bytes!("../../../weights/belonging.trees"),
    include_bytes!("../../../weights/belonging_skins.trees"),
];
static FORESTS: LazyLock<[Vec<Forest<NUMBERS>>; 2]> = LazyLock::new(|| GROWN.map(forests));

/// What is believed of every piece after it was asked in the light of `beliefs`, by some voices on
/// average.
pub fn answers(voices: &[Forest<NUMBERS>], layout: &Layout, beliefs: &Beliefs) -> Beliefs {
    let clusters = layout.clusters(beliefs);
    let mut known = layout.prompts();
    known.par_iter_mut().enumerate().for_each(|(piece, row)| {
        if layout.seed(piece).is_some() {
            return;
        }
        let numbers = layout.numbers(piece, &clusters).into_iter().enumerate();
        let (parts, numbers): (Vec<usize>, Vec<Numbers>) =
            numbers.filter_map(|(p, n)| Some((p, n?))).unzip();
        for (part, chance) in parts.into_iter().zip(mean_chances(voices, &numbers)) {
            row[part] = chance;
        }
    });
    known
}

/// What all voices, or one of them, believe of every piece after all rounds.
pub(super) fn believed(layout: &Layout, is_skin: bool, voice: Option<usize>) -> Beliefs {
    let rounds = FORESTS[usize::from(is_skin)].chunks_exact(VOICES);
    let asked =
        rounds.map(|round| voice.map_or(round, |v| std::slice::from_ref(&round[v % VOICES])));
    asked.fold(layout.first(), |beliefs, round| answers(round, layout, &beliefs))
}

/// The trees by what is in them, shortened.
pub fn digest() -> String {
    let mut hasher = blake3::Hasher::new();
    for grown in GROWN {
        hasher.update(grown);
    }
    hasher.finalize().to_hex().chars().take(12).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_forests_that_ship_are_whole() {
        for (grown, forests) in GROWN.iter().zip(&*FORESTS) {
            assert_eq!(forests.len(), ROUNDS * VOICES);
            let mut bytes = Vec::new();
            forests.iter().for_each(|f| f.write(&mut bytes));
            assert_eq!(bytes, *grown);
        }
    }
}
