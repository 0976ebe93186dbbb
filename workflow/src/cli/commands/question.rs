//! The one question whose answer would help most, in words and for machines.

use model::Articulation;
use model::ask::{About, Answer, Question, question};
use object::{Condition, DVec3, FileFrame, Range};
use runner::Outcome;
use serde_json::{Value, json};

/// A question about an asset, as it is put to whoever made it.
pub(super) struct Asked {
    /// The question, in a sentence.
    pub(super) words: String,
    /// What may be answered, each in a line.
    pub(super) answers: Vec<String>,
    /// The same for machines.
    pub(super) value: Value,
}

/// The question about what a run made; none where nothing is in doubt, or nobody says how sure he is.
pub(super) fn of_outcome(outcome: &Outcome) -> Option<Asked> {
    let made: Articulation = outcome.artefact("articulate").ok()?;
    let condition: Condition = outcome.artefact("propose-condition").ok()?;
    let asked = question(&made)?;
    Some(told(&asked, &made, &condition))
}

fn told(asked: &Question, made: &Articulation, condition: &Condition) -> Asked {
    let parts = made.object.tree().parts();
    let name = |part: usize| parts.get(part).map_or("", |p| p.name.as_str());
    let (part, frame) = (name(asked.part), condition.frame);
    let words = match asked.about {
        About::Piece(at) => {
            let [x, y, z] = rounded(frame, at);
            format!("which part is the surface at {x} {y} {z} of?")
        }
        About::Axis(_) => format!("which is the axis of `{part}`?"),
        About::Way(_) => format!("which way does `{part}` open?"),
    };
    let metres = condition.size.map_or(1.0, |size| size.scale_for(made.object.mesh()));
    let turns = |joint: usize| {
        made.object.joints(asked.part).get(joint).is_some_and(|motion| motion.kind.turns())
    };
    let of = |nth: usize, answer: &Answer| {
        let (said, of, set) = match (asked.about, answer) {
            (About::Piece(at), Answer::Is(part)) => {
                let name = name(*part);
                let set = json!({ "points": [rounded(frame, at)] });
                (format!("`{name}`"), name, set)
            }
            (About::Axis(joint), Answer::Axis(axis, pivot)) => {
                let set = json!({ "axis": rounded(frame, *axis), "pivot": rounded(frame, *pivot) });
                let said = if nth == 0 { "as it was found" } else { "the likeliest other" };
                (said.to_owned(), part, of_joint(asked, made, (joint, set)))
            }
            (About::Way(joint), Answer::Opens(axis, pivot, range)) => {
                let range = if turns(joint) { *range } else { range.scaled(metres) };
                let (lower, upper) = range.ends();
                let set = json!({
                    "axis": rounded(frame, *axis),
                    "pivot": rounded(frame, *pivot),
                    "range": [digits(lower), digits(upper)],
                });
                (way(range).to_owned(), part, of_joint(asked, made, (joint, set)))
            }
            _ => (String::new(), "", Value::Null),
        };
        let line = format!("{said}: add {set} to `{of}` in the condition");
        (line, json!({ "answer": said, "part": of, "set": set }))
    };
    let (answers, values): (Vec<String>, Vec<Value>) =
        asked.answers.iter().enumerate().map(|(nth, answer)| of(nth, answer)).unzip();
    let value = json!({ "question": words, "part": part, "gain": asked.gain, "answers": values });
    Asked { words, answers, value }
}

/// What is set of a joint: on the part itself where it has one, else in its list.
fn of_joint(asked: &Question, made: &Articulation, (joint, set): (usize, Value)) -> Value {
    let motions = made.object.joints(asked.part);
    if motions.len() < 2 {
        return set;
    }
    let one = |(nth, motion): (usize, &object::JointMotion)| {
        let mut one = json!({ "type": motion.kind });
        if let (true, Value::Object(set), Some(one)) = (nth == joint, &set, one.as_object_mut()) {
            one.extend(set.clone());
        }
        one
    };
    json!({ "joints": motions.iter().enumerate().map(one).collect::<Vec<_>>() })
}

/// Which way a range goes along its axis, in words.
fn way(range: Range) -> &'static str {
    let (lower, upper) = range.ends();
    match (lower < 0.0, upper > 0.0) {
        (false, _) => "along its axis",
        (_, false) => "against its axis",
        _ => "both ways",
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
        let mesh =
            Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], vec![[0, 1, 2], [0, 1, 3]]);
        let range = Range::Limits { lower: 0.0, upper: 0.4 };
        let motion = JointMotion { kind, axis: DVec3::NEG_Y, pivot: DVec3::ZERO, range };
        let joints = vec![vec![], vec![motion]];
        let object = ArticulatedObject::new(mesh.unwrap(), tree, vec![0, 1], joints).unwrap();
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
    fn a_question_is_told_with_what_each_answer_changes_in_the_file() {
        let doubt = Doubt { other: 0, chance: 0.6, share: 0.5, at: DVec3::new(1.0, 2.0, 3.0) };
        let (made, condition) = made(0.9, Some(doubt));
        let asked = told(&question(&made).unwrap(), &made, &condition);
        // A file is y up, unless it says otherwise.
        assert_eq!(asked.words, "which part is the surface at 1 3 -2 of?");
        assert_eq!(
            asked.answers[1],
            "`body`: add {\"points\":[[1.0,3.0,-2.0]]} to `body` in the condition"
        );
        assert_eq!(asked.value["answers"][0]["part"], "drawer");
    }

    #[test]
    fn whoever_says_which_way_a_joint_opens_gives_its_axis_and_range() {
        let (made, condition) = made(0.2, None);
        let asked = told(&question(&made).unwrap(), &made, &condition);
        assert_eq!(asked.words, "which way does `drawer` open?");
        let told: Vec<&str> = asked.value["answers"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|a| a["answer"].as_str())
            .collect();
        assert_eq!(told, ["along its axis", "against its axis", "both ways"]);
        assert_eq!(asked.value["answers"][1]["set"]["range"], json!([-0.4, 0.0]));
    }
}
