//! Depths, masses and motions are what MuJoCo and Pinocchio say they are, on assets of every kind.
//!
//! `KINFOLD_ASSETS` names a folder of made assets (one folder each) to be asked about besides the
//! corpus and the examples.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use glamx::{DMat3, DVec3};
use rand::{RngExt, SeedableRng};
use serde_json::{Value, json};
use sim_check::checks::dynamics::world::{Base, Effort, RATE, Setup, Sim, Touch};
use sim_check::checks::sweep::Scene;
use sim_check::checks::sweep::overlap::overlaps;
use sim_check::mass::lump::Lump;
use sim_check::{CheckOptions, Robot};

use crate::{cases, clients, corpus, examples};

/// Depths agree within this, metres, or within this share.
const DEPTH: (f64, f64) = (0.0005, 0.02);
/// Relative difference of a motion under a known torque.
const MOTION: f64 = 0.01;
/// Relative difference of mass and inertia, and of the centre of mass in sizes of the asset.
const MASS: f64 = 1e-4;

type Depths = BTreeMap<String, f64>;

/// What is asked about one asset: poses that make parts overlap, and a way for each joint.
struct Question {
    file: PathBuf,
    robot: Robot,
    poses: Vec<Vec<f64>>,
    travels: Vec<(usize, f64)>,
}

impl Question {
    fn new(file: PathBuf) -> Self {
        let loaded = sim_check::read::load::read(&file, &CheckOptions::default());
        let robot =
            loaded.robot.unwrap_or_else(|| panic!("{}: {:?}", file.display(), loaded.checks));
        let scene = Scene::new(&robot).unwrap();
        let poses = poses(&scene);
        let travels = scene.drives.iter().map(|d| (d.joint, travel(d))).collect();
        Self { file, robot, poses, travels }
    }

    fn json(&self) -> Value {
        let name = |j: usize| self.robot.joints[j].name.clone();
        let moving = |q: &[f64]| -> BTreeMap<String, f64> {
            let joints = self.robot.joints.iter().enumerate();
            let moving = joints.filter(|(_, joint)| joint.kind.moves());
            moving.map(|(j, _)| (name(j), q[j])).collect()
        };
        let poses: Vec<_> = self.poses.iter().map(|q| moving(q)).collect();
        let drives: BTreeMap<_, _> = self.travels.iter().map(|&(j, t)| (name(j), t)).collect();
        json!({ "file": self.file, "poses": poses, "drives": drives })
    }
}

/// Rest; every drive beyond both ends by a tenth and by half of its range; and eight poses with all
/// of them anywhere in twice their range.
fn poses(scene: &Scene) -> Vec<Vec<f64>> {
    let mut poses = vec![scene.rest()];
    for (d, drive) in scene.drives.iter().enumerate() {
        let span = drive.upper - drive.lower;
        let beyond = |share: f64| [drive.lower - share * span, drive.upper + share * span];
        poses
            .extend([beyond(0.1), beyond(0.5)].concat().into_iter().map(|q| scene.with(&[(d, q)])));
    }
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(7);
    for _ in 0..8 {
        let anywhere = scene.drives.iter().enumerate().map(|(d, drive)| {
            let span = drive.upper - drive.lower;
            (d, drive.lower - span / 2.0 + 2.0 * span * rng.random_range(0.0..1.0))
        });
        poses.push(scene.with(&anywhere.collect::<Vec<_>>()));
    }
    poses
}

/// Half the way to the farther end, and no more than half a radian or metre.
fn travel(drive: &sim_check::checks::sweep::bodies::Drive) -> f64 {
    let end = if drive.upper >= -drive.lower { drive.upper } else { drive.lower };
    (end / 2.0).clamp(-0.5, 0.5)
}

/// Depth of every two bodies that overlap, by the names of their first links.
fn depths(scene: &Scene, q: &[f64]) -> Depths {
    let mut found = Depths::new();
    for overlap in overlaps(scene, q, |_, _| true) {
        let body = |p: usize| scene.bodies[scene.pieces[p].body].link;
        let mut names = overlap.pieces.map(|p| scene.robot.links[body(p)].name.as_str());
        names.sort_unstable();
        let depth = found.entry(names.join("|")).or_default();
        *depth = depth.max(overlap.depth);
    }
    found
}

/// Where a joint is after a second under a steady effort, everything else held.
fn pushed(scene: &Scene, joint: usize, effort: f64) -> f64 {
    let (base, touch, gravity) = (Base::Fixed, Touch::Nothing, DVec3::ZERO);
    let (solver, welded) = (Effort::USUAL, vec![]);
    let setup = Setup { base, rate: RATE, touch, effort: solver, gravity, q: scene.rest(), welded };
    let mut sim = Sim::new(scene, &setup).unwrap();
    let dynamics = scene.robot.joints[joint].dynamics;
    sim.rub(joint, 0.0, dynamics.and_then(|d| d.damping).unwrap_or(0.0));
    sim.push(joint, effort);
    for _ in 0..RATE as usize {
        let others = (0..scene.robot.joints.len()).filter(|&j| j != joint);
        others.for_each(|j| sim.hold(j, setup.q[j]));
        sim.step();
    }
    sim.value(joint)
}

/// What was compared and what differs.
#[derive(Default)]
struct Tally {
    overlaps: usize,
    deepest_difference: f64,
    motions: usize,
    widest_motion: f64,
    masses: usize,
    heaviest: f64,
    differences: Vec<String>,
}

impl Tally {
    fn depths(&mut self, whose: &str, ours: &Depths, theirs: &Depths) {
        let pairs: std::collections::BTreeSet<_> = ours.keys().chain(theirs.keys()).collect();
        for pair in pairs {
            let [a, b] = [ours, theirs].map(|d| d.get(pair).copied().unwrap_or(0.0));
            let apart = (a - b).abs();
            self.overlaps += 1;
            self.deepest_difference = self.deepest_difference.max(apart);
            if apart > DEPTH.0.max(DEPTH.1 * b) {
                self.differences.push(format!("{whose}: {pair} {a:.6} m, they say {b:.6} m"));
            }
        }
    }

    fn masses(&mut self, whose: &str, ours: &Lump, theirs: &Value, size: f64) {
        let numbers = |key: &str| -> Vec<f64> {
            theirs[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
        };
        let inertia = DMat3::from_cols_slice(&numbers("inertia"));
        let largest =
            |m: DMat3| m.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let mass = theirs["mass"].as_f64().unwrap();
        let differences = [
            (ours.mass - mass).abs() / mass,
            largest(ours.inertia - inertia) / largest(inertia),
            ours.com.distance(DVec3::from_slice(&numbers("centre"))) / size,
        ];
        let worst = differences.into_iter().fold(0.0, f64::max);
        self.masses += 1;
        self.heaviest = self.heaviest.max(worst);
        if worst.is_nan() || worst > MASS {
            self.differences.push(format!("{whose}: mass, inertia, centre {differences:?}"));
        }
    }

    fn motion(&mut self, whose: &str, ours: f64, theirs: f64) {
        let apart = (ours / theirs - 1.0).abs();
        self.motions += 1;
        self.widest_motion = self.widest_motion.max(apart);
        if apart.is_nan() || apart > MOTION {
            self.differences.push(format!("{whose}: moves {ours:.6}, they say {theirs:.6}"));
        }
    }

    fn compare(&mut self, question: &Question, answer: &Value) {
        let scene = Scene::new(&question.robot).unwrap();
        let file = question.file.display();
        let whose = format!("{} {file}", answer["client"].as_str().unwrap());
        assert_eq!(answer["error"], Value::Null, "{whose}: {answer}");
        for (k, q) in question.poses.iter().enumerate() {
            let theirs: Depths = serde_json::from_value(answer["depths"][k].clone()).unwrap();
            self.depths(&format!("{whose} pose {k}"), &depths(&scene, q), &theirs);
        }
        let poses = question.robot.link_poses(&vec![0.0; question.robot.joints.len()]);
        let lump = Lump::of_links(&question.robot, 0..poses.len(), &poses);
        self.masses(&whose, &lump, answer, scene.diagonal);
        for (name, run) in answer["pushed"].as_object().into_iter().flatten() {
            let joint = question.robot.joints.iter().position(|j| j.name == *name).unwrap();
            let ours = pushed(&scene, joint, run[0].as_f64().unwrap());
            self.motion(&format!("{whose} joint {name}"), ours, run[1].as_f64().unwrap());
        }
    }
}

/// Every asset at hand: the good ones of the corpus, the examples, and what `KINFOLD_ASSETS` holds.
fn assets(folder: &Path) -> Vec<PathBuf> {
    let mut files = corpus::written(folder);
    files.extend(examples::made(&folder.join("examples")));
    files.extend(clients::more_assets().into_iter().map(|folder| folder.join("asset.urdf")));
    files
}

#[test]
fn depths_masses_and_motions_are_what_mujoco_and_pinocchio_say() {
    let Some(python) = cases::python_with("mujoco, pinocchio, coal") else { return };
    let folder = tempfile::tempdir().unwrap();
    let questions: Vec<_> = assets(folder.path()).into_iter().map(Question::new).collect();
    let lines: Vec<_> = questions.iter().map(|q| q.json().to_string()).collect();
    let asked = folder.path().join("questions.jsonl");
    std::fs::write(&asked, lines.join("\n")).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/agreement.py");
    let output = Command::new(python).arg(script).arg(&asked).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut tally = Tally::default();
    for (k, line) in String::from_utf8(output.stdout).unwrap().lines().enumerate() {
        tally.compare(&questions[k / 2], &serde_json::from_str(line).unwrap());
    }
    eprintln!(
        "{} assets: {} overlaps, {:.4} mm apart at most; {} motions, {:.3} %; {} masses, {:.1e}",
        questions.len(),
        tally.overlaps,
        1000.0 * tally.deepest_difference,
        tally.motions,
        100.0 * tally.widest_motion,
        tally.masses,
        tally.heaviest,
    );
    let different = &tally.differences;
    assert!(different.is_empty(), "{} differ:\n{}", different.len(), different.join("\n"));
    assert!(tally.masses == 2 * questions.len() && tally.motions > 0 && tally.overlaps > 0);
}
