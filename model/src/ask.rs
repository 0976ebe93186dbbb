//! The one question whose answer is expected to help most, and what each answer changes in the condition.
//!
//! An object is right where each of its parts and joints is. So the question is about what is least sure, as far
//! as one answer settles it: whose a doubtful piece is, which of two axes is right, which way a joint opens.

use object::condition::GivenJoint;
use object::confidence::{Doubt, JointConfidence, PartConfidence};
use object::{Condition, DVec3, JointMotion, Range};

use crate::articulate::Articulation;

/// A piece of this share of its part settles all doubt about it; what is smaller less. A guess.
const WHOLE: f64 = 0.15;
/// What goes one way this many times as far as the other opens that way.
const ONE_WAY: f64 = 9.0;

/// A question, and what may be answered.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// What it is about.
    pub about: About,
    /// The part of the object that it is about.
    pub part: usize,
    /// How much likelier the object is expected to be right once it is answered, as a share of the doubt
    /// about it, 0 to 1, uncalibrated.
    pub gain: f64,
    /// What may be answered; none of it is an answer, too.
    pub answers: Vec<Answer>,
}

/// What a question is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum About {
    /// Whose the surface at a point is, in the mesh's frame and unit.
    Piece(DVec3),
    /// Where the axis of one of the part's joints is.
    Axis(usize),
    /// Which way one of its joints opens.
    Way(usize),
}

/// An answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// The piece is of this part of the object.
    Is(usize),
    /// This is the axis, and a point on it, in the mesh's frame and unit.
    Axis(DVec3, DVec3),
    /// The joint opens along this axis, which goes through that point, as far as the range says.
    Opens(DVec3, DVec3, Range),
}

/// The question that is expected to help most; nothing where nobody says how sure he is, or nothing is in
/// doubt.
pub fn question(made: &Articulation) -> Option<Question> {
    questions(made).into_iter().reduce(|best, next| if next.gain > best.gain { next } else { best })
}

/// All that may be asked, part by part.
pub fn questions(made: &Articulation) -> Vec<Question> {
    let Some(confidence) = &made.confidence else { return Vec::new() };
    let mut all = Vec::new();
    for (part, sure) in confidence.parts.iter().enumerate() {
        if let Some(doubt) = &sure.doubt {
            let other = confidence.parts.get(doubt.other);
            all.push(of_piece(part, sure, (doubt, other)));
        }
        let joints = sure.joints.iter().zip(made.object.joints(part)).enumerate();
        for (joint, (sure, found)) in joints {
            all.extend(of_axis((part, joint), sure, found));
            all.extend(of_way((part, joint), sure, found));
        }
    }
    all.retain(|question| question.gain > 0.0);
    all
}

fn of_piece(
    part: usize,
    sure: &PartConfidence,
    (doubt, other): (&Doubt, Option<&PartConfidence>),
) -> Question {
    let least = other.map_or(sure.labels, |other| sure.labels.min(other.labels));
    let settles = (doubt.share * doubt.chance / WHOLE).min(1.0);
    Question {
        about: About::Piece(doubt.at),
        part,
        gain: (1.0 - least) * settles,
        answers: vec![Answer::Is(part), Answer::Is(doubt.other)],
    }
}

fn of_axis(
    (part, joint): (usize, usize),
    sure: &JointConfidence,
    found: &JointMotion,
) -> Option<Question> {
    let other = sure.instead?;
    let answers = [(found.axis, found.pivot), (other.axis, other.pivot)];
    Some(Question {
        about: About::Axis(joint),
        part,
        gain: (1.0 - sure.line.map_or(sure.axis, |line| line.min(sure.axis))) * other.chance,
        answers: answers.map(|(axis, pivot)| Answer::Axis(axis, pivot)).to_vec(),
    })
}

fn of_way(
    (part, joint): (usize, usize),
    sure: &JointConfidence,
    found: &JointMotion,
) -> Option<Question> {
    let (way, Range::Limits { lower, upper }) = (sure.way?, found.range) else { return None };
    let far = upper.max(-lower);
    let (ahead, back) = (far / ONE_WAY < upper, far / ONE_WAY < -lower);
    let ranges = [(true, false, [0.0, far]), (false, true, [-far, 0.0]), (true, true, [-far, far])];
    let answer = |(opens_ahead, opens_back, [lower, upper]): (bool, bool, [f64; 2])| {
        let is_found = (opens_ahead, opens_back) == (ahead, back);
        let range = if is_found { found.range } else { Range::Limits { lower, upper } };
        Answer::Opens(found.axis, found.pivot, range)
    };
    let is_given = way >= 1.0;
    (!is_given).then(|| Question {
        about: About::Way(joint),
        part,
        gain: 1.0 - way,
        answers: ranges.map(answer).to_vec(),
    })
}

impl Question {
    /// The condition with an answer in it; `metres` is how long a unit of the mesh is in the finished object.
    #[must_use]
    pub fn answered(
        &self,
        condition: &Condition,
        made: &Articulation,
        (answer, metres): (Answer, f64),
    ) -> Condition {
        let mut told = condition.clone();
        let place = |part: usize| made.part_of_condition.iter().position(|p| *p == Some(part));
        match (self.about, answer) {
            (About::Piece(at), Answer::Is(part)) => {
                let Some(prompt) = place(part).and_then(|p| told.prompts.get_mut(p)) else {
                    return told;
                };
                if prompt.point.is_none() {
                    prompt.point = Some(at);
                } else {
                    prompt.also.push(at);
                }
            }
            (About::Axis(joint), Answer::Axis(axis, pivot)) => {
                if let Some(given) = given(&mut told, place(self.part), joint) {
                    (given.axis, given.pivot) = (Some(axis), Some(pivot));
                }
            }
            (About::Way(joint), Answer::Opens(axis, pivot, range)) => {
                let turns =
                    made.object.joints(self.part).get(joint).is_some_and(|j| j.kind.turns());
                let range = if turns { range } else { range.scaled(metres) };
                if let Some(given) = given(&mut told, place(self.part), joint) {
                    (given.axis, given.pivot) = (Some(axis), Some(pivot));
                    given.range = Some(range);
                }
            }
            _ => {}
        }
        told
    }
}

/// What is given of a joint of a part of the condition, to be changed.
fn given(condition: &mut Condition, part: Option<usize>, joint: usize) -> Option<&mut GivenJoint> {
    let part = part?;
    let joints = condition.tree.parts().get(part)?.joints.len();
    let prompt = condition.prompts.get_mut(part)?;
    prompt.joints.resize(joints, GivenJoint::default());
    prompt.joints.get_mut(joint)
}

#[cfg(test)]
mod tests {
    use object::confidence::OtherAxis;
    use object::{ArticulatedObject, Confidence, JointKind, KinematicTree, Mesh, Part};

    use super::*;

    fn made(labels: f64, doubt: Option<Doubt>, joint: JointConfidence) -> Articulation {
        let part = |name: &str, parent, joints| Part {
            name: name.into(),
            text: name.into(),
            parent,
            joints,
        };
        let parts =
            vec![part("body", None, vec![]), part("door", Some(0), vec![JointKind::Revolute])];
        let tree = KinematicTree::new(parts).unwrap();
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 1, 3]]).unwrap();
        let range = Range::Limits { lower: 0.0, upper: 1.5 };
        let kind = JointKind::Revolute;
        let motion = JointMotion { kind, axis: DVec3::Z, pivot: DVec3::X, range };
        let object = ArticulatedObject::new(mesh, tree, vec![0, 1], vec![vec![], vec![motion]]);
        let sure = |labels, doubt, joints| PartConfidence { labels, doubt, joints };
        let parts = vec![sure(0.99, None, vec![]), sure(labels, doubt, vec![joint])];
        Articulation {
            object: object.unwrap(),
            part_of_condition: vec![Some(0), Some(1)],
            notes: Vec::new(),
            confidence: Some(Confidence { object: 0.5, parts }),
        }
    }

    fn joint(axis: f64, way: f64) -> JointConfidence {
        let instead = OtherAxis { axis: DVec3::X, pivot: DVec3::Y, chance: 0.8 };
        JointConfidence {
            axis,
            line: Some(axis),
            way: Some(way),
            joint: way,
            instead: Some(instead),
        }
    }

    #[test]
    fn what_is_least_sure_is_asked_about_and_the_answer_stands_in_the_condition() {
        let doubt = Doubt { other: 0, chance: 0.5, share: 0.9, at: DVec3::ONE };
        let made = made(0.4, Some(doubt), joint(0.9, 0.9));
        let asked = question(&made).unwrap();
        assert_eq!((asked.about, asked.part), (About::Piece(DVec3::ONE), 1));
        let condition = Condition::of_tree("", made.object.tree().clone(), object::Origin::User);
        let told = asked.answered(&condition, &made, (Answer::Is(0), 1.0));
        assert_eq!(told.prompts[0].point, Some(DVec3::ONE));
        let more = asked.answered(&told, &made, (Answer::Is(0), 1.0));
        assert_eq!(more.prompts[0].also, [DVec3::ONE]);
    }

    #[test]
    fn an_axis_is_asked_about_with_the_likeliest_other() {
        let made = made(0.9, None, joint(0.3, 0.8));
        let asked = question(&made).unwrap();
        assert_eq!((asked.about, asked.answers.len()), (About::Axis(0), 2));
        let condition = Condition::of_tree("", made.object.tree().clone(), object::Origin::User);
        let told = asked.answered(&condition, &made, (asked.answers[1], 1.0));
        assert_eq!(told.prompts[1].given(0).axis, Some(DVec3::X));
        assert_eq!(told.prompts[1].given(0).pivot, Some(DVec3::Y));
    }

    #[test]
    fn a_joint_may_open_ahead_back_or_both_ways_and_the_found_way_stays_as_it_was() {
        let made = made(0.9, None, joint(0.9, 0.2));
        let asked = question(&made).unwrap();
        assert_eq!(asked.about, About::Way(0));
        let ends = |answer: &Answer| match answer {
            Answer::Opens(_, _, range) => range.ends(),
            _ => panic!("{answer:?}"),
        };
        let all: Vec<(f64, f64)> = asked.answers.iter().map(ends).collect();
        assert_eq!(all, [(0.0, 1.5), (-1.5, 0.0), (-1.5, 1.5)]);
    }

    #[test]
    fn where_nobody_says_how_sure_he_is_nothing_is_asked() {
        let made = Articulation { confidence: None, ..made(0.4, None, joint(0.4, 0.4)) };
        assert_eq!(question(&made), None);
    }
}
