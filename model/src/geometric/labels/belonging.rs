//! Which part each piece belongs to: boosted trees ask every piece about every part, in rounds.
//!
//! First, other trees say of each two pieces side by side how likely they are of one part, whatever
//! part that is ([`kinship`]): what lies between a piece and the prompts follows from that. The first
//! round starts from what merging says; each later one from what the round before believed of a piece,
//! its neighbours and its copies. Skins and other objects have trees of their own. Both
//! are grown by `training/examples/fit_belonging` on objects with known parts, none of them an
//! evaluation case (see `weights/README.md`).

mod kin;
mod kindred;
mod layout;
pub(super) mod strays;

use std::sync::LazyLock;

use rayon::prelude::*;

use super::super::forest::{Forest, forests, mean_chances};
pub use kin::{KIN, KinNumbers, Tie};
pub(super) use layout::Known;
pub use layout::{Beliefs, Layout, NUMBERS, Numbers};

/// What was grown for one kind of object.
struct Grown {
    bytes: &'static [u8],
    /// How many forests are asked side by side, what they say being averaged. Grown by threes, each
    /// three leaving out the same thirds of the objects, so that [`super::Way::Blind`] stays blind.
    voices: usize,
}

/// What was grown, for objects of several components and for skins.
static GROWN: [Grown; 2] = [
    Grown { bytes: include_bytes!("../../../weights/belonging.trees"), voices: 3 },
    Grown { bytes: include_bytes!("../../../weights/belonging_skins.trees"), voices: 6 },
];
static FORESTS: LazyLock<[Forests; 2]> = LazyLock::new(|| [0, 1].map(|k| Forests::read(&GROWN[k])));

/// The forests that answer for one kind of object.
struct Forests {
    /// Which neighbours are of one part, voice by voice; without trees where nothing is said of kin.
    kin: Vec<Forest<KIN>>,
    /// Which part a piece belongs to, round by round, voice by voice.
    parts: Vec<Forest<NUMBERS>>,
}

impl Forests {
    /// The forests that were written one after another, those of kin first.
    fn read(grown: &Grown) -> Self {
        let mut bytes = grown.bytes;
        let kin = (0..grown.voices).filter_map(|_| Forest::read(&mut bytes)).collect();
        Self { kin, parts: forests(bytes) }
    }
}

/// All voices, or one of them by number, counted on from the first after the last.
fn heard<T>(voices: &[T], voice: Option<usize>) -> &[T] {
    voice.map_or(voices, |v| std::slice::from_ref(&voices[v % voices.len()]))
}

/// How likely the pieces of each tie of a layout are of one part, as some forests say on average.
pub fn kinship(voices: &[Forest<KIN>], layout: &Layout) -> Vec<f32> {
    let one = |tie: &Tie| {
        let odds = |v: &Forest<KIN>| 1.0 / (1.0 + (-v.score(&tie.numbers)).exp());
        voices.iter().map(odds).sum::<f32>() / voices.len().max(1) as f32
    };
    layout.ties().par_iter().map(one).collect()
}

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
pub(super) fn believed(layout: &mut Layout, is_skin: bool, voice: Option<usize>) -> Beliefs {
    let Forests { kin, parts } = &FORESTS[usize::from(is_skin)];
    if kin.iter().any(|forest| !forest.trees.is_empty()) {
        layout.told_of_kin(&kinship(heard(kin, voice), layout));
    }
    let layout = &*layout;
    let rounds = parts.chunks_exact(kin.len());
    rounds.fold(layout.first(), |beliefs, round| answers(heard(round, voice), layout, &beliefs))
}

/// The trees by what is in them, shortened.
pub fn digest() -> String {
    let mut hasher = blake3::Hasher::new();
    for grown in &GROWN {
        hasher.update(grown.bytes);
    }
    hasher.finalize().to_hex().chars().take(12).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_forests_that_ship_are_whole() {
        let rounds = [2, 3];
        for ((grown, Forests { kin, parts }), rounds) in GROWN.iter().zip(&*FORESTS).zip(rounds) {
            assert_eq!((kin.len(), parts.len()), (grown.voices, rounds * grown.voices));
            assert!(parts.iter().all(|f| !f.trees.is_empty()));
            let mut bytes = Vec::new();
            kin.iter().for_each(|f| f.write(&mut bytes));
            parts.iter().for_each(|f| f.write(&mut bytes));
            assert_eq!(bytes, grown.bytes);
        }
    }
}
