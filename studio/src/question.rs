//! The one question whose answer would help most, in words and in fields of a condition file.

use model::Articulation;
use model::ask::{About, Answer, Change, Question, Told, heading, in_file, question};
use object::mesh::Bounds;
use object::{ArticulatedObject, Condition, DVec3, FileFrame, JointMotion, Range};
use schemars::JsonSchema;
use serde::Serialize;

/// An axis is along one of the object's where its cosine to it is at least this: within 20°, a guess.
const STRAIGHT: f64 = 0.94;
/// An axis is at a side of its part from this share of the part's extent off its middle; a guess.
const ASIDE: f64 = 0.2;

/// A question, as it is put to a person.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Asked {
    /// The question, in a sentence.
    pub words: String,
    /// The part it is about.
    pub part: String,
    /// Parts of its kind that an answer may hold for as well.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub siblings: Vec<String>,
    /// Where on the object it is about, in the mesh file's coordinates; none where it is about a joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 3]>,
    /// How much of the doubt about the object an answer is expected to settle, 0 to 1.
    pub gain: f64,
    /// What may be answered.
    pub answers: Vec<Choice>,
}

/// An answer, and what it changes in the condition.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Choice {
    /// The answer.
    pub words: String,
    /// What it changes.
    pub change: Edit,
    /// What it changes of the part's siblings, if it holds for them as well.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<Edit>,
}

/// What changes of one part of the condition.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Edit {
    /// The part whose fields change.
    pub part: String,
    /// Which of its joints they are of; none where they are of the part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub index: Option<usize>,
    /// A further point on the part, in the mesh file's coordinates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Fields of the joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set: Option<Set>,
}

/// Fields of a joint, as they stand in a condition file.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Set {
    /// Direction of its axis, in the mesh file's coordinates.
    pub axis: [f64; 3],
    /// A point on it, in the mesh file's coordinates and unit.
    pub pivot: [f64; 3],
    /// Both ends of its range, radians or metres of the finished object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

/// The question about an object that was made by a condition; none where nothing is in doubt, or nobody says
/// how sure he is.
pub fn asked(made: &Articulation, condition: &Condition) -> Option<Asked> {
    let asked = question(made)?;
    Some(told(&asked, made, condition))
}

fn told(asked: &Question, made: &Articulation, condition: &Condition) -> Asked {
    let name = |part: usize| name_of(made, part);
    let part = name(asked.part);
    let (words, at) = match asked.about {
        About::Piece(at) => {
            let at = rounded(condition.frame, at);
            (format!("Which part is the surface at {} {} {} of?", at[0], at[1], at[2]), Some(at))
        }
        About::Axis(_) => (format!("How does `{part}` move?"), None),
        About::Way(_) => (format!("Which way does `{part}` open?"), None),
    };
    let choice = |answer: &Answer| {
        let changes = asked.changes(made, (*answer, false));
        let mut edits = changes.iter().map(|change| edit(change, made, condition));
        let change = edits.next()?;
        Some(Choice { words: words_of(asked, made, answer), change, also: edits.collect() })
    };
    let answers = told_apart(asked.answers.iter().filter_map(choice).collect());
    let siblings = asked.also.iter().map(|part| name(*part).to_owned()).collect();
    Asked { words, part: part.into(), siblings, at, gain: asked.gain, answers }
}

/// Answers of the same words, with a word more for the later one.
fn told_apart(mut all: Vec<Choice>) -> Vec<Choice> {
    for nth in 1..all.len() {
        if all[..nth].iter().any(|before| before.words == all[nth].words) {
            all[nth].words.push_str(" (the other axis)");
        }
    }
    all
}

fn name_of(made: &Articulation, part: usize) -> &str {
    made.object.tree().parts().get(part).map_or("", |p| p.name.as_str())
}

/// An answer in words.
fn words_of(asked: &Question, made: &Articulation, answer: &Answer) -> String {
    let (About::Axis(joint) | About::Way(joint)) = asked.about else {
        return match answer {
            Answer::Is(part) => name_of(made, *part).into(),
            _ => String::new(),
        };
    };
    let object = &made.object;
    let Some(found) = object.joints(asked.part).get(joint) else { return String::new() };
    let moves = |axis: DVec3, pivot: DVec3| JointMotion { axis, pivot, ..*found };
    let line = |axis: DVec3, pivot: DVec3| match asked.about {
        About::Axis(_) => Some(line(object, asked.part, &moves(axis, pivot))),
        _ => None,
    };
    match *answer {
        Answer::Is(part) => name_of(made, part).into(),
        Answer::Axis(axis, pivot) => line(axis, pivot).unwrap_or_else(|| "As it was found".into()),
        Answer::Opens(axis, pivot, range) => {
            let way = way(range, heading(object, asked.part, &moves(axis, pivot)));
            line(axis, pivot).map_or_else(|| way.clone(), |line| format!("{way}, {line}"))
        }
    }
}

/// Where a joint's axis is, in words, as one sees it who stands before the object.
fn line(object: &ArticulatedObject, part: usize, motion: &JointMotion) -> String {
    let most = motion.axis.abs().max_position();
    let lies = match most {
        _ if motion.axis.abs()[most] < STRAIGHT => "slanting axis",
        0 => "axis from left to right",
        1 => "axis from front to back",
        _ => "upright axis",
    };
    let corners = object.faces_of(part).flat_map(|face| object.mesh().corners(face));
    let bounds = Bounds::of(corners);
    let off = (motion.pivot - bounds.centre()).reject_from(motion.axis);
    let is_off = motion.kind.turns() && off.length() > ASIDE * bounds.size().max_element();
    let at = match (is_off, side(off)) {
        (false, _) => "",
        (true, "To the right") => " at its right",
        (true, "To the left") => " at its left",
        (true, "To the back") => " at its back",
        (true, "To the front") => " at its front",
        (true, "Up") => " at its top",
        (true, _) => " at its bottom",
    };
    format!("{lies}{at}")
}

/// What a change is in a condition file.
fn edit(change: &Change, made: &Articulation, condition: &Condition) -> Edit {
    let (frame, object) = (condition.frame, &made.object);
    let part = name_of(made, change.part).to_owned();
    match change.told {
        Told::Point(at) => Edit { part, index: None, point: Some(rounded(frame, at)), set: None },
        Told::Joint { joint, axis, pivot, range } => {
            let metres = condition.size.map_or(1.0, |size| size.scale_for(object.mesh()));
            let range = range.map(|range| in_file(object, (change.part, joint), (range, metres)));
            let ends = |range: Range| [digits(range.ends().0), digits(range.ends().1)];
            let (axis, pivot) = (rounded(frame, axis), rounded(frame, pivot));
            let set = Some(Set { axis, pivot, range: range.map(ends) });
            Edit { part, index: Some(joint), point: None, set }
        }
    }
}

/// Which way a part sets off by a range, in words: as one sees it who stands before the object.
fn way(range: Range, heading: Option<DVec3>) -> String {
    let (lower, upper) = range.ends();
    let told = |sign: f64, otherwise: &str| {
        heading.map_or_else(|| otherwise.to_owned(), |way| side(sign * way).to_owned())
    };
    match (lower < 0.0, upper > 0.0) {
        (false, _) => told(1.0, "Along its axis"),
        (_, false) => told(-1.0, "Against its axis"),
        _ => "Both ways".into(),
    }
}

/// A direction as the side of the object that it points to: z is up, the front towards −y.
fn side(way: DVec3) -> &'static str {
    let most = way.abs().max_position();
    match (most, way[most] > 0.0) {
        (0, true) => "To the right",
        (0, false) => "To the left",
        (1, true) => "To the back",
        (1, false) => "To the front",
        (_, true) => "Up",
        (_, false) => "Down",
    }
}

/// A point or a direction as a condition has it, to six digits.
fn rounded(frame: FileFrame, at: DVec3) -> [f64; 3] {
    frame.point_to_file(at).to_array().map(digits)
}

fn digits(number: f64) -> f64 {
    let number = format!("{number:.6}").parse().unwrap_or(number);
    if number == 0.0 { 0.0 } else { number }
}

#[cfg(test)]
mod tests {
    use object::confidence::{Doubt, JointConfidence, PartConfidence};
    use object::{
        ArticulatedObject, Confidence, JointKind, JointMotion, KinematicTree, Mesh, Part,
    };

    use super::*;

    fn made(way: f64, doubt: Option<Doubt>) -> (Articulation, Condition) {
        let part = |name: &str, parent, joints| Part {
            name: name.into(),
            text: name.into(),
            parent,
            joints,
        };
        let kind = JointKind::Prismatic;
        let parts = vec![part("body", None, vec![]), part("drawer", Some(0), vec![kind])];
        let tree = KinematicTree::new(parts).unwrap();
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 1, 3]]).unwrap();
        let range = Range::Limits { lower: 0.0, upper: 0.4 };
        let motion = JointMotion { kind, axis: DVec3::NEG_Y, pivot: DVec3::ZERO, range };
        let joints = vec![vec![], vec![motion]];
        let object = ArticulatedObject::new(mesh, tree, vec![0, 1], joints).unwrap();
        let joint =
            JointConfidence { axis: 0.9, line: None, way: Some(way), joint: way, instead: None };
        let parts = vec![
            PartConfidence { labels: 0.9, doubt: None, joints: vec![] },
            PartConfidence { labels: 0.3, doubt, joints: vec![joint] },
        ];
        let condition = Condition::of_tree("", object.tree().clone(), object::Origin::User);
        let confidence = Some(Confidence { object: 0.3, parts });
        let part_of_condition = vec![Some(0), Some(1)];
        (Articulation { object, part_of_condition, notes: vec![], confidence }, condition)
    }

    #[test]
    fn a_doubtful_piece_is_asked_about_by_its_place_in_the_file() {
        let at = DVec3::new(1.0, 2.0, 3.0);
        let doubt = Doubt { other: 0, chance: 0.6, share: 0.5, at };
        let (made, condition) = made(0.9, Some(doubt));
        let asked = asked(&made, &condition).unwrap();
        // A file is y up, unless it says otherwise.
        assert_eq!(asked.words, "Which part is the surface at 1 3 -2 of?");
        assert_eq!(asked.at, Some([1.0, 3.0, -2.0]));
        let own = |answer: &Choice| (answer.change.part.clone(), answer.change.point);
        let told: Vec<(String, Option<[f64; 3]>)> = asked.answers.iter().map(own).collect();
        assert_eq!(told, [("drawer".to_owned(), asked.at), ("body".to_owned(), asked.at)]);
    }

    #[test]
    fn whoever_says_which_way_a_joint_opens_gives_its_axis_and_range() {
        let (made, condition) = made(0.2, None);
        let asked = asked(&made, &condition).unwrap();
        assert_eq!((asked.words.as_str(), asked.at), ("Which way does `drawer` open?", None));
        let told: Vec<&str> = asked.answers.iter().map(|a| a.words.as_str()).collect();
        assert_eq!(told, ["To the front", "To the back", "Both ways"]);
        let back = &asked.answers[1].change;
        assert_eq!(back.set.as_ref().unwrap().range, Some([-0.4, 0.0]));
        assert_eq!((back.index, back.set.as_ref().unwrap().axis), (Some(0), [0.0, 0.0, 1.0]));
    }

    #[test]
    fn an_axis_is_told_by_how_it_lies_and_at_which_side_of_the_part() {
        let (made, _) = made(0.2, None);
        let told = |kind, axis, pivot| {
            let motion = JointMotion { kind, axis, pivot, range: Range::Continuous };
            line(&made.object, 1, &motion)
        };
        // The part reaches from 0 to 1 along x and z.
        let middle = DVec3::new(0.5, 0.0, 0.5);
        assert_eq!(told(JointKind::Revolute, DVec3::Z, middle), "upright axis");
        let left = DVec3::new(0.0, 0.0, 0.5);
        assert_eq!(told(JointKind::Revolute, DVec3::Z, left), "upright axis at its left");
        assert_eq!(told(JointKind::Prismatic, DVec3::Y, left), "axis from front to back");
        let slanting = DVec3::new(1.0, 0.0, 1.0).normalize();
        assert_eq!(told(JointKind::Revolute, slanting, middle), "slanting axis");
    }

    #[test]
    fn what_turns_about_its_own_middle_has_no_side_to_go_to() {
        let range = Range::Limits { lower: 0.0, upper: 1.0 };
        assert_eq!(way(range, None), "Along its axis");
        assert_eq!(way(range.reversed(), None), "Against its axis");
        assert_eq!(way(range, Some(DVec3::new(0.1, 0.2, -0.9))), "Down");
        assert_eq!(way(range.reversed(), Some(DVec3::X)), "To the left");
    }

    #[test]
    fn where_nobody_says_how_sure_he_is_nothing_is_asked() {
        let (made, condition) = made(0.2, None);
        let silent = Articulation { confidence: None, ..made };
        assert_eq!(asked(&silent, &condition), None);
    }
}
