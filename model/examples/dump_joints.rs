//! Dumps every candidate axis of labelled objects with its numbers, to fit the score table.
//!
//! `dump_joints OUT [plain|skin|stretched] CASES…`: folders with `mesh.glb`, `truth.json` and
//! `face_labels.u16le`. `skin` drops faces nobody sees from outside, as generators do; `stretched`
//! scales the three world axes by different factors and keeps slides only, which stay true.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::io::{BufWriter, Write};
use std::path::Path;

use model::geometric::joints::{Labelled, candidates, endless};
use model::geometric::scene::Scene;
use model::geometric::setting::Setting;
use object::weld::Weld;
use object::{DVec3, JointKind, KinematicTree, Mesh, Part};
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

type Anyhow = Box<dyn std::error::Error>;

fn main() -> Result<(), Anyhow> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [out, mode, cases @ ..] = &args[..] else { return Err("OUT MODE CASES…".into()) };
    let mut out = BufWriter::new(std::fs::File::create(out)?);
    for (i, case) in cases.iter().enumerate() {
        if let Err(e) = dump(&mut out, mode, Path::new(case), i) {
            eprintln!("{case}: {e}");
        }
        eprint!(".");
    }
    Ok(())
}

struct Case {
    mesh: Mesh,
    labels: Vec<u16>,
    truth: serde_json::Value,
    stretch: DVec3,
}

fn read(dir: &Path, mode: &str, index: usize) -> Result<Case, Anyhow> {
    let mesh = object::glb::read(&std::fs::read(dir.join("mesh.glb"))?)?;
    let labels = std::fs::read(dir.join("face_labels.u16le"))?;
    let labels: Vec<u16> = labels.chunks(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
    let truth = serde_json::from_str(&std::fs::read_to_string(dir.join("truth.json"))?)?;
    let whole = Case { mesh, labels, truth, stretch: DVec3::ONE };
    match mode {
        "skin" => skin(whole),
        "stretched" => {
            let factor = |k: usize| [0.6, 0.8, 1.0, 1.3, 1.7][(index * 7 + k * 3 + index / 5) % 5];
            let stretch = DVec3::new(factor(0), factor(1), factor(2));
            Ok(Case { mesh: whole.mesh.map_vertices(|v| v * stretch)?, stretch, ..whole })
        }
        _ => Ok(whole),
    }
}

/// Keeps the faces that see the outside.
fn skin(case: Case) -> Result<Case, Anyhow> {
    let mesh = &case.mesh;
    let solid = TriMesh::new(mesh.vertices().to_vec(), mesh.faces().to_vec())?;
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let ways: Vec<DVec3> = (0..40)
        .map(|i| {
            let z = 1.0 - (f64::from(i) + 0.5) / 20.0;
            let (s, c) = (golden * f64::from(i)).sin_cos();
            DVec3::new(c * (1.0 - z * z).sqrt(), s * (1.0 - z * z).sqrt(), z)
        })
        .collect();
    let lift = mesh.bounds().diagonal() * 1e-5;
    let free = |x: DVec3, n: DVec3| {
        let open = |&&w: &&DVec3| w.dot(n) > 0.1;
        let escapes =
            |w: &DVec3| solid.cast_local_ray(&Ray::new(x + n * lift, *w), 1e6, false).is_none();
        ways.iter().filter(open).any(escapes)
    };
    let seen = |&f: &usize| {
        let ([a, b, c], n, m) = (mesh.corners(f), mesh.normal(f), mesh.centroid(f));
        [m, (m + a) / 2.0, (m + b) / 2.0, (m + c) / 2.0].iter().any(|&x| free(x, n) || free(x, -n))
    };
    let kept: Vec<usize> = (0..mesh.faces().len()).filter(seen).collect();
    let labels = kept.iter().map(|&f| case.labels[f]).collect();
    let mesh = mesh.submesh(kept)?;
    Ok(Case { mesh, labels, ..case })
}

fn dump(out: &mut impl Write, mode: &str, dir: &Path, index: usize) -> Result<(), Anyhow> {
    let case = read(dir, mode, index)?;
    let name = dir.file_name().unwrap_or_default().to_string_lossy();
    let tree = tree(&case.truth, dir)?;
    let weld = Weld::new(&case.mesh);
    let category = case.truth["category"].as_str().unwrap_or("");
    let from = Labelled {
        mesh: &case.mesh,
        weld: &weld,
        tree: &tree,
        part_of_face: &case.labels,
        category,
    };
    let scene = Scene::new(&from, 1);
    let mut axes: Vec<Option<DVec3>> = vec![None; tree.len()];
    for &p in tree.root_first() {
        let up = tree.parent(p).and_then(|p| axes[p]);
        if !case.labels.contains(&(p as u16)) {
            continue;
        }
        let Some(setting) = Setting::new(&scene, &from, p, up, 1) else { continue };
        for (k, &kind) in tree.parts()[p].joints.iter().enumerate() {
            let joint = &case.truth["parts"][p]["joints"][k];
            let axis = (vector(&case.mesh, &joint["axis"]) * case.stretch).normalize();
            let pivot = vector(&case.mesh, &joint["pivot"]) * case.stretch;
            axes[p] = Some(axis);
            if mode == "stretched" && kind.turns() {
                continue;
            }
            let role = setting.meaning.role;
            let role = if kind == JointKind::Continuous { endless(role) } else { role } as usize;
            let text = &tree.parts()[p].text;
            let (lower, upper) = (&joint["lower"], &joint["upper"]);
            writeln!(out, "J\t{name}\t{p}\t{k}\t{kind:?}\t{role}\t{text}\t{lower}\t{upper}")?;
            for c in candidates(&setting, kind) {
                let d = c.axis.direction;
                let angle = axis.dot(d).abs().min(1.0).acos().to_degrees();
                let apart = c.axis.pivot * scene.unit + scene.origin - pivot;
                let normal = axis.cross(d);
                let line = if !kind.turns() {
                    0.0
                } else if normal.length() < 1e-3 {
                    apart.reject_from_normalized(axis).length()
                } else {
                    apart.dot(normal.normalize()).abs()
                };
                write!(
                    out,
                    "C\t{angle:.3}\t{:.5}",
                    line / case.mesh.bounds().size().max_element()
                )?;
                c.features.iter().try_for_each(|f| write!(out, "\t{f:.4}"))?;
                writeln!(out, "\t{:.2}\t{:.2}\t{:.2}", d.x, d.y, d.z)?;
            }
        }
    }
    Ok(())
}

fn vector(mesh: &Mesh, v: &serde_json::Value) -> DVec3 {
    let at = |i: usize| v[i].as_f64().unwrap_or(0.0);
    mesh.frame().point_to_object(DVec3::new(at(0), at(1), at(2)))
}

fn tree(truth: &serde_json::Value, dir: &Path) -> Result<KinematicTree, Anyhow> {
    let condition = std::fs::read_to_string(dir.join("condition.json")).unwrap_or("{}".into());
    let condition: serde_json::Value = serde_json::from_str(&condition)?;
    let kind = |j: &serde_json::Value| match j["type"].as_str() {
        Some("prismatic") => JointKind::Prismatic,
        Some("continuous") => JointKind::Continuous,
        _ => JointKind::Revolute,
    };
    let part = |(i, p): (usize, &serde_json::Value)| {
        let text = condition["parts"][i]["text"].as_str().or(p["name"].as_str()).unwrap_or("");
        Part {
            name: format!("p{i}"),
            text: text.replace('_', " "),
            parent: p["parent"].as_u64().map(|p| p as usize),
            joints: p["joints"].as_array().map_or(vec![], |j| j.iter().map(kind).collect()),
        }
    };
    let parts =
        truth["parts"].as_array().map_or(vec![], |p| p.iter().enumerate().map(part).collect());
    Ok(KinematicTree::new(parts)?)
}
