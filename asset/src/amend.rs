//! Changes to a finished asset that a verdict of the checks asked for, each on record.

use object::{Origin, Sourced};

use crate::asset::Asset;
use crate::change::Change;
use crate::joints::drive::RESERVE;

/// A change to one joint's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amendment {
    /// Another range within the one it has: lower and upper end, radians or metres.
    Range([f64; 2]),
    /// The axis turned round: what opened one way opens the other.
    Flip,
}

impl Asset {
    /// The asset with one joint amended; `before` and `after` say how the verdict changed, `why`
    /// names the rule. `None` where no joint with limits has that name, where the range is none that
    /// holds rest, and where what would change was given by a person.
    #[must_use]
    pub fn amended(
        &self,
        joint: &str,
        amendment: Amendment,
        [before, after]: [&str; 2],
        why: &str,
    ) -> Option<Self> {
        let mut amended = self.clone();
        let number = amended.joints.iter().position(|j| j.name == joint)?;
        let of = amended.joints.get_mut(number)?;
        let part = self.links.get(of.child)?.name.clone();
        let motion = of.motion.as_mut()?;
        let limits = motion.limits.as_mut()?;
        let is_given = |origin: Origin| origin == Origin::User;
        let shown = |[l, u]: [f64; 2]| format!("{l:.4} to {u:.4}");
        let (what, was, now) = match amendment {
            // Ends that were given are given about an axis that points as it does.
            Amendment::Flip if is_given(motion.axis.origin) => return None,
            Amendment::Flip if limits.iter().any(|end| is_given(end.origin)) => return None,
            Amendment::Flip => {
                let axis = motion.axis.value;
                motion.axis = Sourced::new(-axis, Origin::Measured, "turned round: free that way");
                ("axis", format!("{axis:.4}"), format!("{:.4}", -axis))
            }
            Amendment::Range(range) => {
                let [lower, upper] = range;
                if !(lower <= 0.0 && upper >= 0.0 && lower < upper) {
                    return None;
                }
                let was = [limits[0].value, limits[1].value];
                let changes = |k: usize| is_given(limits[k].origin) && range[k] != was[k];
                if changes(0) || changes(1) {
                    return None;
                }
                for (limit, end) in limits.iter_mut().zip(range).filter(|(l, end)| l.value != *end)
                {
                    *limit = Sourced::new(end, Origin::Measured, "free of contact");
                }
                ("range", shown(was), shown(range))
            }
        };
        let change = |of: String, verdict: &str| format!("{of} (verdict: {verdict})");
        let (before, after) = (change(was, before), change(now, after));
        amended.changes.push(Change::new(&part, what, before, after, why));
        if amendment == Amendment::Flip {
            amended.note_flipped(number);
        }
        Some(amended)
    }

    /// The asset with every joint held `times` as firmly by its friction, and its drive stronger by what
    /// that takes; `before` and `after` say how the verdict changed, `why` names the rule.
    #[must_use]
    pub fn firmer(&self, times: f64, [before, after]: [&str; 2], why: &str) -> Self {
        let mut firmer = self.clone();
        for motion in firmer.joints.iter_mut().filter_map(|j| j.motion.as_mut()) {
            let more = motion.friction.value * (times - 1.0);
            motion.friction.value += more;
            motion.friction.how.push_str(&format!("; {times} times that: {why}"));
            if motion.effort.origin != Origin::User {
                motion.effort.value += RESERVE * more;
                motion.effort.how.push_str(&format!("; with {times} times the friction"));
            }
        }
        let before = format!("as gravity asks for (verdict: {before})");
        let after = format!("{times} times that (verdict: {after})");
        firmer.changes.push(Change::new("", "friction", before, after, why));
        firmer
    }
}
