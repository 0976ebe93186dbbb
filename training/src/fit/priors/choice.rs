//! Logistic regression over choices: of several options, or none of them, one is right.
//!
//! An option's score is the sum of its features' weights over the rows that count for it, as the weights
//! of a role and of its joint do; none scores 0. Weights are found by Newton's method with a ridge, so the
//! same choices give the same weights.

use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

/// Rounds of Newton's method at most, and the step that is none any more.
const ROUNDS: usize = 40;
const STILL: f64 = 1e-6;
/// Longest step of a weight.
const STRIDE: f64 = 3.0;
/// How often a step is halved at most, and what share of what the slope promises it must bring.
const HALVINGS: usize = 30;
const LEAST_GAIN: f64 = 1e-4;
/// Choices are added up in runs of this many, and the runs in order.
const RUN: usize = 256;

/// One of several options is right, or several are good.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// How much it counts.
    pub weight: f64,
    /// The options.
    pub options: Vec<ChoiceOption>,
    /// Whether none of them may be right.
    pub may_be_none: bool,
}

/// What may be chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct ChoiceOption {
    /// The rows of weights that count for it.
    pub rows: Vec<usize>,
    /// Its features.
    pub features: Vec<f64>,
    /// How often it ought to be chosen; what is left of 1 is none of the options.
    pub truth: f64,
}

/// Rows of weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    features: usize,
    all: Vec<f64>,
}

impl Weights {
    /// So many rows of so many features, all 0.
    pub fn new(rows: usize, features: usize) -> Self {
        Self { features, all: vec![0.0; rows * features] }
    }

    /// A row.
    pub fn row(&self, row: usize) -> &[f64] {
        self.all.get(row * self.features..(row + 1) * self.features).unwrap_or(&[])
    }

    /// The score of an option: log-odds against none of them.
    pub fn score(&self, option: &ChoiceOption) -> f64 {
        let of_row = |row: &usize| dot(self.row(*row), &option.features);
        option.rows.iter().map(of_row).sum()
    }

    /// How likely each option of a choice is, and then, where it may be, none of them.
    pub fn probabilities(&self, choice: &Choice) -> Vec<f64> {
        let mut scores: Vec<f64> = choice.options.iter().map(|o| self.score(o)).collect();
        scores.extend(choice.may_be_none.then_some(0.0));
        let most = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let likely: Vec<f64> = scores.iter().map(|s| (s - most).exp()).collect();
        let all: f64 = likely.iter().sum();
        likely.into_iter().map(|l| l / all).collect()
    }

    /// Mean negative log-likelihood of what is right.
    pub fn loss(&self, choices: &[Choice]) -> f64 {
        let weight: f64 = choices.iter().map(|c| c.weight).sum();
        let one = |c: &Choice| c.weight * negative_log_likelihood(c, &self.probabilities(c));
        choices.iter().map(one).sum::<f64>() / weight.max(f64::MIN_POSITIVE)
    }
}

/// The weights, of so many rows and features, under which what is right is likeliest, where each squared
/// weight costs half of `ridge`; and what is said of every round. `told` hears of the mean loss.
pub fn fitted(
    choices: &[Choice],
    (rows, features): (usize, usize),
    ridge: f64,
    told: impl Fn(usize, f64),
) -> Weights {
    let mut weights = Weights::new(rows, features);
    let total: f64 = choices.iter().map(|c| c.weight).sum();
    for round in 0..ROUNDS {
        let run = |run: &[Choice]| {
            let mut slope = Slope::new(weights.all.len());
            run.iter().for_each(|choice| slope.add(choice, &weights));
            slope
        };
        let runs: Vec<Slope> = choices.par_chunks(RUN).map(run).collect();
        let mut all = Slope::new(weights.all.len());
        runs.iter().for_each(|run| all.merge(run));
        told(round, all.loss / total.max(f64::MIN_POSITIVE));
        for (i, weight) in weights.all.iter().enumerate() {
            all.down[i] -= ridge * weight;
            all.bend[(i, i)] += ridge;
        }
        let Some(solver) = Cholesky::new(all.bend) else { break };
        let step = solver.solve(&all.down);
        let Some(moved) = stepped(&weights, (&step, all.down.dot(&step)), (choices, ridge)) else {
            break;
        };
        weights = moved;
        if step.amax() < STILL {
            break;
        }
    }
    weights
}

/// The weights after a step, shortened until what it costs is less by a share of what the slope promises;
/// nothing where no step is short enough.
fn stepped(
    weights: &Weights,
    (step, promise): (&DVector<f64>, f64),
    (choices, ridge): (&[Choice], f64),
) -> Option<Weights> {
    let before = cost(weights, choices, ridge);
    let mut stride = (STRIDE / step.amax()).min(1.0);
    for _ in 0..HALVINGS {
        let mut moved = weights.clone();
        moved.all.iter_mut().zip(step).for_each(|(w, s)| *w += stride * s);
        if cost(&moved, choices, ridge) <= before - LEAST_GAIN * stride * promise {
            return Some(moved);
        }
        stride *= 0.5;
    }
    None
}

/// Negative log-likelihood of what is right, and what weights cost.
fn cost(weights: &Weights, choices: &[Choice], ridge: f64) -> f64 {
    let one = |c: &Choice| c.weight * negative_log_likelihood(c, &weights.probabilities(c));
    let run = |run: &[Choice]| run.iter().map(one).sum::<f64>();
    let runs: Vec<f64> = choices.par_chunks(RUN).map(run).collect();
    runs.iter().sum::<f64>() + 0.5 * ridge * weights.all.iter().map(|w| w * w).sum::<f64>()
}

/// The loss, its negative slope and its curvature.
struct Slope {
    loss: f64,
    down: DVector<f64>,
    bend: DMatrix<f64>,
}

/// The options of a choice that the same rows count for, by their sums: probability times features, and
/// times features by features.
struct Sums {
    mean: Vec<f64>,
    square: Vec<f64>,
    pull: Vec<f64>,
}

impl Slope {
    fn new(size: usize) -> Self {
        Self { loss: 0.0, down: DVector::zeros(size), bend: DMatrix::zeros(size, size) }
    }

    fn merge(&mut self, other: &Self) {
        self.loss += other.loss;
        self.down += &other.down;
        self.bend += &other.bend;
    }

    fn add(&mut self, choice: &Choice, weights: &Weights) {
        let n = weights.features;
        let likely = weights.probabilities(choice);
        self.loss += choice.weight * negative_log_likelihood(choice, &likely);
        let mut groups: BTreeMap<&[usize], Sums> = BTreeMap::new();
        for (option, p) in choice.options.iter().zip(&likely) {
            let sums = groups.entry(&option.rows).or_insert_with(|| Sums {
                mean: vec![0.0; n],
                square: vec![0.0; n * n],
                pull: vec![0.0; n],
            });
            for (i, x) in option.features.iter().enumerate() {
                sums.mean[i] += p * x;
                sums.pull[i] += (option.truth - p) * x;
                let row = &mut sums.square[i * n..(i + 1) * n];
                row.iter_mut().zip(&option.features).for_each(|(s, y)| *s += p * x * y);
            }
        }
        let mut mean: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for (rows, sums) in &groups {
            for &a in *rows {
                let whole = mean.entry(a).or_insert_with(|| vec![0.0; n]);
                whole.iter_mut().zip(&sums.mean).for_each(|(w, m)| *w += m);
                let down = self.down.iter_mut().skip(a * n);
                down.zip(&sums.pull).for_each(|(d, pull)| *d += choice.weight * pull);
                for &b in *rows {
                    self.bend_by((a, b), n, |i, j| choice.weight * sums.square[i * n + j]);
                }
            }
        }
        for (&a, of_a) in &mean {
            for (&b, of_b) in &mean {
                self.bend_by((a, b), n, |i, j| -choice.weight * of_a[i] * of_b[j]);
            }
        }
    }

    /// Adds to the curvature between two rows.
    fn bend_by(&mut self, (a, b): (usize, usize), n: usize, by: impl Fn(usize, usize) -> f64) {
        for j in 0..n {
            for i in 0..n {
                self.bend[(a * n + i, b * n + j)] += by(i, j);
            }
        }
    }
}

/// Negative log-likelihood of what is right.
fn negative_log_likelihood(choice: &Choice, likely: &[f64]) -> f64 {
    let told = choice.options.iter().map(|o| o.truth);
    let none = 1.0 - told.clone().sum::<f64>();
    let told = told.chain(choice.may_be_none.then_some(none));
    told.zip(likely).filter(|(t, _)| *t > 0.0).map(|(t, p)| -t * p.max(1e-12).ln()).sum()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
pub(crate) mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Choices whose truth is how likely these weights find each option.
    pub(crate) fn by(weights: &Weights, shape: impl Fn(&mut Pcg64Mcg) -> Choice) -> Vec<Choice> {
        let mut dice = Pcg64Mcg::seed_from_u64(5);
        let one = |_| {
            let mut choice = shape(&mut dice);
            let likely = weights.probabilities(&choice);
            choice.options.iter_mut().zip(likely).for_each(|(o, p)| o.truth = p);
            choice
        };
        (0..400).map(one).collect()
    }

    fn option(dice: &mut Pcg64Mcg, rows: &[usize]) -> ChoiceOption {
        let features = (0..3).map(|_| dice.random::<f64>() * 2.0 - 1.0).collect();
        ChoiceOption { rows: rows.to_vec(), features, truth: 0.0 }
    }

    #[test]
    fn weights_that_made_the_choices_are_found_again() {
        let known = Weights { features: 3, all: vec![1.5, -2.0, 0.25, 0.5, 1.0, -0.75] };
        let choices = by(&known, |dice| Choice {
            weight: 1.0 + dice.random::<f64>(),
            options: vec![option(dice, &[0]), option(dice, &[0, 1]), option(dice, &[1])],
            may_be_none: true,
        });
        let losses = std::cell::RefCell::new(Vec::new());
        let found = fitted(&choices, (2, 3), 1e-9, |_, loss| losses.borrow_mut().push(loss));
        for (a, b) in found.all.iter().zip(&known.all) {
            assert!((a - b).abs() < 1e-4, "{:?}", found.all);
        }
        let losses = losses.into_inner();
        assert!(losses.len() < 12 && losses.windows(2).all(|l| l[1] <= l[0] + 1e-9), "{losses:?}");
        assert!(found.loss(&choices) <= known.loss(&choices) + 1e-9);
        let other = fitted(&choices, (2, 3), 1e-9, |_, _| ());
        assert_eq!(other, found, "same choices, same weights");
    }

    #[test]
    fn a_ridge_holds_back_what_nothing_speaks_against() {
        let one = ChoiceOption { rows: vec![0], features: vec![1.0], truth: 1.0 };
        let sure = Choice { weight: 1.0, options: vec![one], may_be_none: true };
        let found = fitted(&[sure], (1, 1), 0.1, |_, _| ());
        let w = found.row(0)[0];
        // Where the slope is none: 1 / (1 + e^w) = 0.1 w.
        assert!((1.0 / (1.0 + w.exp()) - 0.1 * w).abs() < 1e-6, "{w}");
    }

    #[test]
    fn a_step_that_is_too_long_is_shortened() {
        // Far out, where the curvature is next to none, a full step would overshoot by far.
        let one = |x: f64, truth: f64| {
            let option = ChoiceOption { rows: vec![0], features: vec![x], truth };
            Choice { weight: 1.0, options: vec![option], may_be_none: true }
        };
        let choices = [one(40.0, 0.75), one(-0.5, 0.5), one(30.0, 0.0)];
        let losses = std::cell::RefCell::new(Vec::new());
        let found = fitted(&choices, (1, 1), 1e-3, |_, loss| losses.borrow_mut().push(loss));
        let losses = losses.into_inner();
        assert!(losses.windows(2).all(|l| l[1] <= l[0] + 1e-9), "{losses:?}");
        let at = |w: f64| cost(&Weights { features: 1, all: vec![w] }, &choices, 1e-3);
        let w = found.row(0)[0];
        assert!(at(w) <= at(w + 1e-3) && at(w) <= at(w - 1e-3), "{w}");
    }

    #[test]
    fn what_cannot_be_chosen_takes_no_share() {
        let weights = Weights { features: 1, all: vec![2.0] };
        let option = |x: f64| ChoiceOption { rows: vec![0], features: vec![x], truth: 0.0 };
        let options = vec![option(0.0), option(1.0)];
        let mut choice = Choice { weight: 1.0, options, may_be_none: false };
        let likely = weights.probabilities(&choice);
        assert!((likely[1] / likely[0] - 2f64.exp()).abs() < 1e-9 && likely.len() == 2);
        choice.may_be_none = true;
        let likely = weights.probabilities(&choice);
        assert!((likely.iter().sum::<f64>() - 1.0).abs() < 1e-12 && likely[2] == likely[0]);
    }
}
