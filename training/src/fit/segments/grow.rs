//! Grows the forests: every fold of a round on all objects but its own share, and what it says of those is
//! what the next round is told. No object is ever judged by trees that know its truth.

use std::collections::BTreeMap;

use model::classic::learned::forest::Forest;
use model::classic::learned::pack::{Form, Section};
use model::classic::segment::classify::{
    FEATURES, Features, PAIR_FEATURES, PAIRWISE, SegmentPair, UNARY, answers, pair_probabilities,
    pairwise_section, unary_section,
};
use rayon::prelude::*;

use super::super::{Bench, FitError, Watcher};
use super::case::Case;
use super::ensemble::{Ensemble, Metrics};
use super::measure::{UNLIKELY, counted, iou, report};
use crate::forest::{Bins, Growth, Lessons, Question};

/// The seeds of one round are this far from those of the next.
const ROUND_SEEDS: u64 = 1000;
/// Bins are chosen by the questions of every so many objects.
const SAMPLED: usize = 10;
/// Objects whose questions are held at once.
const AT_ONCE: usize = 64;
/// Two segments count at least as much as if the smaller had this share of the surface.
const TINY: f64 = 1e-3;

/// Cases that an ensemble is judged by and not fitted to, and what they are called.
type Judged = (&'static str, Vec<Case>);

/// The sections and metrics of an ensemble, which is the first of its pack.
#[derive(Default)]
pub(super) struct Grown {
    pub sections: Vec<(Section, Vec<u8>)>,
    pub metrics: Metrics,
}

impl Grown {
    fn put<const N: usize>(&mut self, (name, table): (String, &str), forest: &Forest<N>) {
        let mut bytes = Vec::new();
        forest.write(&mut bytes);
        self.sections.push((Section::new(name, table, Form::Forest), bytes));
    }
}

/// An ensemble, or, where it is split, several.
pub(super) fn grown(
    (mut train, mut judged): (Vec<Case>, Vec<Judged>),
    ensemble: &Ensemble,
    bench: &Bench<'_>,
) -> Result<Grown, FitError> {
    let pairwise: Vec<Forest<PAIR_FEATURES>> = if ensemble.pairwise {
        let asked = ("pairwise", pairs as fn(&Case) -> Vec<Question<PAIR_FEATURES>>);
        let forests = folds(&train, asked, (ensemble.folds, &ensemble.growth), bench)?;
        tell(&forests, (&mut train, &mut judged), bench.watcher);
        forests
    } else {
        vec![Forest::default(); ensemble.folds]
    };
    let (mut rounds, mut metrics) = (Vec::new(), Metrics::new());
    for round in 0..ensemble.rounds {
        let seed = ensemble.growth.seed + ROUND_SEEDS * (round + 1) as u64;
        let growth = Growth { seed, ..ensemble.growth };
        let name = format!("round {round}");
        let asked = (&*name, questions as fn(&Case) -> Vec<Question<FEATURES>>);
        let forests = folds(&train, asked, (ensemble.folds, &growth), bench)?;
        train.par_iter_mut().for_each(|case| {
            let other = &forests[case.fold..=case.fold];
            case.probabilities = answers(other, &case.layout, &case.probabilities);
        });
        let mut told = |what: &str, means: [Option<f64>; 2]| {
            for (mean, how) in means.into_iter().zip(["", ", points anywhere"]) {
                let name = format!("ensemble 0, round {round}, {what}{how}: mean IoU");
                metrics.extend(mean.map(|mean| (name, mean)));
            }
        };
        let out_of_fold = report(bench.watcher, &format!("{name}, out of fold"), &train, iou);
        told("out of fold", out_of_fold);
        for (what, cases) in &mut judged {
            cases.par_iter_mut().for_each(|case| {
                case.probabilities = answers(&forests, &case.layout, &case.probabilities);
            });
            told(what, report(bench.watcher, &format!("{name}, {what}"), cases, iou));
        }
        rounds.push(forests);
    }
    Ok(sections(ensemble, &pairwise, &rounds, metrics))
}

/// What was grown as sections, in the order in which they are asked.
fn sections(
    ensemble: &Ensemble,
    pairwise: &[Forest<PAIR_FEATURES>],
    rounds: &[Vec<Forest<FEATURES>>],
    metrics: Metrics,
) -> Grown {
    let folds = ensemble.folds / ensemble.split;
    let mut grown = Grown { sections: Vec::new(), metrics };
    for part in 0..ensemble.split {
        let own = |fold: usize| part * folds + fold;
        for fold in 0..folds {
            grown.put((pairwise_section(part, fold), PAIRWISE), &pairwise[own(fold)]);
        }
        for (round, forests) in rounds.iter().enumerate() {
            for fold in 0..folds {
                grown.put((unary_section(part, round, fold), UNARY), &forests[own(fold)]);
            }
        }
    }
    grown
}

/// Tells every case which neighbours are of one part: those that are learned from by the fold that does
/// not know them.
fn tell(
    pairwise: &[Forest<PAIR_FEATURES>],
    (train, judged): (&mut [Case], &mut [Judged]),
    watcher: &dyn Watcher,
) {
    train.par_iter_mut().for_each(|case| {
        let chances = pair_probabilities(&pairwise[case.fold..=case.fold], &case.layout);
        case.layout.told_of_pairs(&chances);
    });
    for (_, cases) in &mut *judged {
        cases.par_iter_mut().for_each(|case| {
            case.layout.told_of_pairs(&pair_probabilities(pairwise, &case.layout));
        });
    }
    let judged = judged.iter().map(|(what, cases)| (*what, &cases[..]));
    for (what, cases) in std::iter::once(("out of fold", &*train)).chain(judged) {
        let loss = cases.iter().map(pair_surprise).sum::<f64>() / cases.len().max(1) as f64;
        watcher.say(&format!("which neighbours are of one part, {what}: loss {loss:.4}"));
    }
}

/// A forest for each fold, each grown on all objects but the fold's own share.
fn folds<const N: usize>(
    train: &[Case],
    (name, asked): (&str, fn(&Case) -> Vec<Question<N>>),
    (count, growth): (usize, &Growth),
    bench: &Bench<'_>,
) -> Result<Vec<Forest<N>>, FitError> {
    let some: Vec<&Case> = train.iter().step_by(SAMPLED).collect();
    let some: Vec<Vec<Question<N>>> = some.into_par_iter().map(asked).collect();
    let bins = Bins::of(some.iter().flatten().flat_map(|q| &q.numbers));
    let mut lessons = Lessons::new(&bins);
    for some in train.chunks(AT_ONCE) {
        let asked: Vec<Vec<Question<N>>> = some.par_iter().map(asked).collect();
        asked.iter().for_each(|asked| lessons.add(asked));
    }
    let grow = |fold: usize| {
        let growth = Growth { seed: growth.seed + fold as u64, ..*growth };
        let name = format!("{name}, fold {fold}");
        bench.kept.forest(&name, (&lessons, &growth), |case| train[case].fold != fold)
    };
    (0..count).map(grow).collect()
}

/// Of each segment without a prompt: which part is it of?
fn questions(case: &Case) -> Vec<Question<FEATURES>> {
    let counted = counted(case);
    let clusters = case.layout.clusters(&case.probabilities);
    let one = |segment: usize| {
        if case.layout.seed(segment).is_some() {
            return None;
        }
        let rows = case.layout.features(segment, &clusters);
        let (parts, numbers): (Vec<usize>, Vec<Features>) =
            rows.into_iter().enumerate().filter_map(|(p, r)| Some((p, r?))).unzip();
        let (truth, weight) = counted[segment];
        let right = |p: &usize| f32::from(u8::from(*p == truth));
        parts.contains(&truth).then(|| Question {
            weight: weight as f32,
            truth: parts.iter().map(right).collect(),
            numbers,
        })
    };
    (0..case.layout.len()).filter_map(one).collect()
}

/// Of each two segments side by side: are they of one part? Those of much surface count more.
fn pairs(case: &Case) -> Vec<Question<PAIR_FEATURES>> {
    let whole = |v: &BTreeMap<usize, f64>| v.values().sum::<f64>().max(f64::MIN_POSITIVE);
    let one = |segment_pair: &SegmentPair| {
        let [a, b] = [segment_pair.small, segment_pair.large].map(|i| &case.votes[i as usize]);
        let both = a.iter().map(|(part, x)| x * b.get(part).copied().unwrap_or(0.0)).sum::<f64>();
        let alike = (both / (whole(a) * whole(b))) as f32;
        let weight = (case.layout.share(segment_pair.small as usize) + TINY).sqrt() as f32;
        Question { weight, truth: vec![alike, 1.0 - alike], numbers: vec![segment_pair.features] }
    };
    let mut asked: Vec<Question<PAIR_FEATURES>> =
        case.layout.segment_pairs().iter().map(one).collect();
    let all: f32 = asked.iter().map(|q| q.weight).sum();
    asked.iter_mut().for_each(|q| q.weight /= all.max(f32::MIN_POSITIVE));
    asked
}

/// Mean negative log-likelihood of which segments are of one part.
fn pair_surprise(case: &Case) -> f64 {
    let asked = pairs(case);
    let said = case.layout.pair_chances();
    let one = |(q, &c): (&Question<PAIR_FEATURES>, &f32)| {
        let c = c.clamp(UNLIKELY as f32, 1.0 - UNLIKELY as f32);
        f64::from(-q.weight * (q.truth[0] * c.ln() + q.truth[1] * (1.0 - c).ln()))
    };
    asked.iter().zip(said).map(one).sum()
}
