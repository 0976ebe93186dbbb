//! Processor seconds of articulating, building, repairing and writing cases, on one thread, and the digest
//! of what each made: builds that give the same digests may be compared by their times.
//!
//! `cargo run --release -p kinfold-workflow --example measure_stages -- [--truth | --only-articulate] CASE...`
//!
//! A case is a folder of the development sets or one written by `write_cases`; with `--truth` its true
//! parts and joints are built, and nothing is articulated; with `--only-articulate` nothing is built. A line
//! for each: its name, the seconds and first letters of the digest of each stage; at the end the sums. Linux
//! alone says its time.

#![allow(clippy::print_stdout, reason = "what it measures goes to whoever reads it")]

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use asset::{Asset, BuildOptions, build};
use model::{Articulation, Choice, articulator};
use object::{ArticulatedObject, Origin};
use trace::Digest;
use training::evaluate::case::Case;
use training::truth::TruthFile;
use workflow::stages::repair::repaired;

#[global_allocator]
static HEAP: mimalloc::MiMalloc = mimalloc::MiMalloc;

type Failure = Box<dyn Error + Send + Sync>;

const STAGES: [&str; 4] = ["articulate", "build", "repair", "write"];

fn main() -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut sums = [0.0; STAGES.len()];
    let is_asked = |flag: &str| std::env::args().any(|a| a == flag);
    let how = How { truth: is_asked("--truth"), only_articulate: is_asked("--only-articulate") };
    for folder in std::env::args().skip(1).filter(|a| !a.starts_with("--")) {
        let mut clock = Clock { begun: spent()?, done: Vec::new() };
        if let Err(why) = pool.install(|| measured(Path::new(&folder), how, &mut clock)) {
            println!("{folder}: {why}");
        }
        let name = Path::new(&folder).file_name().unwrap_or_default().to_string_lossy();
        let mut line = String::new();
        for (sum, (stage, (took, digest))) in sums.iter_mut().zip(STAGES.iter().zip(&clock.done)) {
            *sum += took;
            write!(line, "{stage} {took:.3} {digest:.8}  ")?;
        }
        println!("{line}{name}");
    }
    let sums: Vec<String> = STAGES.iter().zip(sums).map(|(s, t)| format!("{s} {t:.3}")).collect();
    println!("in all: {}", sums.join("  "));
    Ok(())
}

/// What is measured of each case.
#[derive(Clone, Copy)]
struct How {
    truth: bool,
    only_articulate: bool,
}

struct Clock {
    begun: f64,
    done: Vec<(f64, String)>,
}

impl Clock {
    /// A stage has ended, having made something of these bytes.
    fn tick(&mut self, made: impl FnOnce() -> Vec<u8>) -> Result<(), Failure> {
        let took = spent()? - self.begun;
        self.done.push((took, Digest::of(&made()).to_string()));
        self.begun = spent()?;
        Ok(())
    }
}

fn measured(folder: &Path, how: How, clock: &mut Clock) -> Result<(), Failure> {
    let case = Case::read(folder).map_err(|e| e.to_string())?;
    clock.begun = spent()?;
    let made = if how.truth {
        of_truth(&case)?
    } else {
        articulator(Choice::default()).articulate(&case.mesh, &case.condition, 0)?
    };
    clock.tick(|| object_bytes(&made.object))?;
    if how.only_articulate {
        return Ok(());
    }
    let options = BuildOptions { joints: Origin::Model, ..BuildOptions::default() };
    let asset = build(&made.object, &case.condition, &made.part_of_condition, &options)?;
    clock.tick(|| asset_bytes(&asset))?;
    let scratch = tempfile::tempdir()?;
    let asset = repaired(asset, options.seed, scratch.path())?;
    clock.tick(|| asset_bytes(&asset))?;
    let written = asset_bytes(&asset);
    clock.tick(|| written)
}

/// The true parts and joints.
fn of_truth(case: &Case) -> Result<Articulation, Failure> {
    let text = std::fs::read(case.folder.join("truth.json"))?;
    let motions = TruthFile::from_json(&text)?.motions(case.mesh.frame())?;
    let tree = case.condition.tree.clone();
    let part_of_condition = (0..tree.len()).map(Some).collect();
    let object =
        ArticulatedObject::new(case.mesh.clone(), tree, case.part_of_face.clone(), motions)?;
    Ok(Articulation { object, part_of_condition, notes: Vec::new(), confidence: None })
}

fn object_bytes(object: &ArticulatedObject) -> Vec<u8> {
    let joints: Vec<_> = (0..object.tree().len()).map(|part| object.joints(part)).collect();
    format!("{:?} {joints:?}", object.part_of_face()).into_bytes()
}

fn asset_bytes(asset: &Asset) -> Vec<u8> {
    let mut all = Vec::new();
    for (name, bytes) in &asset.to_urdf().files {
        all.extend_from_slice(name.as_bytes());
        all.extend_from_slice(bytes);
    }
    all.extend_from_slice(asset.to_mjcf().as_bytes());
    all.extend_from_slice(asset.to_usd().as_bytes());
    all.extend(asset.to_glb());
    all
}

/// Processor seconds that this thread has had.
fn spent() -> Result<f64, Failure> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat")?;
    let nanoseconds = text.split(' ').next().and_then(|n| n.parse::<f64>().ok());
    Ok(nanoseconds.ok_or("no time is told")? * 1e-9)
}
