//! Clears two joints that move at the same time, over both whole ranges.

use super::meeting::{Closeness, Meeting};
use super::motion::Motion;
use super::scene::Encounter;
use super::{Clearing, HARMLESS, JointId};

/// How two joints hang together, which says whose motion each link makes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Order {
    /// The second is carried by the first.
    SecondOnFirst,
    /// The first is carried by the second.
    FirstOnSecond,
    /// Neither carries the other.
    Apart,
}

/// Absolute joint values of both joints at the corner nearest rest of a rectangle of conflict, and
/// the signs of its quadrant (0 where it touches the axis).
#[derive(Clone, Copy, Debug)]
struct Corner {
    near: [f64; 2],
    sign: [f64; 2],
}

impl Clearing<'_> {
    /// Makes room for all pairs of joints, or cuts the range that loses least.
    pub(super) fn clear_pairs(&mut self) {
        let ids = self.joint_ids();
        for (at, &first) in ids.iter().enumerate() {
            for &second in &ids[at + 1..] {
                self.clear_pair([first, second]);
            }
        }
    }

    fn clear_pair(&mut self, joints: [JointId; 2]) {
        let grain = 2.0 * self.scene.gap;
        let close = Closeness { share: 1.0 / 24.0, grain, ..self.close() };
        let order = self.order(joints);
        let mut meeting = self.pair_encounters(joints, order);
        meeting.retain(|e| !self.scene.conflicts(e, &close).is_empty());
        if meeting.is_empty() {
            return;
        }
        let before = self.scene.clone();
        let corners = self.corners(&meeting, order, &close);
        if self.settle_all(&meeting, &close) <= HARMLESS {
            return;
        }
        if let Some(ranges) = self.best_cut(joints, &corners) {
            self.scene = before;
            let why = "moved together with another joint the parts would meet";
            for (joint, (low, high)) in joints.into_iter().zip(ranges) {
                self.cut_range(joint, low, high, why);
            }
        }
    }

    fn order(&self, [first, second]: [JointId; 2]) -> Order {
        let tree = self.object.tree();
        if tree.is_under(second.part, first.part) {
            Order::SecondOnFirst
        } else if tree.is_under(first.part, second.part) {
            Order::FirstOnSecond
        } else {
            Order::Apart
        }
    }

    /// Links whose place to each other both joints change, seen from where each is moved by one
    /// of them.
    fn pair_encounters(&self, joints: [JointId; 2], order: Order) -> Vec<Encounter> {
        let tree = self.object.tree();
        let [first, second] = joints;
        let (mover, carrier) =
            if order == Order::SecondOnFirst { (second, first) } else { (first, second) };
        let (a, b) = (self.along(mover), self.along(carrier));
        let motion = Meeting { a, b: if order == Order::Apart { b } else { b.reversed() } };
        let moved = (0..tree.len()).filter(|&p| tree.is_under(p, mover.part));
        let is_other = |p: &usize| tree.is_under(*p, carrier.part) == (order == Order::Apart);
        let others: Vec<_> = (0..tree.len()).filter(is_other).collect();
        let pairs = moved.flat_map(|a| others.iter().map(move |&b| [a, b]));
        pairs.map(|links| Encounter { links, motion }).collect()
    }

    fn along(&self, joint: JointId) -> Motion {
        let motion = *self.motion(joint);
        let (low, high) = motion.range.ends();
        Motion::Along(motion, low, high)
    }

    /// Near corners of all rectangles in which the links meet.
    fn corners(&self, meeting: &[Encounter], order: Order, close: &Closeness) -> Vec<Corner> {
        let conflicts = meeting.iter().flat_map(|e| self.scene.conflicts(e, close));
        let rectangles = conflicts.flat_map(|c| c.when);
        rectangles.map(|when| corner(&when, order)).collect()
    }

    /// The ranges of both joints that avoid all rectangles of conflict and lose least; `None` if
    /// that cannot be without cutting a range to nothing.
    fn best_cut(&self, joints: [JointId; 2], corners: &[Corner]) -> Option<[(f64, f64); 2]> {
        let mut ranges = joints.map(|j| self.motion(j).range.ends());
        for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let here = corners.iter().filter(|c| (0..2).all(|k| c.sign[k] * signs[k] >= 0.0));
            let here: Vec<_> = here.map(|c| c.near).collect();
            let limit = |k: usize| if signs[k] > 0.0 { ranges[k].1 } else { -ranges[k].0 };
            let keeps = |k: usize| self.keeps(joints[k])[usize::from(signs[k] > 0.0)];
            let keeps = [keeps(0), keeps(1)];
            let limits = self.best_step(joints, ([limit(0), limit(1)], keeps), &here)?;
            for k in 0..2 {
                let end = if signs[k] > 0.0 { &mut ranges[k].1 } else { &mut ranges[k].0 };
                *end = signs[k] * limits[k];
            }
        }
        Some(ranges)
    }

    /// Limits of one quadrant below which no corner lies: a staircase has as many candidates as
    /// corners. Those that are kept stay.
    fn best_step(
        &self,
        joints: [JointId; 2],
        (limits, keeps): ([f64; 2], [bool; 2]),
        corners: &[[f64; 2]],
    ) -> Option<[f64; 2]> {
        let spans = joints.map(|j| self.motion(j).range.span().max(f64::MIN_POSITIVE));
        let least = joints.map(|j| if self.is_endless(j) { f64::INFINITY } else { self.least(j) });
        let inside = |c: &&[f64; 2]| c[0] < limits[0] && c[1] < limits[1];
        let corners: Vec<_> = corners.iter().filter(inside).copied().collect();
        let firsts = corners.iter().map(|c| c[0]).filter(|&c| c >= least[0] && !keeps[0]);
        let stairs = stairs(&corners, limits[1]);
        let step = |first: f64| {
            let second = stairs[stairs.partition_point(|s| s[0] < first) - 1][1];
            let lost = (limits[0] - first) / spans[0] + (limits[1] - second) / spans[1];
            let may = second >= least[1] && !keeps[1];
            (second == limits[1] || may).then_some((lost, [first, second]))
        };
        let steps = firsts.chain([limits[0]]).filter_map(step);
        steps.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, limits)| limits)
    }
}

/// Corners by their first value, each with the least second value up to it; before them all `most`.
fn stairs(corners: &[[f64; 2]], most: f64) -> Vec<[f64; 2]> {
    let mut sorted = corners.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut stairs = vec![[f64::NEG_INFINITY, most]];
    let mut least = most;
    for [first, second] in sorted {
        least = least.min(second);
        stairs.push([first, least]);
    }
    stairs
}

fn corner(when: &Meeting, order: Order) -> Corner {
    let (a, b) = (when.a.ends(), when.b.ends());
    let ends = match order {
        Order::SecondOnFirst => [(-b.1, -b.0), a],
        Order::FirstOnSecond => [a, (-b.1, -b.0)],
        Order::Apart => [a, b],
    };
    let near = |(low, high): (f64, f64)| if low > 0.0 { low } else { high.min(0.0) };
    let near = ends.map(near);
    Corner { near: near.map(f64::abs), sign: near.map(|n| if n == 0.0 { 0.0 } else { n.signum() }) }
}
