//! What one answered question is worth: every object is asked about once, the truth answers, and the object is
//! made again.
//!
//! `cargo run --release -p kinfold-training --example measure_questions -- CASES [SET [MOST]]`
//!
//! A line for each object: its name, how likely it was said to be right, whether it was, what was asked and
//! answered, and whether it is right afterwards. Then a line for each set: how many objects, and the shares that
//! were right before and after.

#![allow(clippy::print_stdout, reason = "what it measures goes to whoever reads it")]

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use model::ask::{About, Answer, Question, question};
use model::{Articulation, Prepared};
use object::weld::nearest_face;
use object::{DVec3, Range};
use training::evaluate::case::{Case, Set, folders, name_of};
use training::evaluate::outcome::Outcome;

/// The seed of the articulator.
const SEED: u64 = 0;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = arguments.first().ok_or("usage: measure_questions CASES [SET [MOST]]")?;
    let set: Option<Set> = arguments.get(1).map(|word| word.parse()).transpose()?;
    let most = arguments.get(2).map_or(Ok(usize::MAX), |n| n.parse())?;
    let wanted = |folder: &Path| set.is_none_or(|set| Set::of(&name_of(folder)) == set);
    let mut sums: BTreeMap<Set, [usize; 3]> = BTreeMap::new();
    for folder in folders(Path::new(root))?.into_iter().filter(|f| wanted(f)).take(most) {
        let case = Case::read(&folder)?;
        let ready = Prepared::new(&case.mesh)?;
        let truth = (&case.mesh, &*case.part_of_face, &*case.links);
        let (made, _) = ready.articulate(&case.condition, SEED)?;
        let before = Outcome::of(truth, &made).is_right();
        let said = made.confidence.as_ref().map_or(f64::NAN, |c| c.object);
        let metres = case.condition.size.map_or(1.0, |size| size.scale_for(&case.mesh));
        let asked = question(&made);
        let answer = asked.as_ref().and_then(|asked| answered(&case, &made, asked));
        let after = match (&asked, answer) {
            (Some(asked), Some(answer)) => {
                let told = asked.answered(&case.condition, &made, (answer, metres));
                let (again, _) = ready.articulate(&told, SEED)?;
                Outcome::of(truth, &again).is_right()
            }
            _ => before,
        };
        let (about, gain) =
            asked.map_or(("nothing".into(), 0.0), |q| (format!("{:?}", q.about), q.gain));
        println!("{} {said:.3} {before} {about} {gain:.3} {answer:?} {after}", case.name);
        let sum = sums.entry(Set::of(&case.name)).or_default();
        sum[0] += 1;
        sum[1] += usize::from(before);
        sum[2] += usize::from(after);
    }
    for (set, [count, before, after]) in sums {
        println!("{}: {count} objects, right {before} before and {after} after", set.name());
    }
    Ok(())
}

/// The answer that is true, if one is.
fn answered(case: &Case, made: &Articulation, asked: &Question) -> Option<Answer> {
    let place = |part: usize| made.part_of_condition.iter().position(|p| *p == Some(part));
    let is_true = |answer: &&Answer| match (asked.about, answer) {
        (About::Piece(at), Answer::Is(part)) => {
            let (face, _) = nearest_face(&case.mesh, at);
            place(*part) == Some(usize::from(case.part_of_face[face]))
        }
        (About::Axis(joint), Answer::Axis(axis, pivot)) => {
            let moved = (*axis, *pivot, None);
            is_right(case, made, (asked.part, joint), moved)
        }
        (About::Way(joint), Answer::Opens(axis, pivot, range)) => {
            let moved = (*axis, *pivot, Some(*range));
            is_right(case, made, (asked.part, joint), moved)
        }
        _ => false,
    };
    asked.answers.iter().find(is_true).copied()
}

/// Whether a joint that is so would be right: its axis, and its way where a range is given.
fn is_right(
    case: &Case,
    made: &Articulation,
    (part, joint): (usize, usize),
    (axis, pivot, range): (DVec3, DVec3, Option<Range>),
) -> bool {
    let mut joints: Vec<_> =
        (0..made.object.tree().len()).map(|p| made.object.joints(p).to_vec()).collect();
    let of = &mut joints[part][joint];
    (of.axis, of.pivot) = (axis, pivot);
    of.range = range.unwrap_or(of.range);
    let Ok(object) = made.object.clone().with_joints(joints) else { return false };
    let changed = Articulation { object, ..made.clone() };
    let outcome = Outcome::of((&case.mesh, &case.part_of_face, &case.links), &changed);
    let Some(place) = made.part_of_condition.iter().position(|p| *p == Some(part)) else {
        return false;
    };
    let of_part = outcome.joints.iter().filter(|j| usize::from(j.part) == place);
    of_part.skip(joint).take(1).any(|j| if range.is_some() { j.is_right() } else { j.is_found() })
}
