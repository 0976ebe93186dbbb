//! Slides stay believable: no longer than the part, never out of their guide.

use glamx::DVec3;
use object::{JointKind, JointMotion};

use super::{Clearing, JointId};

/// Longest slide, as a share of the part's length along it; the verdict allows 1.2.
const LONGEST: f64 = 1.15;
/// Share of the part's length that stays beside what it slides in; the verdict asks for 0.05.
const HELD: f64 = 0.07;

impl Clearing<'_> {
    /// Cuts slides that are too long or would leave their guide.
    pub(super) fn clear_slides(&mut self) {
        for joint in self.joint_ids() {
            if self.motion(joint).kind == JointKind::Prismatic {
                self.keep_believable(joint);
                self.keep_held(joint);
            }
        }
    }

    fn keep_believable(&mut self, joint: JointId) {
        let motion = *self.motion(joint);
        let (low, high) = motion.range.ends();
        let longest = LONGEST * self.length(joint.part, &motion);
        if high - low > longest {
            let share = longest / (high - low);
            let why = "a slide is at most 1.15 times as long as its part";
            self.cut_range(joint, low * share, high * share, why);
        }
    }

    fn keep_held(&mut self, joint: JointId) {
        let motion = *self.motion(joint);
        let (low, high) = motion.range.ends();
        let tree = self.object.tree();
        let guides = (0..tree.len()).filter(|&p| !tree.is_under(p, joint.part));
        let spans = guides.filter_map(|p| self.span(p, motion.axis));
        let guide =
            spans.fold((f64::INFINITY, f64::NEG_INFINITY), |g, s| (g.0.min(s.0), g.1.max(s.1)));
        let Some(own) = self.span(joint.part, motion.axis) else { return };
        let held = HELD * (own.1 - own.0);
        let (back, forth) = (guide.0 - own.1 + held, guide.1 - own.0 - held);
        if back > 0.0 || forth < 0.0 {
            return;
        }
        let least = self.least(joint);
        let (back, forth) = (back.min(-least), forth.max(least));
        if low < back || high > forth {
            let why = "a slide stays beside its guide for 7 % of its part's length";
            self.cut_range(joint, low.max(back), high.min(forth), why);
        }
    }

    /// Length of a part's pieces along a joint's axis, metres.
    pub(super) fn length(&self, part: usize, motion: &JointMotion) -> f64 {
        self.span(part, motion.axis).map_or(0.0, |(low, high)| high - low)
    }

    /// Where a part's pieces begin and end along a direction.
    fn span(&self, part: usize, axis: DVec3) -> Option<(f64, f64)> {
        let ends = |(_, p): (usize, &super::scene::Piece)| {
            (-p.solid.support(-axis), p.solid.support(axis))
        };
        let all = self.scene.bodies[part].alive().map(ends);
        all.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}
