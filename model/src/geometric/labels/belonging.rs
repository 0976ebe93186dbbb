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

use super::super::forest::{Forest, mean_chances_of};
pub use kin::{KIN, KinNumbers, Tie, names as pairwise_names};
pub(super) use layout::Known;
pub use layout::{Beliefs, Layout, NUMBERS, Numbers, names as unary_names};

/// Voices of one panel: forests that are asked side by side, what they say being averaged.
const VOICES: usize = 3;

/// So many pieces are asked about at once: trees are many, and stay at hand meanwhile.
const TOGETHER: usize = 16;

/// What was grown for one kind of object.
struct Grown {
    bytes: &'static [u8],
    /// For each panel, how many rounds it was grown for. Each voice of the first leaves out another third
    /// of the objects, so that [`super::Way::Blind`] is blind.
    rounds: &'static [usize],
    /// How often every piece is asked about; a panel that was grown for fewer rounds answers the last
    /// of them again.
    asked: usize,
}

/// What was grown, for objects of several components and for skins.
static GROWN: [Grown; 2] = [
    Grown { bytes: include_bytes!("../../../weights/belonging.trees"), rounds: &[2], asked: 2 },
    Grown {
        bytes: include_bytes!("../../../weights/belonging_skins.trees"),
        rounds: &[3, 3, 2, 2, 2],
        asked: 3,
    },
];
static PANELS: LazyLock<[Vec<Panel>; 2]> = LazyLock::new(|| [0, 1].map(|k| panels(&GROWN[k])));

/// Forests that answer together for one kind of object.
struct Panel {
    /// Which neighbours are of one part, voice by voice; without trees where nothing is said of kin.
    kin: Vec<Forest<KIN>>,
    /// Which part a piece belongs to, round by round, voice by voice.
    parts: Vec<Vec<Forest<NUMBERS>>>,
}

/// The panels that were written one after another, of each the forests of kin first.
fn panels(grown: &Grown) -> Vec<Panel> {
    let mut bytes = grown.bytes;
    let one = |&rounds: &usize| Panel {
        kin: voices(&mut bytes),
        parts: (0..rounds).map(|_| voices(&mut bytes)).collect(),
    };
    grown.rounds.iter().map(one).collect()
}

fn voices<const N: usize>(bytes: &mut &[u8]) -> Vec<Forest<N>> {
    (0..VOICES).map_while(|_| Forest::read(bytes)).collect()
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

    /// Those of a panel's forests that are asked.
    fn of<T>(self, voices: &[T]) -> &[T] {
        match self {
            Asked::Panel(_) => voices,
            Asked::Voice(voice) => voices.get(voice % VOICES).map_or(&[], std::slice::from_ref),
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
    let kind = usize::from(is_skin);
    let panels = &PANELS[kind];
    let Panel { kin, parts } = &panels[asked.panel() % panels.len()];
    if kin.iter().any(|forest| !forest.trees.is_empty()) {
        layout.told_of_kin(&kinship(asked.of(kin), layout));
    }
    let layout = &*layout;
    let again = parts.iter().chain(parts.last().into_iter().cycle());
    let mut told = vec![layout.first()];
    for round in again.take(GROWN[kind].asked) {
        told.extend(told.last().map(|before| answers(asked.of(round), layout, before)));
    }
    told
}

/// What is believed of every piece after all rounds.
pub(super) fn believed(layout: &mut Layout, is_skin: bool, asked: Asked) -> Beliefs {
    rounds(layout, is_skin, asked).pop().unwrap_or_default()
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
    use super::super::patches::Cutting;
    use super::*;

    #[test]
    fn the_forests_that_ship_are_whole() {
        for (grown, panels) in GROWN.iter().zip(&*PANELS) {
            let mut bytes = Vec::new();
            for (Panel { kin, parts }, &rounds) in panels.iter().zip(grown.rounds) {
                assert_eq!((kin.len(), parts.len()), (VOICES, rounds));
                assert!(parts.iter().flatten().all(|f| !f.trees.is_empty()));
                kin.iter().for_each(|f| f.write(&mut bytes));
                parts.iter().flatten().for_each(|f| f.write(&mut bytes));
            }
            assert!(bytes == grown.bytes && !panels.is_empty());
        }
        assert_eq!(
            PANELS[1].len(),
            1 + Cutting::OTHERS.len(),
            "a panel for every way to cut a skin"
        );
    }
}
