//! All that may be asked about an object, and which of it helps most.

use object::confidence::{Doubt, JointConfidence};
use object::{Confidence, JointMotion};

use super::siblings::{openings, siblings};
use super::types::{About, Answer, Question};
use crate::articulate::Articulation;

/// A piece of this share of its part settles all doubt about it; what is smaller less. A guess.
const WHOLE: f64 = 0.15;

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
            all.push(of_piece((part, doubt), made, confidence));
        }
        let joints = made.object.joints(part).iter().enumerate();
        all.extend(
            joints.filter_map(|(j, motion)| of_joint((part, j), motion, (made, confidence))),
        );
    }
    all.retain(|question| question.gain > 0.0);
    all
}

/// With those of a part's siblings that any of the answers holds for.
fn heard(mut question: Question, made: &Articulation) -> Question {
    let hears = |sibling: &usize| {
        let mut answers = question.answers.iter();
        answers.any(|answer| question.of_sibling(made, *answer, *sibling).is_some())
    };
    question.also = siblings(&made.object, question.part).into_iter().filter(hears).collect();
    question
}

/// A probability before and after an answer.
type Settled = (f64, f64);

/// Which share of what is right after an answer is wrong before.
fn gain(settled: impl IntoIterator<Item = Settled>) -> f64 {
    let kept = |(before, after): Settled| if after > 0.0 { (before / after).min(1.0) } else { 1.0 };
    1.0 - settled.into_iter().map(kept).product::<f64>()
}

fn of_piece(
    (part, doubt): (usize, &Doubt),
    made: &Articulation,
    confidence: &Confidence,
) -> Question {
    let answers = vec![Answer::Is(part), Answer::Is(doubt.other)];
    let question =
        Question { about: About::Piece(doubt.at), part, also: vec![], gain: 0.0, answers };
    let question = heard(question, made);
    let labels = |part: usize| confidence.parts.get(part).map_or(1.0, |s| s.labels);
    let settled = |part: usize| {
        let doubt = confidence.parts.get(part)?.doubt.as_ref()?;
        let least = labels(part).min(labels(doubt.other));
        let settles = (doubt.share * doubt.chance / WHOLE).min(1.0);
        Some((least, least + (1.0 - least) * settles))
    };
    let parts = question.also.iter().copied().chain([part]);
    Question { gain: gain(parts.filter_map(settled)), ..question }
}

/// How a joint moves: about which of two axes, if there is another, and which way, if that is in doubt.
fn of_joint(
    (part, joint): (usize, usize),
    found: &JointMotion,
    (made, confidence): (&Articulation, &Confidence),
) -> Option<Question> {
    let sure = |part: usize| confidence.parts.get(part)?.joints.get(joint);
    let own = sure(part)?;
    let is_way_open = own.way.is_some_and(|way| way < 1.0);
    let lines =
        [Some((found.axis, found.pivot)), own.instead.map(|other| (other.axis, other.pivot))];
    let lines = lines.into_iter().flatten();
    let opens = openings(found.range).filter(|_| is_way_open);
    let answers: Vec<Answer> = match opens {
        Some(ranges) => {
            let of_line = |(axis, pivot)| ranges.map(|range| Answer::Opens(axis, pivot, range));
            lines.flat_map(of_line).collect()
        }
        None => lines.map(|(axis, pivot)| Answer::Axis(axis, pivot)).collect(),
    };
    if answers.len() < 2 {
        return None;
    }
    let about = if own.instead.is_some() { About::Axis(joint) } else { About::Way(joint) };
    let question = heard(Question { about, part, also: vec![], gain: 0.0, answers }, made);
    let settled = |part: usize| {
        let JointConfidence { axis, line, way, instead, .. } = *sure(part)?;
        let axis = line.map_or(axis, |line| line.min(axis));
        let after = axis + (1.0 - axis) * instead.map_or(0.0, |other| other.chance);
        Some(match way.filter(|_| opens.is_some()) {
            Some(way) => (axis * way, after),
            None => (axis, after),
        })
    };
    let parts = question.also.iter().copied().chain([part]);
    Some(Question { gain: gain(parts.filter_map(settled)), ..question })
}
