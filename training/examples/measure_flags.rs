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
use training::evaluate::case::{Case, Set, folders, name_of};
use training::evaluate::doubts::{Judged, JudgedPart};

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
        let truth = (&case.mesh, &case.part_of_face[..], &case.links[..]);
        let judged = Judged::of(truth, &made, false);
        let (sum, is_right) = (sums.entry(Set::of(&case.name)).or_default(), judged.is_right());
        sum[4] += usize::from(is_right);
        for (place, part) in judged.parts.iter().enumerate() {
            if made.part_of_condition[place].is_none() {
                continue;
            }
            let JudgedPart { is_wrong, flags, .. } = part;
            let kind = 2 * usize::from(!is_wrong) + usize::from(flags.is_empty());
            sum[kind] += 1;
            sum[5] += usize::from(is_right && !flags.is_empty());
            if *is_wrong || !flags.is_empty() {
                let name = &case.condition.tree.parts()[place].name;
                println!("{} {name}: {}", case.name, judged.told(place, &made));
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
