//! How long labels take after a click of a person who corrects: of each object five clicks, one after the
//! other: a further point, one that is not of a part, a painted patch, a part's point elsewhere, and the
//! `not` points taken back. Where they lie is drawn from a seed.
//!
//! `cargo run --release -p kinfold-training --example measure_clicks -- CASE...`
//!
//! A line for each object: its faces and parts, processor seconds until the first labels, then of each
//! click. At the end the median and the most of all clicks. One thread; Linux alone says its time.

#![allow(clippy::print_stdout, reason = "what it measures goes to whoever reads it")]

use std::collections::BTreeSet;
use std::error::Error;
use std::path::Path;

use model::Prepared;
use object::{Condition, Mesh};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use training::evaluate::case::Case;

/// How far a painted patch goes from its middle, a share of the object's diagonal.
const PATCH: f64 = 0.03;
const CLICKS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut all = Vec::new();
    for folder in std::env::args().skip(1) {
        let case = Case::read(Path::new(&folder)).map_err(|e| e.to_string())?;
        let (first, clicks) = pool.install(|| measured(&case)).map_err(|e| e.to_string())?;
        let told: Vec<String> = clicks.iter().map(|t| format!("{t:.3}")).collect();
        let (faces, parts) = (case.mesh.faces().len(), case.condition.tree.len());
        println!(
            "{} {faces} faces {parts} parts: first {first:.2} s, {}",
            case.name,
            told.join(" ")
        );
        all.extend(clicks);
    }
    all.sort_by(f64::total_cmp);
    if let (Some(median), Some(most)) = (all.get(all.len() / 2), all.last()) {
        println!("{} clicks: median {median:.3} s, most {most:.3} s", all.len());
    }
    Ok(())
}

/// Processor seconds until the first labels, and of every click.
fn measured(case: &Case) -> Result<(f64, Vec<f64>), String> {
    let begun = spent()?;
    let ready = Prepared::new(&case.mesh).map_err(|e| e.to_string())?;
    ready.labels(&case.condition).map_err(|e| e.to_string())?;
    let first = spent()? - begun;
    let mut times = Vec::new();
    for condition in clicks(&case.mesh, &case.condition) {
        let begun = spent()?;
        ready.labels(&condition).map_err(|e| e.to_string())?;
        times.push(spent()? - begun);
    }
    Ok((first, times))
}

/// Processor seconds that this thread has had.
fn spent() -> Result<f64, String> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").map_err(|e| e.to_string())?;
    let nanoseconds = text.split(' ').next().and_then(|n| n.parse::<f64>().ok());
    Ok(nanoseconds.ok_or("no time is told")? * 1e-9)
}

/// Conditions as they follow each other while somebody clicks.
fn clicks(mesh: &Mesh, condition: &Condition) -> Vec<Condition> {
    let mut draws = Pcg64::seed_from_u64(1);
    let mut now = condition.clone();
    let mut all = Vec::new();
    // What contradicts itself is no click: drawn again.
    for _ in 0..20 * CLICKS {
        if all.len() == CLICKS {
            break;
        }
        let part = draws.random_range(0..now.prompts.len());
        let face = draws.random_range(0..mesh.faces().len());
        let next = clicked(mesh, &now, (all.len(), part, face));
        if next != now && next.check_points(mesh).is_ok() {
            now = next;
            all.push(now.clone());
        }
    }
    all
}

fn clicked(mesh: &Mesh, now: &Condition, (kind, part, face): (usize, usize, usize)) -> Condition {
    let mut next = now.clone();
    let point = mesh.centroid(face);
    let prompt = &mut next.prompts[part];
    match kind {
        0 => prompt.also.push(point),
        1 => prompt.not.push(point),
        2 => {
            let reach = PATCH * mesh.bounds().diagonal();
            let taken: BTreeSet<u32> = now.prompts.iter().flat_map(|p| p.faces.iter()).collect();
            let near =
                |f: &u32| mesh.centroid(*f as usize).distance(point) < reach && !taken.contains(f);
            let painted = (0..mesh.faces().len() as u32).filter(near);
            prompt.faces = prompt.faces.iter().chain(painted).collect();
        }
        3 => prompt.point = Some(point),
        _ => next.prompts.iter_mut().for_each(|p| p.not.clear()),
    }
    next
}
