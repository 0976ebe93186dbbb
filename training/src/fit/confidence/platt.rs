//! Platt's calibration: a slope and an offset that make probabilities of scores.

use crate::metrics::calibration::Told;

/// Steps of Newton's method; a handful is enough.
const STEPS: usize = 50;
/// What keeps both near those of scores that are log-odds already, in counts of observations; a guess.
const RIDGE: f64 = 1.0;

/// The slope and the offset under which what was told is likeliest; scores are log-odds.
pub(super) fn line(told: impl Iterator<Item = Told> + Clone) -> [f64; 2] {
    let (mut slope, mut offset) = (1.0, 0.0);
    for _ in 0..STEPS {
        let mut gradient = [RIDGE * (1.0 - slope), -RIDGE * offset];
        let mut curve = [RIDGE, 0.0, RIDGE];
        for (score, is_so) in told.clone() {
            let chance: f64 = 1.0 / (1.0 + (-(slope * score + offset)).exp());
            let off = f64::from(u8::from(is_so)) - chance;
            let weight = chance * (1.0 - chance);
            gradient[0] += off * score;
            gradient[1] += off;
            curve[0] += weight * score * score;
            curve[1] += weight * score;
            curve[2] += weight;
        }
        let [a, b, c] = curve;
        let whole = a * c - b * b;
        let step = [
            (c * gradient[0] - b * gradient[1]) / whole,
            (a * gradient[1] - b * gradient[0]) / whole,
        ];
        slope += step[0].clamp(-1.0, 1.0);
        offset += step[1].clamp(-1.0, 1.0);
        if step.iter().all(|s| s.abs() < 1e-10) {
            break;
        }
    }
    [slope, offset]
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
}
