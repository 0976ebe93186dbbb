//! How far each piece is from each prompt, over the links between pieces.

use super::flood::{around, costs_from};
use super::merge::Link;
use super::pieces::Piece;

/// Longest way that counts; what cannot be reached is this far.
const FARTHEST: f64 = 50.0;
/// Ways shorter than this are as good as each other.
const NEAREST: f64 = 0.05;

/// For each piece and each of `labels` labels, ln of the cheapest way over the links' barriers from
/// the label's seed without passing another seed.
pub(super) fn far(pieces: &[Piece], links: &[Link], labels: usize) -> Vec<Vec<f64>> {
    let ways: Vec<_> = links.iter().map(|l| (l.a, l.b, l.barrier.max(0.0))).collect();
    let around = around(pieces.len(), &ways);
    let mut far = vec![vec![FARTHEST.ln(); labels]; pieces.len()];
    for (start, piece) in pieces.iter().enumerate() {
        let Some(label) = piece.seed else { continue };
        let seeded = |n: u32| pieces[n as usize].seed.is_some();
        for (row, cost) in far.iter_mut().zip(costs_from(&around, start as u32, seeded)) {
            let way = &mut row[usize::from(label)];
            *way = way.min((cost.min(FARTHEST) + NEAREST).ln());
        }
    }
    far
}
