//! Whether probabilities mean something: of what is said to be right with probability 0.8, four in five are.

use serde::Serialize;

/// Into how many bins of equal width probabilities fall.
const BINS: usize = 10;

/// What was said to be how likely, and whether it was so.
pub type Told = (f64, bool);

/// How well probabilities agree with what was so.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Calibration {
    /// How many there were.
    pub count: usize,
    /// The share that was so, 0 to 1; none of nothing.
    pub right: Option<f64>,
    /// Expected calibration error, 0 to 1: how far the mean probability of a bin is from the share that was
    /// so, by the bins' counts; ten bins of equal width. None of nothing.
    pub ece: Option<f64>,
    /// The chance that something that was so had a higher probability than something that was not, 0 to 1;
    /// none where all or nothing was so.
    pub auroc: Option<f64>,
    /// Of every bin with anything in it, the lowest first: the count, the mean probability and the share that
    /// was so.
    pub bins: Vec<(usize, f64, f64)>,
}

impl Calibration {
    /// That of everything that was told.
    pub fn of(told: &[Told]) -> Self {
        let count = told.len();
        let share = |of: &[Told]| of.iter().filter(|t| t.1).count() as f64 / of.len() as f64;
        let mean = |of: &[Told]| of.iter().map(|t| t.0).sum::<f64>() / of.len() as f64;
        let mut bins: Vec<Vec<Told>> = vec![Vec::new(); BINS];
        for &one in told {
            bins[((one.0 * BINS as f64) as usize).min(BINS - 1)].push(one);
        }
        bins.retain(|bin| !bin.is_empty());
        let bins: Vec<_> = bins.iter().map(|bin| (bin.len(), mean(bin), share(bin))).collect();
        let off = bins.iter().map(|(n, mean, share)| *n as f64 * (mean - share).abs());
        let ece = (count > 0).then(|| off.sum::<f64>() / count as f64);
        Self { count, right: (count > 0).then(|| share(told)), ece, auroc: auroc(told), bins }
    }
}

/// By ranks; what is equally likely counts half.
fn auroc(told: &[Told]) -> Option<f64> {
    let positive = told.iter().filter(|t| t.1).count();
    let negative = told.len() - positive;
    if positive == 0 || negative == 0 {
        return None;
    }
    let mut sorted = told.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut ranks, mut first) = (0.0, 0);
    for group in sorted.chunk_by(|a, b| a.0 == b.0) {
        let rank = first as f64 + (group.len() as f64 + 1.0) / 2.0;
        ranks += rank * group.iter().filter(|t| t.1).count() as f64;
        first += group.len();
    }
    let least = (positive * (positive + 1)) as f64 / 2.0;
    Some((ranks - least) / (positive * negative) as f64)
}

/// Of what is told to be at least so likely: how many there are, and the share of them that was so.
pub fn accepted(told: &[Told], at_least: f64) -> (usize, Option<f64>) {
    let kept: Vec<&Told> = told.iter().filter(|t| t.0 >= at_least).collect();
    let right = kept.iter().filter(|t| t.1).count() as f64 / kept.len() as f64;
    (kept.len(), (!kept.is_empty()).then_some(right))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_as_often_as_it_is_so_has_no_error() {
        let said = |p: f64, right: usize| (0..10).map(move |i| (p, i < right));
        let fair: Vec<Told> = said(0.75, 8).chain(said(0.25, 2)).collect();
        let told = Calibration::of(&fair);
        assert!((told.ece.unwrap() - 0.05).abs() < 1e-12 && told.count == 20, "{told:?}");
        assert_eq!((told.right, told.bins.len()), (Some(0.5), 2));
        let boast: Vec<Told> = said(1.0, 5).collect();
        assert_eq!(Calibration::of(&boast).ece, Some(0.5));
        assert_eq!(Calibration::of(&[]), Calibration::default());
    }

    #[test]
    fn ranks_say_how_well_right_and_wrong_are_told_apart() {
        let all = [(0.9, true), (0.8, false), (0.7, true), (0.1, false)];
        assert_eq!(Calibration::of(&all).auroc, Some(0.75));
        assert_eq!(Calibration::of(&[(0.5, true), (0.5, false)]).auroc, Some(0.5));
        assert_eq!(Calibration::of(&[(0.5, true)]).auroc, None);
    }

    #[test]
    fn what_is_accepted_is_as_likely_as_asked_or_more() {
        let all = [(0.95, true), (0.9, false), (0.89, true)];
        assert_eq!(accepted(&all, 0.9), (2, Some(0.5)));
        assert_eq!(accepted(&all, 0.99), (0, None));
    }
}
