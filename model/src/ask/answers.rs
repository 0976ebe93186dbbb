//! What an answer changes: of the part that is asked about, and of those it holds for as well.

use object::condition::GivenJoint;
use object::{ArticulatedObject, Condition, DVec3, JointMotion, Range};

use super::siblings::{like, opened};
use super::types::{About, Answer, Change, Question, Told};
use crate::articulate::Articulation;

impl Question {
    /// What an answer changes: of the part that is asked about, then of those it holds for as well, unless
    /// `alone`. Nothing where it is no answer to this question.
    pub fn changes(&self, made: &Articulation, (answer, alone): (Answer, bool)) -> Vec<Change> {
        let told = match (self.about, answer) {
            (About::Piece(at), Answer::Is(part)) => Change { part, told: Told::Point(at) },
            (About::Axis(joint) | About::Way(joint), Answer::Axis(axis, pivot)) => {
                of_joint((self.part, joint), (axis, pivot), None)
            }
            (About::Axis(joint) | About::Way(joint), Answer::Opens(axis, pivot, range)) => {
                of_joint((self.part, joint), (axis, pivot), Some(range))
            }
            _ => return Vec::new(),
        };
        if alone {
            return vec![told];
        }
        let of_siblings = self.also.iter().filter_map(|s| self.of_sibling(made, answer, *s));
        std::iter::once(told).chain(of_siblings).collect()
    }

    /// What an answer changes of a sibling of the part; none where it says nothing of it.
    pub(super) fn of_sibling(
        &self,
        made: &Articulation,
        answer: Answer,
        sibling: usize,
    ) -> Option<Change> {
        let confidence = made.confidence.as_ref()?;
        let (line, range) = match (self.about, answer) {
            (About::Piece(_), Answer::Is(part)) => {
                let own = confidence.parts.get(self.part)?.doubt.as_ref()?;
                let doubt = confidence
                    .parts
                    .get(sibling)?
                    .doubt
                    .as_ref()
                    .filter(|d| d.other == own.other)?;
                let part = if part == self.part { sibling } else { doubt.other };
                return Some(Change { part, told: Told::Point(doubt.at) });
            }
            (_, Answer::Axis(axis, pivot)) => ((axis, pivot), None),
            (_, Answer::Opens(axis, pivot, range)) => ((axis, pivot), Some(range)),
            _ => return None,
        };
        let (About::Axis(joint) | About::Way(joint)) = self.about else { return None };
        let sure = confidence.parts.get(sibling)?.joints.get(joint)?;
        // What a person gave is certain, and stays.
        if sure.axis >= 1.0 || range.is_some() && sure.way.is_none_or(|way| way >= 1.0) {
            return None;
        }
        let found = *made.object.joints(self.part).get(joint)?;
        let like = like((found, line), *made.object.joints(sibling).get(joint)?, sure.instead)?;
        let own = JointMotion { axis: line.0, pivot: line.1, ..found };
        let range = match range {
            Some(range) => Some(opened(&made.object, [(self.part, own), (sibling, like)], range)?),
            None => None,
        };
        Some(of_joint((sibling, joint), (like.axis, like.pivot), range))
    }

    /// The condition with an answer in it, as [`Self::changes`] has it; `metres` is how long a unit of the mesh
    /// is in the finished object.
    #[must_use]
    pub fn answered(
        &self,
        condition: &Condition,
        made: &Articulation,
        (answer, alone, metres): (Answer, bool, f64),
    ) -> Condition {
        let mut told = condition.clone();
        for change in self.changes(made, (answer, alone)) {
            change.tell(&mut told, made, metres);
        }
        told
    }
}

fn of_joint(
    (part, joint): (usize, usize),
    (axis, pivot): (DVec3, DVec3),
    range: Option<Range>,
) -> Change {
    Change { part, told: Told::Joint { joint, axis, pivot, range } }
}

impl Change {
    /// Puts it into the condition that the object was made by.
    fn tell(&self, condition: &mut Condition, made: &Articulation, metres: f64) {
        let place = made.part_of_condition.iter().position(|p| *p == Some(self.part));
        let Some(place) = place else { return };
        match self.told {
            Told::Point(at) => {
                let Some(prompt) = condition.prompts.get_mut(place) else { return };
                if prompt.point.is_none() {
                    prompt.point = Some(at);
                } else {
                    prompt.also.push(at);
                }
            }
            Told::Joint { joint, axis, pivot, range } => {
                let range =
                    range.map(|range| in_file(&made.object, (self.part, joint), (range, metres)));
                let Some(given) = given(condition, place, joint) else { return };
                (given.axis, given.pivot) = (Some(axis), Some(pivot));
                given.range = range.or(given.range);
            }
        }
    }
}

/// A range as a condition has it: radians, or metres of the finished object.
pub fn in_file(
    object: &ArticulatedObject,
    (part, joint): (usize, usize),
    (range, metres): (Range, f64),
) -> Range {
    let turns = object.joints(part).get(joint).is_some_and(|j| j.kind.turns());
    if turns { range } else { range.scaled(metres) }
}

/// What is given of a joint of a part of the condition, to be changed.
fn given(condition: &mut Condition, part: usize, joint: usize) -> Option<&mut GivenJoint> {
    let joints = condition.tree.parts().get(part)?.joints.len();
    let prompt = condition.prompts.get_mut(part)?;
    prompt.joints.resize(joints, GivenJoint::default());
    prompt.joints.get_mut(joint)
}
