//! What corrections by hand are worth: of every object whose worst part is not well found, that part gets
//! two more points, in the two missed regions that go deepest, and two that are not of it, in the two
//! largest regions that it has wrongly.
//!
//! `cargo run --release -p kinfold-training --example measure_corrections -- CASES [SET [MOST]]`
//!
//! A line for each object: its name, the part, its face IoU by area before and after, seconds of both runs.
//! Then a line for each set: how many objects, and the mean of 1 - IoU before and after.

#![allow(clippy::print_stdout, reason = "what it measures goes to whoever reads it")]

use std::collections::{BTreeMap, BinaryHeap};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

use model::Prepared;
use object::weld::Weld;
use object::{Condition, Mesh};
use training::evaluate::case::{Case, Set, folders};

/// A part is well found from here.
const WELL: f64 = 0.9;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = arguments.first().ok_or("usage: measure_corrections CASES [SET [MOST]]")?;
    let set: Option<Set> = arguments.get(1).map(|word| word.parse()).transpose()?;
    let most = arguments.get(2).map_or(Ok(usize::MAX), |n| n.parse())?;
    let mut sums: BTreeMap<Set, (usize, f64, f64)> = BTreeMap::new();
    let wanted = |folder: &Path| {
        let name = training::evaluate::case::name_of(folder);
        set.is_none_or(|set| Set::of(&name) == set)
    };
    for folder in folders(Path::new(root))?.into_iter().filter(|f| wanted(f)).take(most) {
        let case = Case::read(&folder)?;
        let began = Instant::now();
        let ready = Prepared::new(&case.mesh)?;
        let before = ready.labels(&case.condition)?.part_of_face;
        let first = began.elapsed();
        let (part, was) = worst(&case, &before);
        if was >= WELL {
            println!("{} {was:.3} well found", case.name);
            continue;
        }
        let corrected = corrected(&case, &before, part);
        let began = Instant::now();
        let after = ready.labels(&corrected)?.part_of_face;
        let now = iou(&case, &after, part);
        let name = &case.condition.tree.parts()[part].name;
        let points = (corrected.prompts[part].also.len(), corrected.prompts[part].not.len());
        println!(
            "{} {name} {was:.3} {now:.3} {points:?} {:.1} s {:.1} s",
            case.name,
            first.as_secs_f64(),
            began.elapsed().as_secs_f64()
        );
        let sum = sums.entry(Set::of(&case.name)).or_default();
        *sum = (sum.0 + 1, sum.1 + 1.0 - was, sum.2 + 1.0 - now);
    }
    for (set, (count, before, after)) in sums {
        let mean = |sum: f64| sum / count as f64;
        println!(
            "{}: {count} objects, 1 - IoU {:.4} to {:.4}",
            set.name(),
            mean(before),
            mean(after)
        );
    }
    Ok(())
}

/// Faces of a part in common with the truth, as a share of those of either, by area.
fn iou(case: &Case, labels: &[u16], part: usize) -> f64 {
    let (mut both, mut either) = (0.0, f64::MIN_POSITIVE);
    for (face, (found, truth)) in labels.iter().zip(&case.part_of_face).enumerate() {
        let [found, truth] = [*found, *truth].map(|p| usize::from(p) == part);
        let area = case.mesh.area(face);
        both += if found && truth { area } else { 0.0 };
        either += if found || truth { area } else { 0.0 };
    }
    both / either
}

fn worst(case: &Case, labels: &[u16]) -> (usize, f64) {
    let parts = 0..case.condition.tree.len();
    let scored = parts.map(|part| (part, iou(case, labels, part)));
    scored.fold((0, f64::INFINITY), |worst, next| if next.1 < worst.1 { next } else { worst })
}

/// The condition with points in what was missed, and where it was wrongly found.
fn corrected(case: &Case, labels: &[u16], part: usize) -> Condition {
    let is_part = |label: &u16| usize::from(*label) == part;
    let pairs = || labels.iter().zip(&case.part_of_face);
    let missed: Vec<bool> =
        pairs().map(|(found, truth)| !is_part(found) && is_part(truth)).collect();
    let wrong: Vec<bool> =
        pairs().map(|(found, truth)| is_part(found) && !is_part(truth)).collect();
    let centre = |face: &u32| case.mesh.centroid(*face as usize);
    let mut corrected = case.condition.clone();
    let prompt = &mut corrected.prompts[part];
    let mut missed = regions(&case.mesh, &missed);
    missed.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    let points: Vec<_> = missed.iter().take(2).map(|r| centre(&r.deepest)).collect();
    let mut points = points.into_iter();
    if prompt.point.is_none() {
        prompt.point = points.next();
    }
    prompt.also.extend(points);
    let mut wrong = regions(&case.mesh, &wrong);
    wrong.sort_by(|a, b| b.area.total_cmp(&a.area));
    prompt.not.extend(wrong.iter().take(2).map(|r| centre(&r.deepest)));
    corrected
}

/// Connected faces of a kind.
struct Region {
    area: f64,
    /// The face farthest from all others, and how far, from centre to centre.
    deepest: u32,
    depth: f64,
}

fn regions(mesh: &Mesh, chosen: &[bool]) -> Vec<Region> {
    let weld = Weld::new(mesh);
    let mut beside = vec![Vec::new(); chosen.len()];
    for pair in weld.neighbours() {
        beside[pair.first as usize].push(pair.second);
        beside[pair.second as usize].push(pair.first);
    }
    let depth = depths(mesh, chosen, &beside);
    let (mut seen, mut regions) = (vec![false; chosen.len()], Vec::new());
    for start in 0..chosen.len() {
        if !chosen[start] || seen[start] {
            continue;
        }
        seen[start] = true;
        let mut faces = vec![start as u32];
        let mut next = 0;
        while let Some(&face) = faces.get(next) {
            next += 1;
            for &other in &beside[face as usize] {
                if chosen[other as usize] && !seen[other as usize] {
                    seen[other as usize] = true;
                    faces.push(other);
                }
            }
        }
        let area: f64 = faces.iter().map(|f| mesh.area(*f as usize)).sum();
        let deep = |face: &u32| depth[*face as usize];
        let deepest = faces.iter().copied().max_by(|a, b| deep(a).total_cmp(&deep(b)));
        let deepest = deepest.unwrap_or(start as u32);
        // A region without a border goes as deep as it is wide.
        let depth = if deep(&deepest).is_finite() { deep(&deepest) } else { area.sqrt() };
        regions.push(Region { area, deepest, depth });
    }
    regions
}

/// For each chosen face, the way over the surface to the nearest that is not.
fn depths(mesh: &Mesh, chosen: &[bool], beside: &[Vec<u32>]) -> Vec<f64> {
    let mut depth: Vec<f64> = chosen.iter().map(|c| if *c { f64::INFINITY } else { 0.0 }).collect();
    let key = |d: f64| std::cmp::Reverse(d.to_bits());
    let mut heap: BinaryHeap<_> =
        (0..chosen.len() as u32).filter(|f| !chosen[*f as usize]).map(|f| (key(0.0), f)).collect();
    while let Some((std::cmp::Reverse(bits), face)) = heap.pop() {
        let here = f64::from_bits(bits);
        if here > depth[face as usize] {
            continue;
        }
        for &other in &beside[face as usize] {
            let step = mesh.centroid(face as usize).distance(mesh.centroid(other as usize));
            if here + step < depth[other as usize] {
                depth[other as usize] = here + step;
                heap.push((key(here + step), other));
            }
        }
    }
    depth
}
