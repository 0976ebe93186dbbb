//! Measures the labeller: `measure_labels [SHARED] [FILTER] [WORST]`, on the development cases.
//!
//! For each set, the mean over objects of the mean over parts of the IoU of faces by area, and of
//! the generalised IoU of the parts' boxes; parts are matched by name. Then the worst cases.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use model::geometric::labels::label_faces;
use object::mesh::Bounds;
use object::weld::Weld;
use object::{Condition, DVec3, Mesh};
use rayon::prelude::*;

type Failure = Box<dyn Error + Send + Sync>;

/// One development case: its mesh, its condition and the true part of each face.
struct Case {
    mesh: Mesh,
    condition: Condition,
    truth: Vec<u16>,
}

struct Score {
    name: String,
    faces: f64,
    boxes: f64,
    seconds: f64,
}

fn main() -> Result<(), Failure> {
    let mut args = std::env::args().skip(1);
    let shared = args.next().or_else(|| std::env::var("KINFOLD_SHARED").ok());
    let shared = shared.unwrap_or_else(|| "../shared".into());
    let (filter, worst) = (args.next().unwrap_or_default(), args.next());
    let worst = worst.map_or(Ok(10), |w| w.parse())?;
    let root = PathBuf::from(shared).join("data/cases/dev");
    if !root.is_dir() {
        eprintln!("SKIPPED: no cases at {}", root.display());
        return Ok(());
    }
    let entries = std::fs::read_dir(&root)?.collect::<Result<Vec<_>, _>>()?;
    let mut folders: Vec<PathBuf> = entries.iter().map(|e| e.path()).collect();
    folders.retain(|f| f.is_dir() && name_of(f).contains(&filter));
    folders.sort();
    let scores = folders.par_iter().map(|f| score(f)).collect::<Result<Vec<_>, _>>()?;
    for set in ["cad", "simulation", "fused", "paper"] {
        report(set, scores.iter().filter(|s| set_of(&s.name) == set).collect(), worst);
    }
    Ok(())
}

fn report(set: &str, mut scores: Vec<&Score>, worst: usize) {
    if scores.is_empty() {
        return;
    }
    let mean =
        |of: fn(&Score) -> f64| scores.iter().map(|s| of(s)).sum::<f64>() / scores.len() as f64;
    let longest = scores.iter().map(|s| s.seconds).fold(0.0, f64::max);
    let (faces, boxes) = (mean(|s| s.faces), mean(|s| s.boxes));
    println!(
        "{set:10} {:3}  mIoU {faces:.3}  gIoU {boxes:.3}  longest {longest:.2} s",
        scores.len()
    );
    scores.sort_by(|a, b| a.faces.total_cmp(&b.faces));
    for s in scores.iter().take(worst) {
        println!("    {:.3} {:6.3} {:5.2} s  {}", s.faces, s.boxes, s.seconds, s.name);
    }
}

fn score(folder: &Path) -> Result<Score, Failure> {
    let name = name_of(folder);
    let case = read(folder).map_err(|e| format!("{name}: {e}"))?;
    let start = Instant::now();
    let labels = label_faces(&case.mesh, &case.condition, &Weld::new(&case.mesh)).part_of_face;
    let seconds = start.elapsed().as_secs_f64();
    Ok(Score { name, faces: face_iou(&case, &labels), boxes: box_giou(&case, &labels), seconds })
}

fn read(folder: &Path) -> Result<Case, Failure> {
    let mesh = object::glb::read(&std::fs::read(folder.join("mesh.glb"))?)?;
    let text = std::fs::read_to_string(folder.join("condition.json"))?;
    let condition = Condition::from_json(&text)?;
    let bytes = std::fs::read(folder.join("face_labels.u16le"))?;
    let truth: Vec<u16> = bytes.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
    if truth.len() != mesh.faces().len() {
        return Err(format!("{} labels for {} faces", truth.len(), mesh.faces().len()).into());
    }
    Ok(Case { mesh, condition, truth })
}

fn name_of(folder: &Path) -> String {
    folder.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned())
}

fn set_of(name: &str) -> &'static str {
    match name {
        n if n.starts_with("paper__") => "paper",
        n if n.ends_with("-fused") => "fused",
        n if n.starts_with("articraft__") => "cad",
        _ => "simulation",
    }
}

/// Mean over the true parts of the IoU of their faces, by area.
fn face_iou(case: &Case, labels: &[u16]) -> f64 {
    let parts = case.condition.tree.len();
    let (mut both, mut truth, mut found) = (vec![0.0; parts], vec![0.0; parts], vec![0.0; parts]);
    for (face, (&t, &l)) in case.truth.iter().zip(labels).enumerate() {
        let area = case.mesh.area(face);
        truth[usize::from(t)] += area;
        found[usize::from(l)] += area;
        both[usize::from(t)] += if t == l { area } else { 0.0 };
    }
    let iou = |p: usize| both[p] / (truth[p] + found[p] - both[p]);
    let present: Vec<f64> = (0..parts).filter(|&p| truth[p] > 0.0).map(iou).collect();
    present.iter().sum::<f64>() / present.len() as f64
}

/// Mean over the true parts of the generalised IoU of boxes; −1 for a part that got no face.
fn box_giou(case: &Case, labels: &[u16]) -> f64 {
    let of = |labels: &[u16], part: usize| {
        let faces = labels.iter().enumerate().filter(move |(_, l)| usize::from(**l) == part);
        Bounds::of(faces.flat_map(|(f, _)| case.mesh.corners(f)))
    };
    let empty = |b: &Bounds| b.size().min_element() < 0.0;
    let value = |p: usize| match (of(&case.truth, p), of(labels, p)) {
        (t, _) if empty(&t) => None,
        (_, f) if empty(&f) => Some(-1.0),
        (t, f) => Some(giou(&t, &f)),
    };
    let values: Vec<f64> = (0..case.condition.tree.len()).filter_map(value).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

fn giou(a: &Bounds, b: &Bounds) -> f64 {
    let volume = |min: DVec3, max: DVec3| (max - min).max(DVec3::splat(1e-9)).element_product();
    let (low, high) = (a.min.max(b.min), a.max.min(b.max));
    let both = if low.cmple(high).all() { volume(low, high) } else { 0.0 };
    let either = volume(a.min, a.max) + volume(b.min, b.max) - both;
    let around = volume(a.min.min(b.min), a.max.max(b.max));
    both / either - (around - either) / around
}
