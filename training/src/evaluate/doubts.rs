//! What the checks of group R would flag of an articulation, and whether what is flagged is wrong.
//!
//! Of an asset, `sim_check` reads the same numbers from its files; here they are asked before anything is built.

use model::Articulation;
use object::confidence::PartConfidence;
use object::{JointKind, JointMotion, Mesh};

use super::outcome::Outcome;
use crate::metrics::{JointComparison, Link};

/// R1 to R3: what is less likely right is doubtful. The profile's of checks, as are all of these.
pub const SURE: f64 = 0.5;
/// R4: class probability from which a piece may be another part's.
pub const STRAY: f64 = 0.35;
/// R4: share of its part from which a piece matters.
pub const PIECE: f64 = 0.05;
/// R4: a part that is likelier right keeps its pieces.
pub const UNSURE: f64 = 0.6;
/// R5: how far from the nearer end of its range a joint is that is shown neither shut nor in the middle, shares
/// of the range.
pub const AJAR: (f64, f64) = (0.05, 0.2);
/// What is shown open leads back if its range takes it at least this share of the true way. A guess: half shut
/// is still the way to shut.
const BACK: f64 = 0.5;

/// What is doubtful about a part by its probabilities, check by check (R1 to R4), such as `R1 0.42`.
pub fn flags(sure: &PartConfidence) -> Vec<String> {
    let mut all = Vec::new();
    if sure.labels < SURE {
        all.push(format!("R1 {:.2}", sure.labels));
    }
    for joint in &sure.joints {
        let axis = joint.line.map_or(joint.axis, |line| line.min(joint.axis));
        if axis < SURE {
            all.push(format!("R2 {axis:.2}"));
        }
        if let Some(way) = joint.way.filter(|way| *way < SURE) {
            all.push(format!("R3 {way:.2}"));
        }
    }
    let is_unsure = sure.labels < UNSURE;
    let stray = sure.doubt.filter(|d| is_unsure && d.share >= PIECE && d.chance >= STRAY);
    all.extend(stray.map(|doubt| format!("R4 {:.2} of {:.2}", doubt.chance, doubt.share)));
    all
}

/// R5: joints that are shown ajar, such as `R5 0.12`.
pub fn shown(joints: &[JointMotion]) -> Vec<String> {
    let place = |joint: &JointMotion| {
        let (lower, upper) = joint.range.ends();
        let (span, is_endless) = (upper - lower, joint.kind == JointKind::Continuous);
        let place = ((-lower).min(upper) / span).max(0.0);
        (!is_endless && span > 0.0 && (AJAR.0..AJAR.1).contains(&place)).then_some(place)
    };
    joints.iter().filter_map(place).map(|place| format!("R5 {place:.2}")).collect()
}

/// What became of one part of the condition.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedPart {
    /// Whether its surface or one of its joints is wrong.
    pub is_wrong: bool,
    /// What R1 to R4 flag; nothing of a part that got no face.
    pub flags: Vec<String>,
    /// What R5 flags.
    pub shown: Vec<String>,
}

impl JudgedPart {
    /// Whether any check flags it.
    pub fn is_flagged(&self) -> bool {
        !self.flags.is_empty() || !self.shown.is_empty()
    }
}

/// An answer beside the truth, part by part.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// Surfaces and joints.
    pub outcome: Outcome,
    /// One for each part of the condition.
    pub parts: Vec<JudgedPart>,
}

impl Judged {
    /// Of a mesh, the true part of each face, and its true joints. With `leads_back`, a joint that truly goes
    /// some way below where it is shown must go at least half of that.
    pub fn of(truth: (&Mesh, &[u16], &[Link]), made: &Articulation, leads_back: bool) -> Self {
        let outcome = Outcome::of(truth, made);
        let part = |(place, part): (usize, &Option<usize>)| {
            let joints = outcome.joints.iter().filter(|j| usize::from(j.part) == place);
            let is_joint_wrong =
                |joint: &JointComparison| !joint.is_right() || (leads_back && !is_led_back(joint));
            let is_wrong = !outcome.is_part_right(place) || joints.into_iter().any(is_joint_wrong);
            let sure = part.and_then(|part| made.confidence.as_ref()?.parts.get(part));
            JudgedPart {
                is_wrong,
                flags: sure.map(flags).unwrap_or_default(),
                shown: part.map(|part| shown(made.object.joints(part))).unwrap_or_default(),
            }
        };
        let parts = made.part_of_condition.iter().enumerate().map(part).collect();
        Self { outcome, parts }
    }

    /// Whether every part is.
    pub fn is_right(&self) -> bool {
        self.parts.iter().all(|part| !part.is_wrong)
    }

    /// Whether any part is flagged.
    pub fn is_flagged(&self) -> bool {
        self.parts.iter().any(JudgedPart::is_flagged)
    }

    /// What is flagged of a part of the condition, how sure its surface is, and what became of it, in a line.
    pub fn told(&self, place: usize, made: &Articulation) -> String {
        let joints = self.outcome.joints.iter().filter(|j| usize::from(j.part) == place);
        let joint = |j: &JointComparison| {
            let (angle, line) = (j.angle.unwrap_or(90.0), j.line.unwrap_or(0.0));
            format!("{angle:.0}° {line:.2} {:?}", j.opening)
        };
        let joints: Vec<String> = joints.map(joint).collect();
        let iou = self.outcome.ious.get(place).copied().unwrap_or_default();
        let found = made.part_of_condition.get(place).copied().flatten();
        let sure = found.and_then(|part| made.confidence.as_ref()?.parts.get(part));
        let labels = sure.map_or("none".into(), |sure| format!("{:.2}", sure.labels));
        let flags = self.parts.get(place).map(|part| [&part.flags[..], &part.shown[..]].concat());
        let flags = flags.unwrap_or_default();
        format!("flagged {flags:?}, {labels}, IoU {iou:.2}, joints {joints:?}")
    }

    /// Whether a part is flagged that is wrong.
    pub fn is_flagged_where_wrong(&self) -> bool {
        self.parts.iter().any(|part| part.is_wrong && part.is_flagged())
    }
}

/// Whether a joint goes at least half of the true way down from where it is shown.
fn is_led_back(joint: &JointComparison) -> bool {
    let [lower, _] = joint.true_ends;
    joint.kind == JointKind::Continuous
        || joint.ends.is_some_and(|[found, _]| found <= BACK * lower)
}

#[cfg(test)]
mod tests {
    use object::{DVec3, Range};

    use super::*;

    #[test]
    fn what_is_shown_a_little_open_is_flagged_and_what_is_shut_or_half_open_is_not() {
        let joint = |lower, upper| JointMotion {
            kind: JointKind::Revolute,
            axis: DVec3::Z,
            pivot: DVec3::ZERO,
            range: Range::Limits { lower, upper },
        };
        let told = |lower, upper| shown(&[joint(lower, upper)]);
        assert_eq!(told(-0.1, 0.9), ["R5 0.10"]);
        assert!(told(0.0, 1.0).is_empty() && told(-0.5, 0.5).is_empty());
        assert!(told(-1.0, 0.0).is_empty());
    }
}
