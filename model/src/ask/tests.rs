use object::confidence::{Doubt, JointConfidence, OtherAxis, PartConfidence};
use object::{
    ArticulatedObject, Condition, Confidence, DVec3, JointKind, JointMotion, KinematicTree, Mesh,
    Part, Range,
};

use super::{About, Answer, Question, Told, question};
use crate::articulate::Articulation;

fn made(labels: f64, doubt: Option<Doubt>, joint: JointConfidence) -> Articulation {
    let part =
        |name: &str, parent, joints| Part { name: name.into(), text: name.into(), parent, joints };
    let parts = vec![part("body", None, vec![]), part("door", Some(0), vec![JointKind::Revolute])];
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
    JointConfidence { axis, line: Some(axis), way: Some(way), joint: way, instead: Some(instead) }
}

#[test]
fn what_is_least_sure_is_asked_about_and_the_answer_stands_in_the_condition() {
    let doubt = Doubt { other: 0, chance: 0.5, share: 0.9, at: DVec3::ONE };
    let made = made(0.4, Some(doubt), joint(0.9, 0.9));
    let asked = question(&made).unwrap();
    assert_eq!((asked.about, asked.part), (About::Piece(DVec3::ONE), 1));
    let condition = Condition::of_tree("", made.object.tree().clone(), object::Origin::User);
    let told = asked.answered(&condition, &made, (Answer::Is(0), false, 1.0));
    assert_eq!(told.prompts[0].point, Some(DVec3::ONE));
    let more = asked.answered(&told, &made, (Answer::Is(0), false, 1.0));
    assert_eq!(more.prompts[0].also, [DVec3::ONE]);
}

#[test]
fn an_axis_is_asked_about_with_the_likeliest_other() {
    let made = made(0.9, None, joint(0.3, 0.8));
    let asked = question(&made).unwrap();
    assert_eq!((asked.about, asked.answers.len()), (About::Axis(0), 6));
    let condition = Condition::of_tree("", made.object.tree().clone(), object::Origin::User);
    let told = asked.answered(&condition, &made, (asked.answers[3], false, 1.0));
    assert_eq!(told.prompts[1].given(0).axis, Some(DVec3::X));
    assert_eq!(told.prompts[1].given(0).pivot, Some(DVec3::Y));
}

#[test]
fn a_joint_may_open_ahead_back_or_both_ways_and_the_found_way_stays_as_it_was() {
    let made = made(0.9, None, JointConfidence { instead: None, ..joint(0.9, 0.2) });
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

/// A chest with parts of one kind, each a triangle about a middle of its own, with a joint and what is said of it.
fn chest(parts: &[(&str, DVec3, JointMotion, JointConfidence)]) -> Articulation {
    let mut corners = vec![DVec3::ZERO, DVec3::X, DVec3::Z];
    let mut faces = vec![[0, 1, 2]];
    for (_, middle, ..) in parts {
        let first = corners.len() as u32;
        corners.extend([DVec3::X, DVec3::Z, -DVec3::X - DVec3::Z].map(|d| *middle + d * 0.1));
        faces.push([first, first + 1, first + 2]);
    }
    let part = |name: &str, parent, joints| Part {
        name: name.replace(' ', "_"),
        text: name.into(),
        parent,
        joints,
    };
    let all = parts.iter().map(|(name, _, motion, _)| part(name, Some(0), vec![motion.kind]));
    let tree = std::iter::once(part("body", None, vec![])).chain(all).collect();
    let tree = KinematicTree::new(tree).unwrap();
    let labels = (0..=parts.len() as u16).collect();
    let joints = std::iter::once(vec![]).chain(parts.iter().map(|p| vec![p.2])).collect();
    let mesh = Mesh::new(corners, faces).unwrap();
    let sure = |joints| PartConfidence { labels: 0.99, doubt: None, joints };
    let all = parts.iter().map(|p| sure(vec![p.3]));
    Articulation {
        object: ArticulatedObject::new(mesh, tree, labels, joints).unwrap(),
        part_of_condition: (0..=parts.len()).map(Some).collect(),
        notes: Vec::new(),
        confidence: Some(Confidence {
            object: 0.5,
            parts: std::iter::once(sure(vec![])).chain(all).collect(),
        }),
    }
}

fn motion(kind: JointKind, axis: DVec3, pivot: DVec3) -> JointMotion {
    JointMotion { kind, axis, pivot, range: Range::Limits { lower: -1.5, upper: 1.5 } }
}

fn told(made: &Articulation, asked: &Question, answer: usize) -> Vec<(usize, (f64, f64))> {
    let range = |told: Told| match told {
        Told::Joint { range: Some(range), .. } => range.ends(),
        _ => panic!("{told:?}"),
    };
    let changes = asked.changes(made, (asked.answers[answer], false));
    changes.iter().map(|change| (change.part, range(change.told))).collect()
}

#[test]
fn one_answer_opens_both_double_doors_to_the_front() {
    let sure = |way| JointConfidence { instead: None, ..joint(0.9, way) };
    let door = |name, at: f64, pivot: f64| {
        let kind = JointKind::Revolute;
        (name, DVec3::X * at, motion(kind, DVec3::Z, DVec3::X * pivot), sure(0.4))
    };
    let made = chest(&[door("left door", -1.0, -2.0), door("right door", 1.0, 2.0)]);
    let asked = question(&made).unwrap();
    assert_eq!((asked.about, asked.part, &asked.also[..]), (About::Way(0), 1, &[2][..]));
    assert!((asked.gain - (1.0 - 0.4 * 0.4)).abs() < 1e-12, "{}", asked.gain);
    // Hinges on both sides: the same way for a person is the opposite turn.
    assert_eq!(told(&made, &asked, 0), [(1, (0.0, 1.5)), (2, (-1.5, 0.0))]);
    assert_eq!(told(&made, &asked, 1), [(1, (-1.5, 0.0)), (2, (0.0, 1.5))]);
    assert_eq!(told(&made, &asked, 2), [(1, (-1.5, 1.5)), (2, (-1.5, 1.5))]);
}

#[test]
fn what_a_person_gave_and_what_goes_another_way_hears_of_no_answer() {
    let sure = |way| JointConfidence { instead: None, ..joint(0.9, way) };
    let drawer = |name, axis, way| {
        (name, DVec3::X, motion(JointKind::Prismatic, axis, DVec3::ZERO), sure(way))
    };
    let made = chest(&[
        drawer("drawer 1", DVec3::Y, 0.3),
        drawer("drawer 2", DVec3::Y, 1.0),
        drawer("drawer 3", DVec3::X, 0.9),
        drawer("button", DVec3::Y, 0.9),
    ]);
    let asked = question(&made).unwrap();
    assert_eq!((asked.part, &asked.also[..]), (1, &[][..]));
    assert_eq!(told(&made, &asked, 0), [(1, (0.0, 1.5))]);
}

#[test]
fn one_answered_axis_turns_the_siblings_axes_but_moves_no_hinge_to_another_side() {
    let other = |axis, pivot| Some(OtherAxis { axis, pivot, chance: 0.6 });
    let sure = |axis, pivot| JointConfidence { instead: other(axis, pivot), ..joint(0.3, 0.9) };
    let flap = |name, other: (DVec3, DVec3)| {
        let kind = JointKind::Revolute;
        (name, DVec3::X, motion(kind, DVec3::Z, DVec3::ZERO), sure(other.0, other.1))
    };
    let made = chest(&[
        flap("flap 1", (DVec3::X, DVec3::ONE)),
        flap("flap 2", (DVec3::X, DVec3::Y)),
        flap("flap 3", (DVec3::Z, DVec3::X)),
    ]);
    let asked = question(&made).unwrap();
    assert_eq!((asked.about, asked.part, &asked.also[..]), (About::Axis(0), 1, &[2, 3][..]));
    let axes = |answer: usize| -> Vec<(usize, DVec3, DVec3)> {
        let line = |told: Told| match told {
            Told::Joint { axis, pivot, .. } => (axis, pivot),
            Told::Point(_) => panic!("{told:?}"),
        };
        let changes = asked.changes(&made, (asked.answers[answer], false));
        changes.iter().map(|c| (c.part, line(c.told).0, line(c.told).1)).collect()
    };
    let (found, other) = (2, 5);
    assert_eq!(axes(other), [(1, DVec3::X, DVec3::ONE), (2, DVec3::X, DVec3::Y)]);
    let all = [1, 2, 3].map(|part| (part, DVec3::Z, DVec3::ZERO));
    assert_eq!(axes(found), all);
}
