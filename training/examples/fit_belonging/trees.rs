//! Grows the forests: every voice of a round on all objects but its own share, and what it says of
//! those is what the next round is told. Nothing is ever believed of an object by trees that know its
//! truth.

use model::geometric::forest::Forest;
use model::geometric::labels::belonging::{NUMBERS, ROUNDS, VOICES, answers};
use rayon::prelude::*;
use training::forest::{Bins, Growth, Lessons, Question};

use super::{Anyhow, Case, iou, questions, report};

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
    trees: 300,
    leaves: 31,
    rate: 0.1,
    questions: 0.7,
    numbers: 0.5,
    curve: 5.0,
    hold: 5.0,
    seed: 7,
};

/// The forests of all rounds as bytes; `kept` gets what there is after each.
pub(super) fn grown(
    (train, val): (&mut [Case], &mut [Case]),
    wanted: &Growth,
    kept: impl Fn(&[u8]) -> std::io::Result<()>,
) -> Result<(), Anyhow> {
    let mut bytes = Vec::new();
    for round in 0..ROUNDS {
        let bins = bins(train);
        let seed = wanted.seed + ROUND_SEEDS * round as u64;
        let grow = |voice: usize| {
            let growth = Growth { seed: seed + voice as u64, ..*wanted };
            forest(train.iter().filter(|c| c.voice != voice), &bins, &growth)
        };
        let voices: Vec<Forest<NUMBERS>> = (0..VOICES).map(grow).collect();
        train.par_iter_mut().for_each(|case| {
            let other = &voices[case.voice..=case.voice];
            case.beliefs = answers(other, &case.layout, &case.beliefs);
        });
        for case in &mut *val {
            case.beliefs = answers(&voices, &case.layout, &case.beliefs);
        }
        report(&format!("round {round}, train by others"), train, iou);
        report(&format!("round {round}, val"), val, iou);
        voices.iter().for_each(|v| v.write(&mut bytes));
        kept(&bytes)?;
    }
    Ok(())
}

/// Bins of what is asked about some of the objects.
fn bins(cases: &[Case]) -> Bins<NUMBERS> {
    let some: Vec<&Case> = cases.iter().step_by(SAMPLED).collect();
    let asked: Vec<Vec<Question<NUMBERS>>> = some.into_par_iter().map(questions).collect();
    Bins::of(asked.iter().flatten().flat_map(|q| &q.numbers))
}

/// A forest that knows these objects.
fn forest<'a>(
    cases: impl Iterator<Item = &'a Case>,
    bins: &Bins<NUMBERS>,
    growth: &Growth,
) -> Forest<NUMBERS> {
    let mut lessons = Lessons::new(bins);
    let cases: Vec<&Case> = cases.collect();
    for some in cases.chunks(AT_ONCE) {
        let asked: Vec<Vec<Question<NUMBERS>>> = some.par_iter().map(|c| questions(c)).collect();
        asked.iter().for_each(|asked| lessons.add(asked));
    }
    lessons.grow(growth, |trees, loss| {
        if trees % (growth.trees / TOLD).max(1) == 0 {
            eprintln!("  {trees} trees: loss {loss:.4}");
        }
    })
}
