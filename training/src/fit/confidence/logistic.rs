//! Logistic regression with few features: Platt's calibration, and what makes an object's probability of
//! those of its parts.

use nalgebra::{Cholesky, SMatrix, SVector};

/// Steps of Newton's method; a handful is enough.
const STEPS: usize = 50;
/// What keeps weights near where they begin, in counts of observations; a guess.
const RIDGE: f64 = 1.0;

/// The weights, from where they begin, under which what was told is likeliest; a row's log-odds are the sum of
/// its numbers, weighted.
pub(super) fn weights<const N: usize>(told: &[([f64; N], bool)], begin: [f64; N]) -> [f64; N] {
    let begin = SVector::<f64, N>::from(begin);
    let mut weights = begin;
    for _ in 0..STEPS {
        let mut down = RIDGE * (begin - weights);
        let mut bend = SMatrix::<f64, N, N>::identity() * RIDGE;
        for (row, is_so) in told {
            let row = SVector::<f64, N>::from(*row);
            let chance: f64 = 1.0 / (1.0 + (-weights.dot(&row)).exp());
            down += row * (f64::from(u8::from(*is_so)) - chance);
            bend += row * row.transpose() * (chance * (1.0 - chance));
        }
        let Some(solver) = Cholesky::new(bend) else { break };
        let step = solver.solve(&down);
        weights += step.map(|s| s.clamp(-1.0, 1.0));
        if step.amax() < 1e-10 {
            break;
        }
    }
    weights.into()
}

/// The slope and the offset under which scores, which are log-odds, agree best with what was so.
pub(super) fn line(told: impl Iterator<Item = (f64, bool)>) -> [f64; 2] {
    let told: Vec<([f64; 2], bool)> = told.map(|(score, is_so)| ([score, 1.0], is_so)).collect();
    weights(&told, [1.0, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_that_boast_are_made_modest() {
        // Of what scores 3, which is 95 %, three in four are so; of what scores −3, one in four.
        let all = (0..4000).map(|i| {
            let high = i % 2 == 0;
            (if high { 3.0 } else { -3.0 }, (i / 2 % 4 == 0) != high)
        });
        let [slope, offset] = line(all);
        let chance = 1.0 / (1.0 + (-(3.0 * slope + offset)).exp());
        assert!((chance - 0.75).abs() < 0.01 && offset.abs() < 0.01, "{slope}, {offset}");
    }

    #[test]
    fn what_is_always_so_stays_finite() {
        let [slope, offset] = line((0..50).map(|_| (1.0, true)));
        assert!(slope.is_finite() && offset.is_finite() && slope + offset > 2.0);
    }

    #[test]
    fn what_says_nothing_gets_no_weight() {
        let told = |i: usize| {
            ([(i % 7) as f64, f64::from(u8::from(i.is_multiple_of(2))), 1.0], i.is_multiple_of(2))
        };
        let told: Vec<_> = (0..700).map(told).collect();
        let [noise, signal, _] = weights(&told, [0.0; 3]);
        assert!(noise.abs() < 0.2 && signal > 5.0, "{noise}, {signal}");
    }
}
