//! Which part each piece belongs to: boosted trees ask every piece about every part, in rounds.
//!
//! First, other trees say of each two pieces side by side how likely they are of one part, whatever
//! part that is ([`kinship`]): what lies between a piece and the prompts follows from that. The first
//! round starts from what merging says; each later one from what the round before believed of a piece,
//! its neighbours and its copies. Skins and other objects have trees of their own. Both
//! are grown by `training::fit::segments` on objects with known parts, none of them an
//! evaluation case (see `weights/README.md`).

mod kin;
mod kindred;
mod layout;
pub(super) mod strays;

use rayon::prelude::*;

use super::super::forest::{Forest, mean_chances_of};
use super::super::pack::{self, Pack, PackError};
use super::super::shipped::Shipped;
pub use kin::{KIN, KinNumbers, Tie, names as pairwise_names};
pub(super) use layout::Known;
pub use layout::{Beliefs, Layout, NUMBERS, Numbers, names as unary_names};

/// So many pieces are asked about at once: trees are many, and stay at hand meanwhile.
const TOGETHER: usize = 16;

/// The ensembles for objects of several components and for fused meshes.
static SHIPPED: [Shipped<Learned>; 2] = [
    Shipped::new("segments", include_bytes!("../../../weights/segments.pack"), Learned::read),
    Shipped::new(
        "segments_fused",
        include_bytes!("../../../weights/segments_fused.pack"),
        Learned::read,
    ),
];

/// What packs of segments are called inside, and their two tables of features.
pub const KIND: &str = "segments";
/// The table of [`pairwise_names`].
pub const PAIRWISE: &str = "pairwise";
/// The table of [`unary_names`].
pub const UNARY: &str = "unary";
/// The setting that says how often every segment is asked about; an ensemble that was fitted for fewer
/// rounds answers the last of them again.
pub const ROUNDS: &str = "rounds";

/// What was learned for one kind of object.
#[derive(Debug, Default)]
pub struct Learned {
    ensembles: Vec<Ensemble>,
    rounds: usize,
}

/// Forests that answer together.
#[derive(Debug, Default)]
struct Ensemble {
    /// Which neighbours are of one part, fold by fold; without trees where nothing is said of neighbours.
    pairwise: Vec<Forest<KIN>>,
    /// Which part a segment belongs to, round by round, fold by fold.
    unary: Vec<Vec<Forest<NUMBERS>>>,
}

/// The section of a fold's forest of neighbours.
pub fn pairwise_section(ensemble: usize, fold: usize) -> String {
    format!("ensemble {ensemble}, pairwise, fold {fold}")
}

/// The section of a fold's forest of parts.
pub fn unary_section(ensemble: usize, round: usize, fold: usize) -> String {
    format!("ensemble {ensemble}, round {round}, fold {fold}")
}

impl Learned {
    /// What a pack of segments says.
    ///
    /// # Errors
    /// [`PackError`] when it is none for this program.
    pub fn read(pack: &Pack<'_>) -> Result<Self, PackError> {
        pack.is(KIND)?;
        pack.asks(PAIRWISE, &pairwise_names())?;
        pack.asks(UNARY, &unary_names())?;
        let one = |(e, ensemble): (usize, &pack::Ensemble)| {
            let folds = 0..ensemble.folds;
            let pairwise = folds.clone().map(|f| pack.forest(&pairwise_section(e, f)));
            let round = |r: usize| {
                folds
                    .clone()
                    .map(|f| pack.forest(&unary_section(e, r, f)))
                    .collect::<Result<_, _>>()
            };
            let unary = (0..ensemble.rounds).map(round).collect::<Result<_, _>>()?;
            Ok(Ensemble { pairwise: pairwise.collect::<Result<_, _>>()?, unary })
        };
        let ensembles = pack.head.ensembles.iter().enumerate().map(one);
        let rounds = pack.setting(ROUNDS)? as usize;
        Ok(Self { ensembles: ensembles.collect::<Result<_, _>>()?, rounds })
    }
}

/// Who is asked.
#[derive(Clone, Copy, Debug)]
pub(super) enum Asked {
    /// A panel, by number, counted on from the first after the last.
    Panel(usize),
    /// One voice of the first panel alone, counted on likewise.
    Voice(usize),
}

impl Asked {
    fn panel(self) -> usize {
        match self {
            Asked::Panel(panel) => panel,
            Asked::Voice(_) => 0,
        }
    }

    /// Those of an ensemble's forests that are asked.
    fn of<T>(self, folds: &[T]) -> &[T] {
        match self {
            Asked::Panel(_) => folds,
            Asked::Voice(fold) => {
                folds.get(fold % folds.len().max(1)).map_or(&[], std::slice::from_ref)
            }
        }
    }
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
    known.par_chunks_mut(TOGETHER).enumerate().for_each(|(chunk, known)| {
        let (mut asked, mut rows, mut counts) = (Vec::new(), Vec::new(), Vec::new());
        for (place, piece) in (0..known.len()).zip(chunk * TOGETHER..) {
            if layout.seed(piece).is_some() {
                continue;
            }
            let before = rows.len();
            for (part, numbers) in layout.numbers(piece, &clusters).into_iter().enumerate() {
                let Some(numbers) = numbers else { continue };
                asked.push((place, part));
                rows.push(numbers);
            }
            counts.push(rows.len() - before);
        }
        for ((place, part), chance) in
            asked.into_iter().zip(mean_chances_of(voices, &rows, &counts))
        {
            known[place][part] = chance;
        }
    });
    known
}

/// What is believed of every piece before the first round and after each.
pub(super) fn rounds(layout: &mut Layout, is_skin: bool, asked: Asked) -> Vec<Beliefs> {
    let Learned { ensembles, rounds } = SHIPPED[usize::from(is_skin)].get();
    let Some(Ensemble { pairwise, unary }) = ensembles.get(asked.panel() % ensembles.len().max(1))
    else {
        return Vec::new();
    };
    if pairwise.iter().any(|forest| !forest.trees.is_empty()) {
        layout.told_of_kin(&kinship(asked.of(pairwise), layout));
    }
    let layout = &*layout;
    let again = unary.iter().chain(unary.last().into_iter().cycle());
    let mut told = vec![layout.first()];
    for round in again.take(*rounds) {
        told.extend(told.last().map(|before| answers(asked.of(round), layout, before)));
    }
    told
}

/// What is believed of every piece after all rounds.
pub(super) fn believed(layout: &mut Layout, is_skin: bool, asked: Asked) -> Beliefs {
    rounds(layout, is_skin, asked).pop().unwrap_or_default()
}

/// Refuses packs that this program cannot read.
///
/// # Errors
/// [`PackError`].
pub(super) fn check() -> Result<(), PackError> {
    SHIPPED.iter().try_for_each(Shipped::check)
}

/// The names and the digests of the packs.
pub(super) fn digests_of_packs() -> [(&'static str, String); 2] {
    SHIPPED.each_ref().map(Shipped::digest)
}

/// The trees by what is in them, shortened.
pub fn digest() -> String {
    let mut hasher = blake3::Hasher::new();
    SHIPPED.iter().for_each(|s| s.hash_into(&mut hasher));
    hasher.finalize().to_hex().chars().take(12).collect()
}

#[cfg(test)]
mod tests {
    use super::super::patches::Cutting;
    use super::*;

    #[test]
    fn the_packs_that_ship_are_whole() {
        for shipped in &SHIPPED {
            shipped.check().unwrap();
            for Ensemble { pairwise, unary } in &shipped.get().ensembles {
                assert!(pairwise.len() >= 3 && unary.len() >= 2);
                assert!(unary.iter().flatten().all(|f| !f.trees.is_empty()));
            }
        }
        let [components, fused] = SHIPPED.each_ref().map(Shipped::get);
        assert_eq!((components.rounds, fused.rounds), (2, 3));
        assert_eq!(components.ensembles.len(), 1);
        assert_eq!(
            fused.ensembles.len(),
            1 + Cutting::OTHERS.len(),
            "an ensemble for every way to cut a fused mesh"
        );
    }
}
