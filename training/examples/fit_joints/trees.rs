//! Grows the forests that choose joint axes: one for each voice, on all joints but those of one share of
//! the objects.

use model::geometric::forest::Forest;
use model::geometric::score::{NUMBERS, VOICES};
use training::forest::{Bins, Growth, Lessons};

use super::Joint;

/// Objects fall into so many shares: voice `v` leaves out number `v % SHARES`, so that several voices know
/// the same objects and differ by their seeds.
pub(super) const SHARES: usize = 3;
/// Bins are chosen by every so many joints.
const SAMPLED: usize = 4;
/// How often the loss is told while a forest grows.
const TOLD: usize = 4;
/// How a forest grows where the command line says nothing else.
pub(super) const GROWTH: Growth = Growth {
    trees: 200,
    leaves: 31,
    rate: 0.06,
    questions: 0.6,
    numbers: 0.4,
    curve: 4.0,
    hold: 5.0,
    seed: 7,
};

/// A forest for each voice.
pub(super) fn grown(joints: &[&Joint], growth: &Growth) -> Vec<Forest<NUMBERS>> {
    let bins = Bins::of(joints.iter().step_by(SAMPLED).flat_map(|j| &j.asked.numbers));
    let mut lessons = Lessons::new(&bins);
    joints.iter().for_each(|j| lessons.add(std::slice::from_ref(&j.asked)));
    let grow = |voice: usize| {
        let growth = Growth { seed: growth.seed + voice as u64, ..*growth };
        let knows = |joint: usize| joints[joint].share != voice % SHARES && joints[joint].is_told();
        lessons.grow(&growth, knows, |trees, loss| {
            if trees % (growth.trees / TOLD).max(1) == 0 {
                eprintln!("  {trees} trees: loss {loss:.4}");
            }
        })
    };
    (0..VOICES).map(grow).collect()
}
