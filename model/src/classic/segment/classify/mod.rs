//! Which part each segment belongs to: boosted trees give it a class probability for every part.
//!
//! Trees for pairs come first: how likely are two neighbouring segments of one part, whatever part
//! that is ([`pair_probabilities`])? From this follows how well a segment is connected to each
//! prompt. Then trees for segments answer in rounds. The first round starts from merging. Each
//! later one sees the probabilities of the round before, of the segment, its neighbours and its
//! copies.
//!
//! Fused meshes have trees of their own. All are fitted by `training::fit::segments` on objects
//! with known parts, none of them an evaluation case (see the model card,
//! `model/weights/README.md`).

pub mod affinity;
pub mod facts;
pub mod pairwise;
pub mod unary;

use std::ops::Range;

use rayon::prelude::*;

use crate::classic::learned::forest::Forest;
use crate::classic::learned::grove::{ABREAST, Grove};
use crate::classic::learned::pack;
use crate::classic::learned::pack::{Pack, PackError};
use crate::classic::learned::shipped::Shipped;
pub(crate) use crate::classic::segment::classify::facts::Known;
pub use crate::classic::segment::classify::facts::Probabilities;
pub use crate::classic::segment::classify::pairwise::{
    PAIR_FEATURES, PairFeatures, SegmentPair, names as pairwise_names,
};
pub use crate::classic::segment::classify::unary::{
    FEATURES, Features, Layout, names as unary_names,
};

/// The ensembles for objects of several components and for fused meshes.
static SHIPPED: [Shipped<Learned>; 2] = [
    Shipped::new("segments", include_bytes!("../../../../weights/segments.pack"), Learned::read),
    Shipped::new(
        "segments_fused",
        include_bytes!("../../../../weights/segments_fused.pack"),
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
    pairwise: Grove<PAIR_FEATURES>,
    /// Which part a segment belongs to, round by round, fold by fold.
    unary: Vec<Grove<FEATURES>>,
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
                let forests = folds.clone().map(|f| pack.forest(&unary_section(e, r, f)));
                Ok(Grove::of(forests.collect::<Result<_, _>>()?))
            };
            let unary = (0..ensemble.rounds).map(round).collect::<Result<_, _>>()?;
            Ok(Ensemble { pairwise: Grove::of(pairwise.collect::<Result<_, _>>()?), unary })
        };
        let ensembles = pack.head.ensembles.iter().enumerate().map(one);
        let rounds = pack.setting(ROUNDS)? as usize;
        Ok(Self { ensembles: ensembles.collect::<Result<_, _>>()?, rounds })
    }
}

/// Who is asked.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Asked {
    /// An ensemble, by number, counted on from the first after the last.
    Ensemble(usize),
    /// One fold of the first ensemble alone, counted on likewise.
    Fold(usize),
}

impl Asked {
    fn ensemble(self) -> usize {
        match self {
            Asked::Ensemble(ensemble) => ensemble,
            Asked::Fold(_) => 0,
        }
    }

    /// Which of an ensemble's folds are asked.
    fn of<const N: usize>(self, grove: &Grove<N>) -> Range<usize> {
        let count = grove.folds().len();
        match self {
            Asked::Fold(fold) if count > 0 => fold % count..fold % count + 1,
            _ => 0..count,
        }
    }
}

/// How likely the segments of each pair of a layout are of one part, as some forests say on average.
pub fn pair_probabilities(folds: &[Forest<PAIR_FEATURES>], layout: &Layout) -> Vec<f32> {
    pairs_by(&Grove::of(folds.to_vec()), 0..folds.len(), layout)
}

fn pairs_by(grove: &Grove<PAIR_FEATURES>, asked: Range<usize>, layout: &Layout) -> Vec<f32> {
    let some = |pairs: &[SegmentPair]| {
        let rows: Vec<PairFeatures> = pairs.iter().map(|pair| pair.features).collect();
        let mut sums = vec![0.0; rows.len()];
        for scores in grove.scores(asked.clone(), &rows) {
            for (sum, score) in sums.iter_mut().zip(scores) {
                *sum += 1.0 / (1.0 + (-score).exp());
            }
        }
        sums.iter().map(|sum| sum / asked.len().max(1) as f32).collect::<Vec<f32>>()
    };
    layout.segment_pairs().par_chunks(ABREAST).flat_map_iter(some).collect()
}

/// What is believed of every segment after it was asked in the light of `probabilities`, by some folds on
/// average.
pub fn answers(
    folds: &[Forest<FEATURES>],
    layout: &Layout,
    probabilities: &Probabilities,
) -> Probabilities {
    answers_by(&Grove::of(folds.to_vec()), 0..folds.len(), (layout, probabilities))
}

fn answers_by(
    grove: &Grove<FEATURES>,
    folds: Range<usize>,
    (layout, probabilities): (&Layout, &Probabilities),
) -> Probabilities {
    let clusters = layout.clusters(probabilities);
    let mut known = layout.prompts();
    let together = (ABREAST / known.first().map_or(1, Vec::len).max(1)).max(1);
    known.par_chunks_mut(together).enumerate().for_each(|(chunk, known)| {
        let (mut asked, mut rows, mut counts) = (Vec::new(), Vec::new(), Vec::new());
        for (place, segment) in (0..known.len()).zip(chunk * together..) {
            if layout.seed(segment).is_some() {
                continue;
            }
            let before = rows.len();
            for (part, features) in layout.each_features(segment, &clusters).enumerate() {
                let Some(features) = features else { continue };
                asked.push((place, part));
                rows.push(features);
            }
            counts.push(rows.len() - before);
        }
        let chances = grove.mean_chances_of(folds.clone(), &rows, &counts);
        for ((place, part), chance) in asked.into_iter().zip(chances) {
            known[place][part] = chance;
        }
    });
    known
}

/// What is believed of every segment before the first round and after each.
pub(crate) fn rounds(layout: &mut Layout, is_fused: bool, asked: Asked) -> Vec<Probabilities> {
    let Learned { ensembles, rounds } = SHIPPED[usize::from(is_fused)].get();
    let Some(Ensemble { pairwise, unary }) =
        ensembles.get(asked.ensemble() % ensembles.len().max(1))
    else {
        return Vec::new();
    };
    if pairwise.folds().iter().any(|forest| !forest.trees.is_empty()) {
        layout.told_of_pairs(&pairs_by(pairwise, asked.of(pairwise), layout));
    }
    let layout = &*layout;
    let again = unary.iter().chain(unary.last().into_iter().cycle());
    let mut told = vec![layout.first()];
    for round in again.take(*rounds) {
        told.extend(told.last().map(|before| answers_by(round, asked.of(round), (layout, before))));
    }
    told
}

/// What is believed of every segment after all rounds.
pub(crate) fn estimated(layout: &mut Layout, is_fused: bool, asked: Asked) -> Probabilities {
    rounds(layout, is_fused, asked).pop().unwrap_or_default()
}

/// Refuses packs that this program cannot read.
///
/// # Errors
/// [`PackError`].
pub(crate) fn check() -> Result<(), PackError> {
    SHIPPED.iter().try_for_each(Shipped::check)
}

/// The names and the digests of the packs.
pub(crate) fn digests_of_packs() -> [(&'static str, String); 2] {
    SHIPPED.each_ref().map(Shipped::digest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classic::segment::oversegment::patches::Cutting;

    #[test]
    fn the_packs_that_ship_are_whole() {
        for shipped in &SHIPPED {
            shipped.check().unwrap();
            for Ensemble { pairwise, unary } in &shipped.get().ensembles {
                assert!(pairwise.folds().len() >= 3 && unary.len() >= 2);
                assert!(unary.iter().flat_map(Grove::folds).all(|f| !f.trees.is_empty()));
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
