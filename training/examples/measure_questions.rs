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

use model::ask::{Answer, Change, Question, Told, question};
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
            (Some(asked), Some((answer, alone))) => {
                let told = asked.answered(&case.condition, &made, (answer, alone, metres));
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

/// The answer that is true, if one is, and whether it is so of the part alone, and not of all its siblings.
fn answered(case: &Case, made: &Articulation, asked: &Question) -> Option<(Answer, bool)> {
    let is_true = |answer: Answer, alone: bool| {
        let changes = asked.changes(made, (answer, alone));
        changes.iter().all(|change| is_so(case, made, change))
    };
    let find = |alone: bool| {
        let answer = asked.answers.iter().find(|answer| is_true(**answer, alone));
        answer.map(|answer| (*answer, alone))
    };
    find(false).or_else(|| find(true))
}

fn is_so(case: &Case, made: &Articulation, change: &Change) -> bool {
    let place = made.part_of_condition.iter().position(|p| *p == Some(change.part));
    match change.told {
        Told::Point(at) => {
            let (face, _) = nearest_face(&case.mesh, at);
            place == Some(usize::from(case.part_of_face[face]))
        }
        Told::Joint { joint, axis, pivot, range } => {
            is_right(case, made, (change.part, joint), (axis, pivot, range))
        }
    }
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
