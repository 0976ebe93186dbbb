//! The long run over the real development cases: `cargo test --release --workspace -- --ignored`.
//!
//! Prints one line per case and a summary; the figures in release notes come from here.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use serde_json::Value;

use crate::{cases, clients, examples};

/// What became of one case.
struct Outcome {
    case: String,
    code: Option<i32>,
    tier: String,
    failed: Vec<String>,
    counts_right: bool,
    seconds: f64,
    urdf: PathBuf,
    said: String,
}

impl Outcome {
    fn is_kinematic(&self) -> bool {
        ["kinematic", "dynamic", "audited"].contains(&self.tier.as_str())
    }

    fn line(&self) -> String {
        let counts = if self.counts_right { "" } else { " COUNTS DIFFER" };
        let Self { case, code, tier, failed, seconds, said, .. } = self;
        format!("{tier:10} exit {code:?} {seconds:6.1} s  {case}{counts} {failed:?} {said}")
    }
}

fn read(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or(Value::Null)
}

fn run(case: &Path, out: &Path) -> Outcome {
    let name = case.file_name().unwrap().to_string_lossy().into_owned();
    let target = out.join(&name);
    let photo = cases::photo(case).unwrap();
    let start = Instant::now();
    let mut make = examples::make(case, &photo, &target, &out.join("state").join(&name));
    let output = make.args(["--export", "urdf,mjcf,usd,glb"]).output().unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let verdict = read(&target.join("verdict.json"));
    let bad = |c: &&Value| {
        ["fail", "unknown"].contains(&c["status"].as_str().unwrap_or(""))
            && c["severity"] == "error"
    };
    let failed = verdict["checks"].as_array().into_iter().flatten().filter(bad);
    let failed = failed.map(|c| c["id"].as_str().unwrap_or("?").to_string()).collect();
    let said = if output.status.success() { vec![] } else { output.stderr.clone() };
    let urdf = target.join("asset.urdf");
    Outcome {
        counts_right: urdf.is_file() && counts_agree(&urdf, &read(&case.join("truth.json"))),
        case: name,
        code: output.status.code(),
        tier: verdict["tier"].as_str().unwrap_or("none").into(),
        failed,
        seconds,
        urdf,
        said: String::from_utf8_lossy(&said).trim().replace('\n', " / "),
    }
}

/// Links and moving joints of the URDF against the truth; a part with two motions has one link more.
fn counts_agree(urdf: &Path, truth: &Value) -> bool {
    let text = std::fs::read_to_string(urdf).unwrap_or_default();
    let parts = truth["parts"].as_array().map_or(&[][..], Vec::as_slice);
    let joints = |p: &Value| p["joints"].as_array().map_or(0, Vec::len);
    let between: usize = parts.iter().map(|p| joints(p).saturating_sub(1)).sum();
    let links = text.matches("<link ").count();
    links == parts.len() + between
        && clients::counts(urdf).1 == parts.iter().map(joints).sum::<usize>() as u64
}

/// Every case, two at a time; sorted by name.
fn run_all(cases: Vec<PathBuf>, out: &Path) -> Vec<Outcome> {
    let (queue, done) = (Mutex::new(cases.into_iter()), Mutex::new(Vec::new()));
    let work = || loop {
        let next = queue.lock().unwrap().next();
        let Some(case) = next else { return };
        let outcome = run(&case, out);
        println!("{}", outcome.line());
        done.lock().unwrap().push(outcome);
    };
    std::thread::scope(|s| {
        s.spawn(work);
        s.spawn(work);
    });
    let mut done = done.into_inner().unwrap();
    done.sort_by(|a, b| a.case.cmp(&b.case));
    done
}

#[test]
#[ignore = "half an hour: makes every unfused development case and loads it in three simulators"]
fn the_development_cases_become_checked_assets() {
    let Some(all) = cases::dev_cases() else { return };
    let only = std::env::var("KINFOLD_CASES").unwrap_or_default();
    let is_chosen = |c: &PathBuf| {
        let name = c.file_name().unwrap().to_string_lossy().into_owned();
        !name.ends_with("-fused") && name.contains(&only)
    };
    let keep = std::env::var_os("KINFOLD_KEEP").map(PathBuf::from);
    let temporary = tempfile::tempdir().unwrap();
    let out = keep.unwrap_or_else(|| temporary.path().to_path_buf());
    let outcomes = run_all(all.into_iter().filter(is_chosen).collect(), &out);

    let is_paper = |o: &&Outcome| o.case.starts_with("paper__");
    let paper: Vec<_> = outcomes.iter().filter(is_paper).collect();
    let others: Vec<_> = outcomes.iter().filter(|o| !is_paper(o)).collect();
    let overlaps = ask_clients(&outcomes);
    let papers_done = paper.iter().filter(|o| o.code == Some(0)).count();
    let papers_up = paper.iter().filter(|o| o.is_kinematic()).count();
    let others_up = others.iter().filter(|o| o.is_kinematic() && o.counts_right).count();
    let mut seconds: Vec<_> = outcomes.iter().map(|o| o.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    println!("paper: {papers_done} exit 0, {papers_up} kinematic of {}", paper.len());
    println!("others: {others_up} kinematic with right counts of {}", others.len());
    println!(
        "seconds, two at a time: median {:.1}, worst {:.1}",
        seconds[seconds.len() / 2],
        seconds[seconds.len() - 1]
    );
    let deep: Vec<_> = outcomes
        .iter()
        .filter(|o| o.is_kinematic())
        .filter_map(|o| Some((&o.case, overlaps.get(&o.case).copied().filter(|&d| d > 0.002)?)))
        .collect();
    println!("kinematic with a MuJoCo overlap above 0.2 % of the size: {deep:?}");
    if only.is_empty() {
        assert_eq!(papers_done, paper.len());
        assert!(papers_up >= 11 && others_up >= 80 && deep.is_empty());
    }
}

/// Loads every URDF in every simulator; the deepest overlap MuJoCo saw, as a share of the size.
fn ask_clients(outcomes: &[Outcome]) -> BTreeMap<String, f64> {
    let Some(python) = cases::python() else { return BTreeMap::new() };
    let urdfs: Vec<_> = outcomes.iter().map(|o| o.urdf.clone()).filter(|u| u.is_file()).collect();
    let (mut overlaps, mut wrong) = (BTreeMap::new(), Vec::new());
    for answer in clients::ask(&python, &urdfs) {
        let (shapes, joints) = clients::counts(&answer.file);
        let found = [answer.json["joints"].as_u64(), answer.json["shapes"].as_u64()];
        if found != [Some(joints), Some(shapes)] || shapes == 0 {
            wrong.push(format!("{} {} {}", answer.client, answer.file.display(), answer.json));
        }
        if let Some(depth) = answer.json["sweep_overlap"].as_f64() {
            let folder = answer.file.parent().unwrap();
            let name = folder.file_name().unwrap().to_string_lossy().into_owned();
            let share = depth / size(&answer.file);
            println!("mujoco {:.3} % {name} {}", share * 100.0, answer.json["sweep_pair"]);
            overlaps.insert(name, share);
        }
    }
    println!("loaded: {} URDFs, {} client answers wrong", urdfs.len(), wrong.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
    overlaps
}

/// Largest extent of an asset at rest, metres, from the OBJ files it shows.
fn size(urdf: &Path) -> f64 {
    let asset = read(&urdf.with_file_name("asset.json"));
    let extent = asset["size"]["value"].as_array().into_iter().flatten().filter_map(Value::as_f64);
    extent.fold(0.0, f64::max).max(1e-9)
}
