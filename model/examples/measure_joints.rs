//! Measures fitted joints against truth: axis and line error, share found, overlap of ranges.
//!
//! `measure_joints CASES [true|ours] [name part] [worst]` over folders that hold `mesh.glb`,
//! `truth.json` (evalcase/1), `face_labels.u16le` and `condition.json`. `true` fits joints to the
//! true labels, `ours` to those the labeller finds.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use model::geometric::Geometric;
use model::geometric::joints::{Labelled, fit_joints};
use model::{Articulate, Articulation};
use object::weld::Weld;
use object::{ArticulatedObject, Condition, DVec3, JointKind, JointMotion, Mesh, Range};

type Anyhow = Box<dyn std::error::Error>;

/// One joint, found and true.
struct Pair {
    what: String,
    kind: JointKind,
    /// Degrees, sign-free; 90 if not found.
    angle: f64,
    /// Distance of the lines over the largest extent; turns only.
    line: Option<f64>,
    /// Overlap of the two ranges over their union; limited joints only.
    range: Option<f64>,
    found: (f64, f64),
    wanted: (f64, f64),
}

/// A case, its joints and how long they took, seconds.
type Measured = (String, Vec<Pair>, f64);

fn main() -> Result<(), Anyhow> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let text = |i: usize, default: &str| args.get(i).cloned().unwrap_or_else(|| default.into());
    let (root, labels, filter) = (text(0, "."), text(1, "true"), text(2, ""));
    let worst: usize = text(3, "12").parse()?;
    let mut cases: Vec<_> = std::fs::read_dir(root)?.collect::<Result<_, _>>()?;
    cases.sort_by_key(|c| c.file_name());
    let mut sets: BTreeMap<&str, Vec<Measured>> = BTreeMap::new();
    for case in cases {
        let name = case.file_name().to_string_lossy().into_owned();
        if filter.split(',').any(|f| name.contains(f)) {
            let (pairs, seconds) = measure(&case.path(), labels == "true")?;
            sets.entry(set_of(&name)).or_default().push((name, pairs, seconds));
        }
    }
    for (set, cases) in &sets {
        report(set, cases, worst);
    }
    Ok(())
}

fn set_of(case: &str) -> &'static str {
    match case.split("__").next() {
        _ if case.ends_with("-fused") => "fused",
        Some("articraft") => "cad",
        Some("paper") => "paper",
        _ => "simulation",
    }
}

fn measure(case: &Path, true_labels: bool) -> Result<(Vec<Pair>, f64), Anyhow> {
    let mesh = object::glb::read(&std::fs::read(case.join("mesh.glb"))?)?;
    let condition = Condition::from_json(&std::fs::read_to_string(case.join("condition.json"))?)?;
    let truth: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(case.join("truth.json"))?)?;
    let start = Instant::now();
    let found = if true_labels {
        let labels = std::fs::read(case.join("face_labels.u16le"))?;
        let labels = labels.chunks(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
        with_labels(&mesh, &condition, labels)?
    } else {
        Geometric.articulate(&mesh, &condition, 0)?
    };
    let seconds = start.elapsed().as_secs_f64();
    if std::env::var_os("NOTES").is_some() {
        found.notes.iter().for_each(|n| eprintln!("  {}: {}", n.part, n.message));
    }
    Ok((pairs(&mesh, &condition, &truth, &found), seconds))
}

fn with_labels(mesh: &Mesh, c: &Condition, labels: Vec<u16>) -> Result<Articulation, Anyhow> {
    let weld = Weld::new(mesh);
    let (tree, category) = (&c.tree, c.category.as_str());
    let from = Labelled { mesh, weld: &weld, tree, part_of_face: &labels, category };
    let joints = fit_joints(&from, 0);
    let object = ArticulatedObject::new(mesh.clone(), tree.clone(), labels, joints.motions)?;
    let part_of_condition = (0..tree.len()).map(Some).collect();
    Ok(Articulation { object, part_of_condition, notes: joints.notes })
}

fn pairs(mesh: &Mesh, c: &Condition, truth: &serde_json::Value, found: &Articulation) -> Vec<Pair> {
    let largest = mesh.bounds().size().max_element();
    let vector = |v: &serde_json::Value| {
        let at = |i: usize| v[i].as_f64().unwrap_or(0.0);
        mesh.frame().point_to_object(DVec3::new(at(0), at(1), at(2)))
    };
    let mut out = Vec::new();
    for (p, part) in c.tree.parts().iter().enumerate() {
        for (k, &kind) in part.joints.iter().enumerate() {
            let joint = &truth["parts"][p]["joints"][k];
            let (axis, pivot) = (vector(&joint["axis"]).normalize(), vector(&joint["pivot"]));
            let wanted = joint["lower"].as_f64().zip(joint["upper"].as_f64());
            let what = format!("{} ({kind:?})", part.text);
            let new = found.part_of_condition[p];
            let ours = new.and_then(|n| found.object.joints(n).get(k));
            out.push(compare(what, (axis, pivot, wanted), ours, largest, kind));
        }
    }
    out
}

type Truth = (DVec3, DVec3, Option<(f64, f64)>);

fn compare(
    what: String,
    (axis, pivot, wanted): Truth,
    ours: Option<&JointMotion>,
    largest: f64,
    kind: JointKind,
) -> Pair {
    let wanted = wanted.unwrap_or((f64::NAN, f64::NAN));
    let Some(m) = ours else {
        let (line, range, found) = (kind.turns().then_some(1.0), Some(0.0), wanted);
        return Pair { what, kind, angle: 90.0, line, range, found, wanted };
    };
    let cosine = m.axis.dot(axis);
    let found = match m.range {
        Range::Limits { lower, upper } if cosine < 0.0 => (-upper, -lower),
        range => range.ends(),
    };
    let normal = axis.cross(m.axis);
    let apart = m.pivot - pivot;
    let skew = apart.dot(normal.normalize_or_zero()).abs();
    let line = if normal.length() < 1e-6 { apart.reject_from(axis).length() } else { skew };
    let overlap = (found.1.min(wanted.1) - found.0.max(wanted.0)).max(0.0);
    let union = found.1.max(wanted.1) - found.0.min(wanted.0);
    Pair {
        what,
        kind,
        angle: cosine.abs().min(1.0).acos().to_degrees(),
        line: kind.turns().then_some(line / largest),
        range: (kind != JointKind::Continuous && union > 0.0).then(|| overlap / union),
        found,
        wanted,
    }
}

fn report(set: &str, cases: &[(String, Vec<Pair>, f64)], worst: usize) {
    let all: Vec<&Pair> = cases.iter().flat_map(|c| &c.1).collect();
    let near = |p: &Pair| p.angle < 15.0;
    let exact = |p: &Pair| near(p) && p.line.is_none_or(|l| l <= 0.05);
    let share = |f: &dyn Fn(&Pair) -> bool, of: &[&Pair]| {
        100.0 * of.iter().filter(|p| f(p)).count() as f64 / of.len().max(1) as f64
    };
    let objects = |f: &dyn Fn(&[&Pair]) -> f64| {
        let moving: Vec<Vec<&Pair>> = cases.iter().map(|c| c.1.iter().collect()).collect();
        mean(moving.iter().filter(|m| !m.is_empty()).map(|m| f(m)))
    };
    let right = all.iter().filter(|p| exact(p)).filter_map(|p| p.range);
    println!(
        "{set:10} objects {:3}: <=15 {:5.1} % +LE {:5.1} % AE {:4.1} | joints {:3}: <=15 {:5.1} % +LE {:5.1} % AE {:4.1} LE {:.3} | range IoU {:.3}, of right axes {:.3} | s max {:.1} mean {:.2}",
        cases.len(),
        objects(&|o| share(&near, o)),
        objects(&|o| share(&exact, o)),
        objects(&|o| mean(o.iter().map(|p| p.angle))),
        all.len(),
        share(&near, &all),
        share(&exact, &all),
        mean(all.iter().map(|p| p.angle)),
        mean(all.iter().filter_map(|p| p.line)),
        mean(all.iter().filter_map(|p| p.range)),
        mean(right),
        cases.iter().map(|c| c.2).fold(0.0, f64::max),
        mean(cases.iter().map(|c| c.2)),
    );
    let mut wrong: Vec<_> = cases.iter().flat_map(|c| c.1.iter().map(move |p| (&c.0, p))).collect();
    wrong.sort_by(|a, b| {
        let badness =
            |p: &Pair| p.angle / 90.0 + p.line.unwrap_or(0.0) - p.range.unwrap_or(1.0) / 4.0;
        badness(b.1).total_cmp(&badness(a.1))
    });
    for (case, p) in wrong.iter().take(worst) {
        let line = p.line.map_or_else(String::new, |l| format!(" line {l:.2}"));
        let iou = p.range.map_or_else(String::new, |r| format!(" IoU {r:.2}"));
        let ((a, b), (c, d)) = (p.found, p.wanted);
        println!(
            "    {:4.0}°{line}{iou} [{a:.2} {b:.2}] wanted [{c:.2} {d:.2}] {:?} {case} {}",
            p.angle, p.kind, p.what
        );
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(s, n), v| (s + v, n + 1));
    sum / f64::from(count.max(1))
}
