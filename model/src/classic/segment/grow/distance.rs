//! How far each segment is from each prompt, over the links between segments.

use crate::classic::segment::grow::merge::Link;
use crate::classic::segment::oversegment::flood::{around, costs_from};
use crate::classic::segment::oversegment::segments::Segment;

/// Longest way that counts; what cannot be reached is this far.
const FARTHEST: f64 = 50.0;
/// Ways shorter than this are as good as each other.
const NEAREST: f64 = 0.05;

/// For each segment and each of `labels` labels, ln of the cheapest way over the links' barriers from
/// the label's seed without passing another seed.
pub(crate) fn far(segments: &[Segment], links: &[Link], labels: usize) -> Vec<Vec<f64>> {
    let ways: Vec<_> = links.iter().map(|l| (l.a, l.b, l.barrier.max(0.0))).collect();
    let around = around(segments.len(), &ways);
    let mut far = vec![vec![FARTHEST.ln(); labels]; segments.len()];
    for (start, segment) in segments.iter().enumerate() {
        let Some(label) = segment.seed else { continue };
        let seeded = |n: u32| segments[n as usize].seed.is_some();
        for (row, cost) in far.iter_mut().zip(costs_from(&around, &[start as u32], seeded)) {
            let way = &mut row[usize::from(label)];
            *way = way.min((cost.min(FARTHEST) + NEAREST).ln());
        }
    }
    far
}
