//! Clears one joint at a time: makes room for its whole range, or cuts the range to the room there
//! is.

use object::{JointKind, JointMotion, Range};

use super::meeting::{Closeness, Meeting};
use super::motion::Motion;
use super::scene::Encounter;
use super::{Clearing, HARMLESS, JointId};

/// Shares of a blocked side of a range that are tried, largest first.
const SHARES: [f64; 9] = [1.0, 0.9, 0.75, 0.6, 0.45, 0.3, 0.2, 0.1, 0.05];

impl Clearing<'_> {
    /// Makes room for every joint alone, the others at rest.
    pub(super) fn clear_each_joint(&mut self) {
        for joint in self.joint_ids() {
            self.clear_joint(joint);
        }
    }

    fn clear_joint(&mut self, joint: JointId) {
        let (low, high) = self.motion(joint).range.ends();
        let before = self.scene.clone();
        if self.sweep(joint, low, high) <= HARMLESS || self.is_endless(joint) {
            return;
        }
        self.scene = before;
        let least = self.least(joint);
        let (mut low_now, mut high_now) = (low.max(-least), high.min(least));
        self.sweep(joint, low_now, high_now);
        high_now = self.widest(joint, (high_now, high), |q| (low_now, q));
        low_now = self.widest(joint, (low_now, low), |q| (q, high_now));
        self.cut_range(joint, low_now, high_now, "the way beyond is blocked by other parts");
    }

    /// The value nearest `far` up to which carving is harmless; room is made for it.
    fn widest(
        &mut self,
        joint: JointId,
        (near, far): (f64, f64),
        range: impl Fn(f64) -> (f64, f64),
    ) -> f64 {
        if near == far {
            return near;
        }
        let free = self.free_until(joint, near, far);
        let shares = SHARES.iter().map(|s| near + (far - near) * s);
        let farther = shares.filter(|q| (q - near).abs() > (free - near).abs());
        for q in farther.collect::<Vec<_>>() {
            let before = self.scene.clone();
            let (low, high) = range(q);
            if self.sweep(joint, low, high) <= HARMLESS {
                return q;
            }
            self.scene = before;
        }
        free
    }

    /// How far from `near` towards `far` the joint goes before anything comes too close.
    fn free_until(&self, joint: JointId, near: f64, far: f64) -> f64 {
        let meeting = self.alone(joint, near.min(far), near.max(far));
        let mut free = far;
        for encounter in self.encounters(joint, meeting) {
            for conflict in self.scene.conflicts(&encounter, &self.close()) {
                for when in conflict.when {
                    let (low, high) = when.a.ends();
                    free = if far > near { free.min(low) } else { free.max(high) };
                }
            }
        }
        if far > near { free.max(near) } else { free.min(near) }
    }

    /// Makes room for a joint between two values, whatever it costs; the largest share of samples
    /// that this uncovers on any link, 1 more if some conflict stays.
    pub(super) fn sweep(&mut self, joint: JointId, low: f64, high: f64) -> f64 {
        let meeting = self.alone(joint, low, high);
        let encounters = self.encounters(joint, meeting);
        self.settle_all(&encounters, &self.close())
    }

    /// [`super::scene::Scene::settle`] for several pairs, and the harm done.
    pub(super) fn settle_all(&mut self, encounters: &[Encounter], close: &Closeness) -> f64 {
        let before: Vec<f64> = self.scene.bodies.iter().map(|b| b.uncovered()).collect();
        let mut settled = true;
        for encounter in encounters {
            settled &= self.scene.settle(encounter, close);
        }
        let after = self.scene.bodies.iter().map(|b| b.uncovered());
        let harm = after.zip(before).map(|(a, b)| a - b).fold(0.0, f64::max);
        if settled { harm } else { 1.0 + harm }
    }

    fn alone(&self, joint: JointId, low: f64, high: f64) -> Meeting {
        Meeting { a: Motion::Along(*self.motion(joint), low, high), b: Motion::Still }
    }

    /// What moves with the joint against everything else.
    fn encounters(&self, joint: JointId, motion: Meeting) -> Vec<Encounter> {
        let tree = self.object.tree();
        let (moving, rest): (Vec<_>, Vec<_>) =
            (0..tree.len()).partition(|&p| tree.is_under(p, joint.part));
        let pairs = moving.iter().flat_map(|&a| rest.iter().map(move |&b| [a, b]));
        pairs.map(|links| Encounter { links, motion }).collect()
    }

    pub(super) fn close(&self) -> Closeness {
        Closeness { gap: 0.8 * self.scene.gap, share: 1.0 / 64.0, grain: 0.25 * self.scene.gap }
    }

    pub(super) fn is_endless(&self, joint: JointId) -> bool {
        self.motion(joint).kind == JointKind::Continuous
    }

    /// The least a side of a range is cut to: 2 degrees, or 2 % of the part along the axis.
    pub(super) fn least(&self, joint: JointId) -> f64 {
        let motion: &JointMotion = self.motion(joint);
        if motion.kind.turns() { 2f64.to_radians() } else { 0.02 * self.length(joint.part, motion) }
    }

    /// Narrows a range and writes down why.
    pub(super) fn cut_range(&mut self, joint: JointId, low: f64, high: f64, why: &str) {
        let [keeps_low, keeps_high] = self.keeps(joint);
        let motion = &mut self.joints[joint.part][joint.index];
        let (old_low, old_high) = motion.range.ends();
        let low = if keeps_low { old_low } else { low };
        let high = if keeps_high { old_high } else { high };
        if (low, high) == (old_low, old_high) || motion.kind == JointKind::Continuous {
            return;
        }
        motion.range = Range::Limits { lower: low.min(0.0), upper: high.max(0.0) };
        let unit = if motion.kind.turns() { "rad" } else { "m" };
        let text = |low: f64, high: f64| format!("{low:.4} to {high:.4} {unit}");
        self.note(joint.part, "range", text(old_low, old_high), text(low, high), why);
    }
}
