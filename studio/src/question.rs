//! The one question whose answer would help most, in words and in fields of a condition file.

use model::Articulation;
use model::ask::{About, Answer, Question, question};
use object::{Condition, DVec3, FileFrame, Range};
use schemars::JsonSchema;
use serde::Serialize;

/// A part whose middle is nearer its axis than this goes to no side: a share of the object's diagonal, a guess.
const STILL: f64 = 0.01;

/// A question, as it is put to a person.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Asked {
    /// The question, in a sentence.
    pub words: String,
    /// The part it is about.
    pub part: String,
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
    let parts = made.object.tree().parts();
    let name = |part: usize| parts.get(part).map_or("", |p| p.name.as_str());
    let part = name(asked.part);
    let (words, at) = match asked.about {
        About::Piece(at) => {
            let at = rounded(condition.frame, at);
            (format!("Which part is the surface at {} {} {} of?", at[0], at[1], at[2]), Some(at))
        }
        About::Axis(_) => (format!("Which is the axis of `{part}`?"), None),
        About::Way(_) => (format!("Which way does `{part}` open?"), None),
    };
    let choice = |(nth, answer): (usize, &Answer)| choice(asked, (made, condition), (nth, answer));
    let answers = asked.answers.iter().enumerate().map(choice).collect();
    Asked { words, part: part.into(), at, gain: asked.gain, answers }
}

fn choice(
    asked: &Question,
    (made, condition): (&Articulation, &Condition),
    (nth, answer): (usize, &Answer),
) -> Choice {
    let frame = condition.frame;
    let parts = made.object.tree().parts();
    let name = |part: usize| parts.get(part).map_or("", |p| p.name.as_str());
    let index = match asked.about {
        About::Piece(_) => None,
        About::Axis(joint) | About::Way(joint) => Some(joint),
    };
    let of_joint = |words: &str, set: Set| Choice {
        words: words.into(),
        part: name(asked.part).into(),
        index,
        point: None,
        set: Some(set),
    };
    let set = |axis: DVec3, pivot: DVec3, range: Option<[f64; 2]>| Set {
        axis: rounded(frame, axis),
        pivot: rounded(frame, pivot),
        range,
    };
    match *answer {
        Answer::Is(part) => {
            let point = match asked.about {
                About::Piece(at) => Some(rounded(frame, at)),
                About::Axis(_) | About::Way(_) => None,
            };
            Choice { words: name(part).into(), part: name(part).into(), index, point, set: None }
        }
        Answer::Axis(axis, pivot) => {
            let words = if nth == 0 { "As it was found" } else { "The likeliest other" };
            of_joint(words, set(axis, pivot, None))
        }
        Answer::Opens(axis, pivot, range) => {
            let own = made.object.joints(asked.part);
            let turns = index.and_then(|joint| own.get(joint)).is_some_and(|j| j.kind.turns());
            let metres = condition.size.map_or(1.0, |size| size.scale_for(made.object.mesh()));
            let range = if turns { range } else { range.scaled(metres) };
            let (lower, upper) = range.ends();
            let heading = index.and_then(|joint| heading(made, asked.part, joint));
            of_joint(&way(range, heading), set(axis, pivot, Some([digits(lower), digits(upper)])))
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

/// The way the middle of a part's surface sets off where its joint goes ahead; none where it hardly does.
fn heading(made: &Articulation, part: usize, joint: usize) -> Option<DVec3> {
    let (object, mesh) = (&made.object, made.object.mesh());
    let motion = object.joints(part).get(joint)?;
    if !motion.kind.turns() {
        return Some(motion.axis);
    }
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for face in object.faces_of(part) {
        sum += mesh.centroid(face) * mesh.area(face);
        area += mesh.area(face);
    }
    let way = motion.axis.cross(sum / area - motion.pivot);
    (way.length() > STILL * mesh.bounds().diagonal()).then_some(way)
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
        let doubt = Doubt { other: 0, chance: 0.6, share: 0.5, at: DVec3::new(1.0, 2.0, 3.0) };
        let (made, condition) = made(0.9, Some(doubt));
        let asked = asked(&made, &condition).unwrap();
        // A file is y up, unless it says otherwise.
        assert_eq!(asked.words, "Which part is the surface at 1 3 -2 of?");
        assert_eq!(asked.at, Some([1.0, 3.0, -2.0]));
        let told: Vec<(&str, Option<[f64; 3]>)> =
            asked.answers.iter().map(|a| (a.part.as_str(), a.point)).collect();
        assert_eq!(told, [("drawer", asked.at), ("body", asked.at)]);
    }

    #[test]
    fn whoever_says_which_way_a_joint_opens_gives_its_axis_and_range() {
        let (made, condition) = made(0.2, None);
        let asked = asked(&made, &condition).unwrap();
        assert_eq!((asked.words.as_str(), asked.at), ("Which way does `drawer` open?", None));
        let told: Vec<&str> = asked.answers.iter().map(|a| a.words.as_str()).collect();
        assert_eq!(told, ["To the front", "To the back", "Both ways"]);
        let back = &asked.answers[1];
        assert_eq!(back.set.as_ref().unwrap().range, Some([-0.4, 0.0]));
        assert_eq!((back.index, back.set.as_ref().unwrap().axis), (Some(0), [0.0, 0.0, 1.0]));
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
