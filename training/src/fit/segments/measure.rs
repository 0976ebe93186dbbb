//! How good labels are, and how much each segment counts.

use std::collections::BTreeMap;

use model::classic::segment::classify::Probabilities;
use object::DVec3;
use object::mesh::Bounds;

use super::super::Watcher;
use super::case::Case;
use super::iou::mean_iou;

/// Nothing surprises more than what has this probability.
pub(super) const UNLIKELY: f64 = 1e-3;

/// Of each object as it was first seen with points in the middle, and anywhere: the mean over all, that of
/// boxes, the negative log-likelihood of the truth, and on how many the mean is more or less than by
/// merging. Gives the mean of either, where there is any.
pub(super) fn report(
    watcher: &dyn Watcher,
    what: &str,
    cases: &[Case],
    iou: impl Fn(&Case) -> f64,
) -> [Option<f64>; 2] {
    [(0, ""), (1, ", points anywhere")].map(|(draw, how)| {
        let cases: Vec<&Case> = cases.iter().filter(|c| c.draw == draw).collect();
        if cases.is_empty() {
            return None;
        }
        let count = cases.len() as f64;
        let mean = |of: &dyn Fn(&Case) -> f64| cases.iter().map(|c| of(c)).sum::<f64>() / count;
        let (found, boxes, loss) = (mean(&iou), mean(&box_iou), mean(&negative_log_likelihood));
        let better = cases.iter().filter(|c| iou(c) > c.merged + 1e-9).count();
        let worse = cases.iter().filter(|c| iou(c) < c.merged - 1e-9).count();
        watcher.say(&format!(
            "{what}{how}: {found:.4} boxes {boxes:.4} loss {loss:.4} ({count}; {better} better, \
             {worse} worse)"
        ));
        Some(found)
    })
}

/// Mean IoU over parts if every segment goes to the likeliest part.
pub(super) fn iou(case: &Case) -> f64 {
    iou_of(case, &case.probabilities)
}

/// The same for other probabilities than the case's own.
pub(super) fn iou_of(case: &Case, probabilities: &Probabilities) -> f64 {
    let mut crossed = vec![vec![0.0; case.parts]; case.parts];
    for (votes, row) in case.votes.iter().zip(probabilities) {
        let best = likeliest(row);
        votes.iter().for_each(|(&truth, area)| crossed[truth][best] += area);
    }
    mean_iou(&crossed)
}

/// Mean IoU over parts of two boxes: that of the segments of which the part is the likeliest, and that of
/// the segments most of which are the part's.
fn box_iou(case: &Case) -> f64 {
    let boxes = |part_of: &dyn Fn(usize) -> usize| {
        let mut boxes = vec![Bounds::of([]); case.parts];
        for segment in 0..case.layout.len() {
            let (whole, own) = (&mut boxes[part_of(segment)], case.layout.bounds(segment));
            *whole = Bounds { min: whole.min.min(own.min), max: whole.max.max(own.max) };
        }
        boxes
    };
    let found = boxes(&|segment| likeliest(&case.probabilities[segment]));
    let right = boxes(&|segment| most(&case.votes[segment]));
    let volume = |b: &Bounds| (b.max - b.min).max(DVec3::ZERO).element_product();
    let one = |(a, b): (&Bounds, &Bounds)| {
        let both = volume(&Bounds { min: a.min.max(b.min), max: a.max.min(b.max) });
        both / (volume(a) + volume(b) - both).max(f64::MIN_POSITIVE)
    };
    found.iter().zip(&right).map(one).sum::<f64>() / case.parts as f64
}

/// The likeliest part.
fn likeliest(row: &[f32]) -> usize {
    row.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |b| b.0)
}

/// The part that most of a segment is of.
fn most(votes: &BTreeMap<usize, f64>) -> usize {
    votes.iter().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |m| *m.0)
}

/// The part that each segment shares most with, and how much the segment counts: by the root of its area,
/// half an object's weight going to all segments together, half to its parts alike.
pub(super) fn counted(case: &Case) -> Vec<(usize, f64)> {
    let truth: Vec<usize> = case.votes.iter().map(most).collect();
    let size = |segment: usize| case.layout.share(segment).sqrt();
    let all = (0..truth.len()).map(size).sum::<f64>().max(f64::MIN_POSITIVE);
    let mut sizes = vec![1e-9; case.parts];
    truth.iter().enumerate().for_each(|(i, &t)| sizes[t] += size(i));
    let weight = |(segment, &t): (usize, &usize)| {
        (t, size(segment) * (0.5 / all + 0.5 / (sizes[t] * case.parts as f64)))
    };
    truth.iter().enumerate().map(weight).collect()
}

/// Mean negative log-likelihood of the truth, by how much segments count.
fn negative_log_likelihood(case: &Case) -> f64 {
    let (mut sum, mut all) = (0.0, 0.0);
    for ((truth, weight), row) in counted(case).into_iter().zip(&case.probabilities) {
        sum -= weight * f64::from(row[truth]).max(UNLIKELY).ln();
        all += weight;
    }
    sum / all.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_iou_is_over_parts_alike() {
        let crossed = [vec![3.0, 1.0], vec![0.0, 4.0]];
        assert!((mean_iou(&crossed) - (3.0 / 4.0 + 4.0 / 5.0) / 2.0).abs() < 1e-12);
        assert_eq!(mean_iou(&[vec![2.0, 0.0], vec![0.0, 0.5]]), 1.0);
    }

    #[test]
    fn the_most_of_a_segment_and_the_likeliest_part_win() {
        assert_eq!(most(&BTreeMap::from([(0, 0.2), (2, 0.5), (3, 0.1)])), 2);
        assert_eq!((likeliest(&[0.1, 0.7, 0.2]), likeliest(&[])), (1, 0));
    }
}
