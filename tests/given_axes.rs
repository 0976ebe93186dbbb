//! A true axis and its place, given by hand, stand in all four formats: over every development case.
//!
//! `KINFOLD_SHARED` has the cases, `KINFOLD_CASES` chooses among their names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use asset::{Asset, BuildOptions, build};
use glamx::DQuat;
use model::{Choice, articulator};
use object::condition::GivenJoint;
use object::{DVec3, Origin};
use serde_json::Value;
use sim_check::CheckOptions;
use sim_check::read::load;
use training::evaluate::case::Case;
use training::truth::TruthFile;
use workflow::stages::repair::repaired;

use crate::cases;

/// An axis and its place are exported as they were given to within this: a share of unit length, metres.
const EXACT: f64 = 1e-6;

/// Direction and a point of an axis in the asset's frame, metres; of a slide the direction alone.
#[derive(Clone, Copy, Debug)]
struct Line {
    axis: DVec3,
    point: Option<DVec3>,
}

impl Line {
    /// How far another line is from this one: directions, and the way from point to line.
    fn off(&self, other: &Self) -> f64 {
        let turned = self.axis.distance(other.axis);
        let moved = match (self.point, other.point) {
            (Some(a), Some(b)) => (b - a).cross(self.axis).length(),
            _ => 0.0,
        };
        turned.max(moved)
    }
}

#[derive(Default)]
struct Tally {
    objects: usize,
    joints: usize,
    lost: usize,
    wrong: Vec<String>,
    farthest: BTreeMap<&'static str, f64>,
}

/// The case with every true axis and pivot in its condition; nothing where its joints are others.
fn given(folder: &Path, case: &mut Case) -> Option<()> {
    let truth = std::fs::read(folder.join("truth.json")).ok()?;
    let motions = TruthFile::from_json(&truth).ok()?.motions(case.mesh.frame()).ok()?;
    for (part, (prompt, motions)) in case.condition.prompts.iter_mut().zip(&motions).enumerate() {
        let kinds: Vec<_> = motions.iter().map(|m| m.kind).collect();
        if case.condition.tree.parts()[part].joints != kinds {
            return None;
        }
        let of = |m: &object::JointMotion| GivenJoint {
            axis: Some(m.axis),
            pivot: Some(m.pivot),
            ..GivenJoint::default()
        };
        prompt.joints = motions.iter().map(of).collect();
    }
    Some(())
}

/// What was given of each joint of the asset, by its name, in the asset's frame.
fn expected(
    asset: &Asset,
    case: &Case,
    part_of_condition: &[Option<usize>],
) -> BTreeMap<String, Line> {
    let mut lines = BTreeMap::new();
    for (part, now) in part_of_condition.iter().enumerate() {
        let Some(now) = *now else { continue };
        let own =
            asset.joints.iter().filter(|j| j.motion.is_some() && asset.links[j.child].part == now);
        for (joint, given) in own.zip(&case.condition.prompts[part].joints) {
            let turns = case.condition.tree.parts()[part].joints.len() == 1
                && case.condition.tree.parts()[part].joints[0].turns();
            let place = |p: DVec3| asset.turn * (asset.scale.value * p) + asset.offset;
            let point = given.pivot.map(place).filter(|_| turns);
            lines
                .insert(joint.name.clone(), Line { axis: asset.turn * given.axis.unwrap(), point });
        }
    }
    lines
}

/// Joints of a URDF or MJCF model, as the checker reads it.
fn of_model(path: &Path) -> BTreeMap<String, Line> {
    let robot = load::read(path, &CheckOptions::default()).robot.expect("a model");
    let poses = robot.link_poses(&vec![0.0; robot.joints.len()]);
    let line = |j: &sim_check::robot::Joint| {
        let pose = poses[j.child];
        let line = Line { axis: pose.rotation * j.axis, point: Some(pose.translation) };
        (j.name.clone(), line)
    };
    robot.joints.iter().filter(|j| j.kind.moves()).map(line).collect()
}

/// Joints of a USD stage, by the lines that its joints and links are written in.
fn of_usd(text: &str) -> BTreeMap<String, Line> {
    let numbers = |line: &str| -> Vec<f64> {
        let inside = line.rsplit_once('(').unwrap().1.trim_end_matches(')');
        inside.split(',').map(|n| n.trim().parse().unwrap()).collect()
    };
    let vector = |line: &str| DVec3::from_slice(&numbers(line));
    let (mut links, mut lines) = (BTreeMap::new(), BTreeMap::new());
    let (mut prim, mut is_joint, mut body) = (String::new(), false, String::new());
    let mut at = DVec3::ZERO;
    for line in text.lines().map(str::trim) {
        if line.starts_with("def ") {
            is_joint = line.starts_with("def PhysicsRevoluteJoint")
                || line.starts_with("def PhysicsPrismaticJoint");
            prim = line.split('"').nth(1).unwrap_or_default().to_owned();
        } else if line.starts_with("double3 xformOp:translate") {
            links.entry(prim.clone()).or_insert_with(|| vector(line));
        } else if is_joint && line.starts_with("rel physics:body0") {
            body = line.trim_end_matches('>').rsplit('/').next().unwrap().to_owned();
        } else if is_joint && line.starts_with("point3f physics:localPos0") {
            at = vector(line);
        } else if is_joint && line.starts_with("quatf physics:localRot0") {
            let q = numbers(line);
            let turn = DQuat::from_xyzw(q[1], q[2], q[3], q[0]).normalize();
            let place = links[&body] + at;
            lines.insert(prim.clone(), Line { axis: turn * DVec3::X, point: Some(place) });
        }
    }
    lines
}

/// Joints of a GLB, by what its animations do to nodes: y up, turned back.
fn of_glb(bytes: &[u8]) -> BTreeMap<String, Line> {
    let long = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&bytes[20..20 + long(12)]).unwrap();
    let data = &bytes[28 + long(12)..];
    let accessor = |i: &Value| -> Vec<f64> {
        let accessor = &json["accessors"][i.as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let at = |v: &Value| v["byteOffset"].as_u64().unwrap_or(0) as usize;
        let width = if accessor["type"] == "VEC4" { 4 } else { 3 };
        let count = width * accessor["count"].as_u64().unwrap() as usize;
        let start = at(view) + at(accessor);
        let float = |i: usize| {
            let from = start + 4 * i;
            f64::from(f32::from_le_bytes(data[from..from + 4].try_into().unwrap()))
        };
        (0..count).map(float).collect()
    };
    let upright = |v: DVec3| DVec3::new(v.x, -v.z, v.y);
    let nodes = json["nodes"].as_array().unwrap();
    let own = |n: usize| {
        let all: Vec<f64> = nodes[n]["translation"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_f64)
            .collect();
        if all.is_empty() { DVec3::ZERO } else { DVec3::from_slice(&all) }
    };
    let parent = |n: usize| {
        let holds = |p: &Value| p["children"].as_array().is_some_and(|c| c.iter().any(|c| *c == n));
        nodes.iter().position(holds)
    };
    let place = |n: usize| {
        let mut sum = DVec3::ZERO;
        let mut at = Some(n);
        while let Some(n) = at {
            sum += own(n);
            at = parent(n);
        }
        sum
    };
    let mut lines = BTreeMap::new();
    for animation in json["animations"].as_array().into_iter().flatten() {
        let channel = &animation["channels"][0];
        let node = channel["target"]["node"].as_u64().unwrap() as usize;
        let sampler = &animation["samplers"][channel["sampler"].as_u64().unwrap() as usize];
        let values = accessor(&sampler["output"]);
        let slides = channel["target"]["path"] == "translation";
        let moves: Vec<DVec3> = match slides {
            true => values.chunks(3).map(|v| DVec3::from_slice(v) - own(node)).collect(),
            // The way of the axis is that of the positive angle, also beyond a half turn.
            false => values
                .chunks(4)
                .map(|q| DVec3::from_slice(q) * if q[3] < 0.0 { -1.0 } else { 1.0 })
                .collect(),
        };
        let farthest =
            moves.into_iter().fold(DVec3::ZERO, |a, b| if b.length() > a.length() { b } else { a });
        let axis = upright(farthest).normalize_or_zero();
        let name = animation["name"].as_str().unwrap().to_owned();
        lines.insert(name, Line { axis, point: Some(upright(place(node))) });
    }
    lines
}

fn look(folder: &Path, tally: &Mutex<Tally>) -> Result<(), String> {
    let mut case = Case::read(folder).map_err(|e| e.to_string())?;
    let Some(()) = given(folder, &mut case) else { return Err("its joints are others".into()) };
    let model = articulator(Choice::default());
    let made = model.articulate(&case.mesh, &case.condition, 0).map_err(|e| e.to_string())?;
    let options = BuildOptions { joints: Origin::Model, ..BuildOptions::default() };
    let asset = build(&made.object, &case.condition, &made.part_of_condition, &options);
    let scratch = tempfile::tempdir().unwrap();
    let asset = repaired(asset.map_err(|e| e.to_string())?, options.seed, scratch.path());
    let asset = asset.map_err(|e| e.to_string())?;
    let expected = expected(&asset, &case, &made.part_of_condition);
    for (name, bytes) in &asset.to_urdf().files {
        let path = scratch.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    std::fs::write(scratch.path().join("asset.xml"), asset.to_mjcf()).unwrap();
    let found = [
        ("urdf", of_model(&scratch.path().join("asset.urdf"))),
        ("mjcf", of_model(&scratch.path().join("asset.xml"))),
        ("usd", of_usd(&asset.to_usd())),
        ("glb", of_glb(&asset.to_glb())),
    ];
    let mut tally = tally.lock().unwrap();
    tally.objects += 1;
    let all: usize = case.condition.prompts.iter().map(|p| p.joints.len()).sum();
    tally.lost += all - expected.len();
    tally.joints += expected.len();
    for (name, said) in &expected {
        for (format, lines) in &found {
            let off = lines.get(name).map_or(f64::INFINITY, |line| {
                // An animation says which line it is, and which way only where it goes one way.
                let back = Line { axis: -line.axis, ..*line };
                let either = if *format == "glb" { said.off(&back) } else { f64::INFINITY };
                said.off(line).min(either)
            });
            let slot = tally.farthest.entry(format).or_default();
            *slot = slot.max(off);
            if off > EXACT {
                tally.wrong.push(format!("{} {name} in {format}: {off:e}", case.name));
            }
        }
    }
    Ok(())
}

#[test]
#[ignore = "half an hour: articulates and builds every development case"]
fn a_true_axis_and_pivot_given_by_hand_stand_in_all_four_formats() {
    let only = std::env::var("KINFOLD_CASES").unwrap_or_default();
    let name = |c: &PathBuf| c.file_name().unwrap().to_string_lossy().into_owned();
    let mut all = cases::dev_cases().unwrap_or_default();
    all.retain(|c| name(c).contains(&only));
    let (tally, queue) = (Mutex::new(Tally::default()), Mutex::new(all.into_iter()));
    let work = || loop {
        let next = queue.lock().unwrap().next();
        let Some(case) = next else { return };
        if let Err(why) = look(&case, &tally) {
            println!("left out  {} {why}", name(&case));
        }
    };
    std::thread::scope(|s| {
        s.spawn(work);
        s.spawn(work);
    });
    let tally = tally.into_inner().unwrap();
    println!(
        "{} objects, {} joints, {} of parts without a face; farthest {:?}",
        tally.objects, tally.joints, tally.lost, tally.farthest
    );
    assert!(tally.wrong.is_empty(), "{:#?}", tally.wrong);
}
