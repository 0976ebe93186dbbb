//! Whether objects in which a mistake is likely come out right, or are flagged: eight kinds, five each.
//!
//! `cargo run --release -p kinfold-training --example measure_kinds -- [SEED [EACH [KIND]]]`
//!
//! A line for each object: right or wrong, and flagged where it is wrong, elsewhere or not. Below it, indented,
//! every part that is wrong or flagged: R1 to R5, and, for each joint that turns or slides, how sure it is.
//! Then a table: of each kind how many are right, flagged where wrong, flagged elsewhere alone, neither; and
//! how many parts are flagged in objects that are right in all. The seed is that of judging unless it is given.

#![allow(clippy::print_stdout, reason = "what it measures goes to whoever reads it")]

use std::error::Error;

use model::{Articulation, Prepared};
use training::evaluate::doubts::Judged;
use training::evaluate::solver::links;
use training::procedural::pitfalls::{DESIGNS, JUDGED, PITFALLS, Pitfall, Question};

/// Right; flagged where wrong; flagged elsewhere alone; neither; parts flagged in objects that are right.
type Sum = [usize; 5];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize| arguments.get(at).map(|word| word.parse::<u64>()).transpose();
    let seed = number(0)?.unwrap_or(JUDGED);
    let each = number(1)?.map_or(DESIGNS, |each| each as usize);
    let mut sums: Vec<(&str, Sum)> = Vec::new();
    for kind in PITFALLS.iter().filter(|kind| arguments.get(2).is_none_or(|k| *k == kind.name)) {
        let mut sum = Sum::default();
        for index in 0..each {
            measured(kind, &kind.make(index, seed)?, &mut sum)?;
        }
        sums.push((kind.name, sum));
    }
    println!(
        "kind: right, flagged where wrong, flagged elsewhere, neither; parts flagged in right objects"
    );
    let mut all = Sum::default();
    for (name, sum) in sums {
        println!("{name}: {sum:?}");
        all.iter_mut().zip(sum).for_each(|(all, one)| *all += one);
    }
    println!(
        "all: {all:?}; right or flagged {} of {}",
        all[0] + all[1] + all[2],
        all[..4].iter().sum::<usize>()
    );
    Ok(())
}

/// Articulates an object, tells what became of it and counts that.
fn measured(kind: &Pitfall, question: &Question, sum: &mut Sum) -> Result<(), Box<dyn Error>> {
    let Question { specimen, condition } = question;
    let object = &specimen.object;
    let truth = Articulation {
        object: object.clone(),
        part_of_condition: (0..object.tree().len()).map(Some).collect(),
        notes: Vec::new(),
        confidence: None,
    };
    let (made, _) = Prepared::new(object.mesh())?.articulate(condition, 0)?;
    let truth = links(&truth);
    let judged =
        Judged::of((object.mesh(), object.part_of_face(), &truth), &made, kind.leads_back());
    let (place, word) = if judged.is_right() {
        sum[4] += judged.parts.iter().filter(|part| part.is_flagged()).count();
        (0, "right")
    } else if judged.is_flagged_where_wrong() {
        (1, "wrong, flagged")
    } else if judged.is_flagged() {
        (2, "wrong, flagged elsewhere")
    } else {
        (3, "wrong, not flagged")
    };
    sum[place] += 1;
    let sure = made.confidence.as_ref().map_or(f64::NAN, |sure| sure.object);
    println!("{}: {word} ({}, right with {sure:.2})", specimen.id, condition.category);
    for (place, part) in judged.parts.iter().enumerate() {
        if !part.is_wrong && !part.is_flagged() {
            continue;
        }
        let mut joints = String::new();
        if let (Some(part), Some(sure)) = (made.part_of_condition[place], &made.confidence) {
            for (joint, motion) in sure.parts[part].joints.iter().zip(made.object.joints(part)) {
                let (line, way) = (joint.line.unwrap_or(1.0), joint.way.unwrap_or(1.0));
                let (lower, upper) = motion.range.ends();
                joints += &format!(
                    " axis {:.2} line {line:.2} way {way:.2} from {lower:.2} to {upper:.2}",
                    joint.axis
                );
            }
        }
        let name = &object.tree().parts()[place].name;
        let state = if part.is_wrong { "wrong" } else { "right" };
        println!("  {name}, {state}: {};{joints}", judged.told(place, &made));
    }
    Ok(())
}
