//! Fits the network that chooses joint axes: a conditional logit, where each joint picks one of its
//! candidates, by Adam on small batches with decaying weights.

use model::classic::joints::features::COUNT;
use model::classic::learned::network::{FIRST_UNIT, Net, UNIT, UNITS, dot, lean};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::super::{Bench, FitError};
use super::joint::{Joint, own};

type Row = [f64; COUNT];

/// Times every joint is seen, joints seen together, the length of the first step.
const EPOCHS: usize = 8;
const BATCH: usize = 16;
const RATE: f64 = 0.003;
/// How fast weights decay; those of roles three times as fast.
const DECAY: f64 = 0.03;
/// How many networks are fitted, of which the mean is taken: one errs more than several do together.
const TOGETHER: usize = 10;
const _: () = assert!(UNITS.is_multiple_of(TOGETHER));
/// What begins the first of them.
const SEED: u64 = 3;
/// No number spreads less than this.
const LEAST_SPREAD: f64 = 0.05;
/// The likelihood of a right pick is never less than this.
const LEAST: f64 = 1e-9;

/// A joint as the network sees it, its numbers brought to mean 0 and spread 1.
struct Lesson {
    rows: Vec<Row>,
    is_right: Vec<bool>,
    role: usize,
    is_endless: bool,
    weight: f64,
}

/// Mean and spread of each number.
struct Scale {
    mean: Row,
    spread: Row,
}

/// How networks are fitted: other bytes, other networks.
const FITTER: &str = include_str!("net.rs");

/// The network of these joints, fitted or taken over; some candidate of one of them is right.
pub(super) fn fitted(name: &str, joints: &[&Joint], bench: &Bench<'_>) -> Result<Net, FitError> {
    let told: Vec<&Joint> = joints.iter().copied().filter(|j| j.is_told()).collect();
    let mut inputs = blake3::Hasher::new();
    inputs.update(FITTER.as_bytes());
    for asked in told.iter().map(|j| &j.asked) {
        let rows = asked.numbers.iter().flatten().chain(&asked.truth);
        inputs.update(&(asked.truth.len() as u64).to_le_bytes());
        rows.chain([&asked.weight]).for_each(|number| {
            inputs.update(&number.to_le_bytes());
        });
    }
    let make = || {
        let scale = Scale::of(&told);
        let lessons: Vec<Lesson> = told.iter().filter_map(|j| lesson(j, &scale)).collect();
        let seeds = (0..TOGETHER as u64).into_par_iter().map(|k| SEED + k);
        let mut weights = mean(&seeds.map(|seed| fit(&lessons, seed)).collect::<Vec<_>>());
        scale.put_into(&mut weights);
        let net = Net::new(&weights);
        net.map(|net| net.write()).ok_or_else(|| unsound(name, "its weights are not finite"))
    };
    let bytes = bench.kept.model(name, &inputs, make)?;
    let (numbers, _) = bytes.as_chunks();
    let weights: Vec<f64> = numbers.iter().map(|b| f32::from_le_bytes(*b).into()).collect();
    Net::new(&weights).ok_or_else(|| unsound(name, "it cannot be read back"))
}

fn unsound(name: &str, why: &str) -> FitError {
    FitError::Broken(format!("{name}: {why}"))
}

/// The weights of the network that says what several say on average.
fn mean(several: &[Vec<f64>]) -> Vec<f64> {
    let share = 1.0 / several.len() as f64;
    let lines = |i: usize| several.iter().map(|weights| weights[i]).sum::<f64>() * share;
    let mut weights: Vec<f64> = (0..FIRST_UNIT).map(lines).collect();
    for unit in several.iter().flat_map(|own| own[FIRST_UNIT..].chunks(UNIT)) {
        weights.extend(unit);
        weights.iter_mut().last().into_iter().for_each(|worth| *worth *= share);
    }
    weights
}

fn lesson(joint: &Joint, scale: &Scale) -> Option<Lesson> {
    let (role, is_endless) = joint.told()?;
    let asked = &joint.asked;
    Some(Lesson {
        rows: asked.numbers.iter().map(|n| scale.applied(&own(n))).collect(),
        is_right: asked.truth.iter().map(|t| *t > 0.0).collect(),
        role,
        is_endless,
        weight: asked.weight.into(),
    })
}

impl Scale {
    fn of(joints: &[&Joint]) -> Self {
        let (mut sum, mut square, mut count) = ([0.0; COUNT], [0.0; COUNT], 0.0);
        for numbers in joints.iter().flat_map(|j| &j.asked.numbers) {
            count += 1.0;
            for (i, v) in own(numbers).into_iter().enumerate() {
                sum[i] += v;
                square[i] += v * v;
            }
        }
        let mean = sum.map(|s| s / count);
        let mut spread = [0.0; COUNT];
        for (i, s) in spread.iter_mut().enumerate() {
            *s = (square[i] / count - mean[i].powi(2)).max(0.0).sqrt().max(LEAST_SPREAD);
        }
        Self { mean, spread }
    }

    fn applied(&self, row: &Row) -> Row {
        let mut out = *row;
        for (v, (mean, spread)) in out.iter_mut().zip(self.mean.iter().zip(&self.spread)) {
            *v = (*v - mean) / spread;
        }
        out
    }

    /// Makes weights of scaled numbers those of numbers as they are measured.
    fn put_into(&self, weights: &mut [f64]) {
        let (lines, units) = weights.split_at_mut(FIRST_UNIT);
        for line in lines.chunks_mut(COUNT).chain(units.chunks_mut(UNIT)) {
            line.iter_mut().zip(&self.spread).for_each(|(w, s)| *w /= s);
            let shift = dot(&self.mean, line);
            if let Some(bias) = line.get_mut(COUNT) {
                *bias -= shift;
            }
        }
    }
}

/// The weights of one network.
fn fit(lessons: &[Lesson], seed: u64) -> Vec<f64> {
    let size = FIRST_UNIT + UNITS / TOGETHER * UNIT;
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut weights = vec![0.0; size];
    for unit in weights[FIRST_UNIT..].chunks_mut(UNIT) {
        let reach = (3.0 / (UNIT - 1) as f64).sqrt();
        unit.iter_mut().for_each(|w| *w = (2.0 * rng.random::<f64>() - 1.0) * reach);
        unit[UNIT - 1] *= 0.1 / reach;
    }
    let (mut mean, mut square) = (vec![0.0; size], vec![0.0; size]);
    let steps = EPOCHS * lessons.len() / BATCH;
    for step in 1..=steps {
        let mut slope = vec![0.0; size];
        for _ in 0..BATCH {
            add_slope(&lessons[rng.random_range(0..lessons.len())], &weights, &mut slope);
        }
        let rate = RATE * (1.0 - (step as f64 - 1.0) / steps as f64);
        let warm = |decay: f64| 1.0 - decay.powi(step as i32);
        for (i, w) in weights.iter_mut().enumerate() {
            mean[i] = 0.9 * mean[i] + 0.1 * slope[i];
            square[i] = 0.999 * square[i] + 0.001 * slope[i] * slope[i];
            let way = mean[i] / warm(0.9) / ((square[i] / warm(0.999)).sqrt() + 1e-8);
            let of_role = (COUNT..FIRST_UNIT).contains(&i);
            *w -= rate * (way + if of_role { 3.0 * DECAY } else { DECAY } * *w);
        }
    }
    weights
}

fn score(lesson: &Lesson, row: &Row, weights: &[f64]) -> f64 {
    let bent =
        |unit: &[f64]| unit[UNIT - 1] * lean(unit, row, lesson.role, lesson.is_endless).tanh();
    let units: f64 = weights[FIRST_UNIT..].chunks(UNIT).map(bent).sum();
    dot(row, weights) + dot(row, &weights[COUNT * (1 + lesson.role)..]) + units
}

/// Adds the slope of the negative log-likelihood of a right pick.
fn add_slope(lesson: &Lesson, weights: &[f64], slope: &mut [f64]) {
    let scores: Vec<f64> = lesson.rows.iter().map(|row| score(lesson, row, weights)).collect();
    let best = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let likely: Vec<f64> = scores.iter().map(|s| (s - best).exp()).collect();
    let all: f64 = likely.iter().sum();
    let picked = likely.iter().zip(&lesson.is_right).filter(|(_, r)| **r).map(|(l, _)| l);
    let right = picked.sum::<f64>() + LEAST * all;
    for ((row, l), is_right) in lesson.rows.iter().zip(&likely).zip(&lesson.is_right) {
        let own = if *is_right { l / right } else { 0.0 };
        let pull = (l / all - own) * lesson.weight / BATCH as f64;
        let add = |slope: &mut [f64], by: f64| {
            slope.iter_mut().zip(row).for_each(|(s, v)| *s += by * v);
        };
        add(slope, pull);
        add(&mut slope[COUNT * (1 + lesson.role)..], pull);
        let units = weights[FIRST_UNIT..].chunks(UNIT);
        for (unit, slope) in units.zip(slope[FIRST_UNIT..].chunks_mut(UNIT)) {
            let bent = lean(unit, row, lesson.role, lesson.is_endless).tanh();
            slope[UNIT - 1] += pull * bent;
            let by = pull * unit[UNIT - 1] * (1.0 - bent * bent);
            add(slope, by);
            slope[COUNT] += by;
            slope[COUNT + 1] += if lesson.is_endless { by } else { 0.0 };
            slope[COUNT + 2 + lesson.role] += by;
        }
    }
}
