//! dump
use std::io::Write;
use model::geometric::joints;
use model::geometric::words::meaning;
use object::mesh::{FileFrame, UpAxis};
use object::{DVec3, JointKind, KinematicTree, Mesh, Part};

fn read(dir: &std::path::Path) -> Option<(Mesh, Vec<u16>, serde_json::Value)> {
    let b = std::fs::read(dir.join("mesh.bin")).ok()?;
    let n = |i: usize| u32::from_le_bytes(b[i..i + 4].try_into().unwrap());
    let (nv, nf) = (n(0) as usize, n(4) as usize);
    let f = |i: usize| f64::from_le_bytes(b[8 + i * 8..16 + i * 8].try_into().unwrap());
    let frame = FileFrame { up: UpAxis::Y };
    let v = (0..nv).map(|i| frame.point_to_object(DVec3::new(f(3 * i), f(3 * i + 1), f(3 * i + 2)))).collect();
    let o = 8 + nv * 24;
    let faces = (0..nf).map(|i| [n(o + 12 * i), n(o + 12 * i + 4), n(o + 12 * i + 8)]).collect();
    let l = std::fs::read(dir.join("face_labels.u16le")).ok()?;
    let labels = l.chunks(2).map(|c| u16::from_le_bytes([c[0], c[1]])).collect();
    let t = serde_json::from_str(&std::fs::read_to_string(dir.join("truth.json")).ok()?).ok()?;
    Some((Mesh::new(v, faces).ok()?, labels, t))
}
fn v3(v: &serde_json::Value) -> DVec3 {
    let f = |i: usize| v[i].as_f64().unwrap();
    FileFrame { up: UpAxis::Y }.point_to_object(DVec3::new(f(0), f(1), f(2)))
}
fn main() {
    let mut out = std::io::BufWriter::new(std::fs::File::create(std::env::args().nth(1).unwrap()).unwrap());
    for dir in std::env::args().skip(2) {
        let dir = std::path::PathBuf::from(dir);
        let Some((mesh, labels, truth)) = read(&dir) else { eprintln!("no {dir:?}"); continue };
        let ps = truth["parts"].as_array().unwrap();
        let cond: Option<serde_json::Value> = std::fs::read_to_string(dir.join("condition.json")).ok().and_then(|s| serde_json::from_str(&s).ok());
        let category = truth["category"].as_str().unwrap_or("").to_string();
        let parts: Vec<Part> = ps.iter().enumerate().map(|(i, p)| Part {
            name: format!("p{i}"),
            text: cond.as_ref().and_then(|c| c["parts"][i]["text"].as_str()).unwrap_or(p["name"].as_str().unwrap_or("")).to_string(),
            parent: p["parent"].as_u64().map(|p| p as usize),
            joints: p["joints"].as_array().unwrap().iter().map(|j| match j["type"].as_str().unwrap() { "prismatic" => JointKind::Prismatic, "continuous" => JointKind::Continuous, _ => JointKind::Revolute }).collect(),
        }).collect();
        let Ok(tree) = KinematicTree::new(parts) else { eprintln!("tree {dir:?}"); continue };
        let t0 = std::time::Instant::now();
        let scene = joints::scene(&mesh, &tree, &labels, 1);
        let largest = mesh.bounds().size().max_element();
        let mut axes: Vec<Option<DVec3>> = vec![None; tree.len()];
        let mut total = 0;
        for &p in tree.root_first() {
            let pa = tree.parent(p).and_then(|p| axes[p]);
            let Some(setting) = joints::setting(&scene, &tree, p, pa, 1) else { continue };
            for (k, &kind) in tree.parts()[p].joints.iter().enumerate() {
                let j = &ps[p]["joints"][k];
                let (ta, tp) = (v3(&j["axis"]).normalize(), v3(&j["pivot"]));
                axes[p] = Some(ta);
                if std::env::var("DBG").is_ok() {
                    let ax = model::geometric::sweep::Axis { direction: ta, pivot: (tp - scene.origin) / scene.unit, turns: kind.turns() };
                    for a in [ax, ax.reversed()] {
                        let sw = model::geometric::sweep::Sweep { scene: &scene, probes: &setting.probes, still: &setting.still, step: 0.008 };
                        let lim = if kind.turns() { 0.6 } else { 0.15 };
                        let mut w: Vec<(f64, DVec3)> = setting.probes.iter().map(|&p| (sw.walk(&a, p, lim) / lim, p)).collect();
                        w.sort_by(|x, y| x.0.total_cmp(&y.0));
                        let q = |f: f64| w[(f * w.len() as f64) as usize].0;
                        eprintln!("{} {} {:?} q1 {:.2} q3 {:.2} q6 {:.2} q12 {:.2} q20 {:.2}", dir.file_name().unwrap().to_str().unwrap(), tree.parts()[p].text, kind, q(0.01), q(0.03), q(0.06), q(0.12), q(0.2));
                        if std::env::var("DBG").unwrap() == "2" { for x in &w[..8] { let n = scene.nearest(&setting.still, x.1, 0.5); eprintln!("   {:.3} at {:.3} near {:?}", x.0, x.1, n); } }
                    }
                    continue;
                }
                let m = meaning(&tree.parts()[p].text, &category);
                let cs = joints::candidates(&setting, kind);
                total += cs.len();
                let lu = |s: &str| j[s].as_f64().map_or("nan".into(), |v| v.to_string());
                writeln!(out, "J\t{}\t{p}\t{k}\t{:?}\t{}\t{}\t{}\t{}\t{}", dir.file_name().unwrap().to_str().unwrap(), kind, m.role as usize, tree.parts()[p].text, lu("lower"), lu("upper"), largest / scene.unit).unwrap();
                for c in cs {
                    let ang = ta.dot(c.axis.direction).abs().min(1.0).acos().to_degrees();
                    let pv = c.axis.pivot * scene.unit + scene.origin;
                    let le = if kind.turns() {
                        let n = ta.cross(c.axis.direction);
                        let w = pv - tp;
                        (if n.length() < 1e-3 { w.reject_from_normalized(ta).length() } else { w.dot(n.normalize()).abs() }) / largest
                    } else { 0.0 };
                    write!(out, "C\t{ang:.3}\t{le:.5}").unwrap();
                    for f in c.features { write!(out, "\t{f:.5}").unwrap(); }
                    writeln!(out).unwrap();
                }
            }
        }
        eprintln!("{:?} faces {} cands {total} {:.2}s", dir.file_name().unwrap(), mesh.faces().len(), t0.elapsed().as_secs_f64());
    }
}
