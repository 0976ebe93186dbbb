//! Grows the forests: every voice of a round on all objects but its own share, and what it says of
//! those is what the next round is told. Nothing is ever believed of an object by trees that know its
//! truth.

use model::geometric::forest::Forest;
use model::geometric::labels::belonging::{KIN, NUMBERS, answers, kinship};
use rayon::prelude::*;
use training::forest::{Bins, Growth, Lessons, Question};

use super::{Anyhow, Case, Wanted, iou, kin_surprise, pairs, questions, report};

/// The seeds of one round are this far from those of the next.
const ROUND_SEEDS: u64 = 1000;
/// How often the loss is told while a forest grows.
const TOLD: usize = 4;
/// Bins are chosen by the questions of every so many objects.
const SAMPLED: usize = 10;
/// Objects whose questions are held at once.
const AT_ONCE: usize = 64;
/// How a forest grows where the command line says nothing else.
pub(super) const GROWTH: Growth = Growth {
    trees: 240,
    leaves: 31,
    rate: 0.08,
    questions: 0.7,
    numbers: 0.5,
    curve: 20.0,
    hold: 30.0,
    seed: 7,
};

/// Cases that trees are judged by and not grown on, and what they are called.
pub(super) type Judged = (&'static str, Vec<Case>);

/// The forests of all rounds as bytes; `kept` gets what there is after each.
pub(super) fn grown(
    (train, judged): (&mut [Case], &mut [Judged]),
    wanted: &Wanted,
    kept: impl Fn(&[u8]) -> std::io::Result<()>,
) -> Result<(), Anyhow> {
    let mut bytes = Vec::new();
    let kin: Vec<Forest<KIN>> = if wanted.kin {
        voices(train, pairs, (wanted.voices, &wanted.growth))
    } else {
        vec![Forest::default(); wanted.voices]
    };
    kin.iter().for_each(|v| v.write(&mut bytes));
    if wanted.kin {
        tell(&kin, (train, judged));
    }
    for round in 0..wanted.rounds {
        let seed = wanted.growth.seed + ROUND_SEEDS * (round + 1) as u64;
        let voices: Vec<Forest<NUMBERS>> =
            voices(train, questions, (wanted.voices, &Growth { seed, ..wanted.growth }));
        train.par_iter_mut().for_each(|case| {
            let other = &voices[case.voice..=case.voice];
            case.beliefs = answers(other, &case.layout, &case.beliefs);
        });
        report(&format!("round {round}, train by others"), train, iou);
        for (what, cases) in &mut *judged {
            for case in &mut *cases {
                case.beliefs = answers(&voices, &case.layout, &case.beliefs);
            }
            report(&format!("round {round}, {what}"), cases, iou);
        }
        voices.iter().for_each(|v| v.write(&mut bytes));
        kept(&bytes)?;
    }
    Ok(())
}

/// Tells every case which neighbours are of one part: those of training by the voice that does not
/// know them.
fn tell(kin: &[Forest<KIN>], (train, judged): (&mut [Case], &mut [Judged])) {
    train.par_iter_mut().for_each(|case| {
        let chances = kinship(&kin[case.voice..=case.voice], &case.layout);
        case.layout.told_of_kin(&chances);
    });
    for (_, cases) in &mut *judged {
        cases.par_iter_mut().for_each(|case| case.layout.told_of_kin(&kinship(kin, &case.layout)));
    }
    let judged = judged.iter().map(|(what, cases)| (*what, &cases[..]));
    for (what, cases) in std::iter::once(("train by others", &*train)).chain(judged) {
        let loss = cases.iter().map(kin_surprise).sum::<f64>() / cases.len().max(1) as f64;
        eprintln!("which pieces are of one part, {what}: loss {loss:.4}");
    }
}

/// A forest for each voice, each grown on all objects but the voice's own share.
fn voices<const N: usize>(
    train: &[Case],
    asked: impl Fn(&Case) -> Vec<Question<N>> + Sync,
    (count, wanted): (usize, &Growth),
) -> Vec<Forest<N>> {
    let some: Vec<&Case> = train.iter().step_by(SAMPLED).collect();
    let some: Vec<Vec<Question<N>>> = some.into_par_iter().map(&asked).collect();
    let bins = Bins::of(some.iter().flatten().flat_map(|q| &q.numbers));
    let mut lessons = Lessons::new(&bins);
    for some in train.chunks(AT_ONCE) {
        let asked: Vec<Vec<Question<N>>> = some.par_iter().map(&asked).collect();
        asked.iter().for_each(|asked| lessons.add(asked));
    }
    let grow = |voice: usize| {
        let growth = Growth { seed: wanted.seed + voice as u64, ..*wanted };
        lessons.grow(
            &growth,
            |case| train[case].voice != voice,
            |trees, loss| {
                if trees % (growth.trees / TOLD).max(1) == 0 {
                    eprintln!("  voice {voice}, {trees} trees: loss {loss:.4}");
                }
            },
        )
    };
    (0..count).into_par_iter().map(grow).collect()
}
