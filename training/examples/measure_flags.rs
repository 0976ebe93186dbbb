//! Whether what an articulation doubts is wrong, and what is wrong is doubted: the flags of group R, but for
//! R5, against the truth.
//!
//! `cargo run --release -p kinfold-training --example measure_flags -- CASES [SET [MOST]]`
//!
//! A line for each part that is flagged or wrong: its object, its name, what was flagged and what is wrong. Then
//! a line for each set: parts that are wrong and flagged, wrong and not, right and flagged, right and not, and
//! how many parts are flagged in objects that are right in all.

#![allow(clippy::print_stdout, reason = "what it measures goes to whoever reads it")]

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use model::Prepared;
use object::confidence::PartConfidence;
use training::evaluate::case::{Case, Set, folders, name_of};
use training::evaluate::outcome::Outcome;

/// The bounds of the profile of checks.
const SURE: f64 = 0.5;
const STRAY: f64 = 0.35;
const PIECE: f64 = 0.05;
const UNSURE: f64 = 0.6;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = arguments.first().ok_or("usage: measure_flags CASES [SET [MOST]]")?;
    let set: Option<Set> = arguments.get(1).map(|word| word.parse()).transpose()?;
    let most = arguments.get(2).map_or(Ok(usize::MAX), |n| n.parse())?;
    let wanted = |folder: &Path| set.is_none_or(|set| Set::of(&name_of(folder)) == set);
    let mut sums: BTreeMap<Set, [usize; 6]> = BTreeMap::new();
    for folder in folders(Path::new(root))?.into_iter().filter(|f| wanted(f)).take(most) {
        let case = Case::read(&folder)?;
        let (made, _) = Prepared::new(&case.mesh)?.articulate(&case.condition, 0)?;
        let outcome = Outcome::of((&case.mesh, &case.part_of_face, &case.links), &made);
        let Some(confidence) = &made.confidence else { continue };
        let sum = sums.entry(Set::of(&case.name)).or_default();
        sum[4] += usize::from(outcome.is_right());
        for (place, part) in made.part_of_condition.iter().enumerate() {
            let Some(part) = *part else { continue };
            let flags = flags(&confidence.parts[part]);
            let joints = outcome.joints.iter().filter(|j| usize::from(j.part) == place);
            let is_joint_wrong = joints.clone().any(|j| !j.is_right());
            let is_wrong = !outcome.is_part_right(place) || is_joint_wrong;
            let kind = 2 * usize::from(!is_wrong) + usize::from(flags.is_empty());
            sum[kind] += 1;
            sum[5] += usize::from(outcome.is_right() && !flags.is_empty());
            if is_wrong || !flags.is_empty() {
                let name = &case.condition.tree.parts()[place].name;
                let faults: Vec<String> = joints
                    .map(|j| {
                        format!(
                            "{:.0}° {:.2} {:?}",
                            j.angle.unwrap_or(90.0),
                            j.line.unwrap_or(0.0),
                            j.opening
                        )
                    })
                    .collect();
                let iou = outcome.ious[place];
                let labels = confidence.parts[part].labels;
                println!(
                    "{} {name}: flagged {flags:?}, {labels:.2}, IoU {iou:.2}, joints {faults:?}",
                    case.name
                );
            }
        }
    }
    for (set, [found, missed, false_alarm, quiet, right, in_right]) in sums {
        println!(
            "{}: wrong and flagged {found}, wrong and not {missed}, right and flagged {false_alarm}, \
             right and not {quiet}; {right} objects are right in all, {in_right} parts flagged in those",
            set.name()
        );
    }
    Ok(())
}

/// What is doubtful about a part, check by check.
fn flags(sure: &PartConfidence) -> Vec<String> {
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
