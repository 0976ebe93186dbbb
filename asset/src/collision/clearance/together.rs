//! All joints at random values at once, for links with three or more joints between them.

use std::ops::Range;

use glamx::DPose3;
use object::Configuration;
use object::pose::part_poses;
use rayon::prelude::*;

use super::meeting::Meeting;
use super::motion::Motion;
use super::scene::Encounter;
use super::{Clearing, HARMLESS, JointId};

/// Configurations tried in a round.
const TRIED: u64 = 512;
/// Most rounds; one without a conflict ends them.
const ROUNDS: usize = 8;
/// A range is cut to this share of the value at which parts met.
const SHORTER: f64 = 0.96;

impl Clearing<'_> {
    /// Makes room, or cuts a range, wherever random configurations make parts meet.
    pub(super) fn clear_together(&mut self) {
        let pairs = self.far_pairs();
        if pairs.is_empty() {
            return;
        }
        for round in 0..ROUNDS as u64 {
            let (mut next, end) = (round * TRIED, (round + 1) * TRIED);
            let mut met = false;
            while let Some(number) = self.first_met(next..end, &pairs) {
                self.clear_at(number, &pairs);
                (met, next) = (true, number + 1);
            }
            if !met {
                break;
            }
        }
    }

    /// The first of some random configurations in which parts meet.
    fn first_met(&self, numbers: Range<u64>, pairs: &[([usize; 2], Vec<JointId>)]) -> Option<u64> {
        let meets = |number: &u64| {
            let poses = part_poses(self.object, &self.random_configuration(*number));
            let close = self.close();
            pairs
                .iter()
                .any(|(links, _)| !self.scene.conflicts(&placed(*links, &poses), &close).is_empty())
        };
        numbers.into_par_iter().find_first(meets)
    }

    /// Pairs of links with three or more joints between them.
    fn far_pairs(&self) -> Vec<([usize; 2], Vec<JointId>)> {
        let links = self.object.tree().len();
        let pairs = (0..links).flat_map(|a| (a + 1..links).map(move |b| [a, b]));
        pairs.map(|links| (links, self.between(links))).filter(|(_, j)| j.len() > 2).collect()
    }

    /// Joints that move one of two links and not the other.
    fn between(&self, [a, b]: [usize; 2]) -> Vec<JointId> {
        let tree = self.object.tree();
        let parts_them = |j: &JointId| tree.is_under(a, j.part) != tree.is_under(b, j.part);
        self.joint_ids().into_iter().filter(parts_them).collect()
    }
}

impl Clearing<'_> {
    /// Makes room in one random configuration, or cuts a range.
    fn clear_at(&mut self, number: u64, pairs: &[([usize; 2], Vec<JointId>)]) {
        let q = self.random_configuration(number);
        let poses = part_poses(self.object, &q);
        for (links, joints) in pairs {
            let encounter = placed(*links, &poses);
            if self.scene.conflicts(&encounter, &self.close()).is_empty() {
                continue;
            }
            let before = self.scene.clone();
            if self.settle_all(&[encounter], &self.close()) <= HARMLESS {
                continue;
            }
            if let Some((joint, low, high)) = self.cheapest_cut(&q, joints) {
                self.scene = before;
                let why = "moved together with other joints the parts would meet";
                self.cut_range(joint, low, high, why);
                break;
            }
        }
    }

    /// The joint whose range loses least by leaving out its value in `q`, and what is left of it.
    fn cheapest_cut(&self, q: &Configuration, joints: &[JointId]) -> Option<(JointId, f64, f64)> {
        let cut = |&joint: &JointId| {
            let value = q.0[joint.part][joint.index] * SHORTER;
            let (low, high) = self.motion(joint).range.ends();
            let (lost, range) = if value > 0.0 {
                (high - value, (low, value))
            } else {
                (value - low, (value, high))
            };
            let keeps = self.keeps(joint)[usize::from(value > 0.0)];
            let allowed = !self.is_endless(joint) && !keeps && value.abs() > self.least(joint);
            allowed.then_some((lost / (high - low), (joint, range.0, range.1)))
        };
        joints.iter().filter_map(cut).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, cut)| cut)
    }

    fn random_configuration(&self, number: u64) -> Configuration {
        let mut state = self.options.seed ^ number.wrapping_mul(0xD1B5_4A32_D192_ED03);
        let mut draw = |m: &object::JointMotion| {
            let (low, high) = m.range.ends();
            let share = next_share(&mut state);
            let share = if number % 2 == 1 { toward_ends(share) } else { share };
            low + (high - low) * share
        };
        Configuration(self.joints.iter().map(|js| js.iter().map(&mut draw).collect()).collect())
    }
}

/// Two links as these poses of all parts place them.
fn placed(links: [usize; 2], poses: &[DPose3]) -> Encounter {
    let [a, b] = links.map(|l| poses[l]);
    Encounter { links, motion: Meeting { a: Motion::Placed(b.inverse() * a), b: Motion::Still } }
}

/// A third of the shares at each end, for parts meet there most.
fn toward_ends(share: f64) -> f64 {
    (3.0 * share - 1.0).clamp(0.0, 1.0)
}

/// The next of a sequence of numbers in [0, 1) (SplitMix64, Steele et al. 2014).
fn next_share(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
