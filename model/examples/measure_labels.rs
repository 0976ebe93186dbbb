//! Measures the labeller over the development cases.
#![allow(clippy::unwrap_used, clippy::print_stdout, missing_docs)]
use model::geometric::labels::label_faces;
use object::weld::Weld;
use object::{Condition, DVec3, Mesh};
use rayon::prelude::*;

fn read(dir: &std::path::Path) -> (Mesh, Condition, Vec<u16>) {
    let b = std::fs::read(dir.join("mesh.bin")).unwrap();
    let u = |o: usize| u32::from_le_bytes(b[o..o + 4].try_into().unwrap());
    let d = |o: usize| f64::from_le_bytes(b[o..o + 8].try_into().unwrap());
    let (nv, nf) = (u(0) as usize, u(4) as usize);
    let v = (0..nv)
        .map(|i| {
            let o = 8 + 24 * i;
            DVec3::new(d(o), -d(o + 16), d(o + 8))
        })
        .collect();
    let f = (0..nf)
        .map(|i| {
            let o = 8 + 24 * nv + 12 * i;
            [u(o), u(o + 4), u(o + 8)]
        })
        .collect();
    let l = std::fs::read(dir.join("face_labels.u16le")).unwrap();
    let l = l.chunks(2).map(|c| u16::from_le_bytes([c[0], c[1]])).collect();
    let c = Condition::from_json(&std::fs::read_to_string(dir.join("condition.json")).unwrap())
        .unwrap();
    (Mesh::new(v, f).unwrap(), c, l)
}

fn set_of(name: &str) -> &'static str {
    if name.starts_with("paper") {
        "paper"
    } else if name.ends_with("-fused") {
        "fused"
    } else if name.starts_with("articraft") {
        "cad"
    } else {
        "sim"
    }
}

fn miou(mesh: &Mesh, truth: &[u16], got: &[u16], parts: usize) -> f64 {
    let (mut i, mut t, mut g) = (vec![0.0; parts], vec![0.0; parts], vec![0.0; parts]);
    for f in 0..truth.len() {
        let a = mesh.area(f);
        t[truth[f] as usize] += a;
        g[got[f] as usize] += a;
        if truth[f] == got[f] {
            i[got[f] as usize] += a;
        }
    }
    let have: Vec<usize> = (0..parts).filter(|&p| t[p] > 0.0).collect();
    have.iter().map(|&p| i[p] / (t[p] + g[p] - i[p]).max(1e-300)).sum::<f64>() / have.len() as f64
}

fn giou(mesh: &Mesh, truth: &[u16], got: &[u16], parts: usize) -> f64 {
    use object::mesh::Bounds;
    let of = |l: &[u16], p: usize| {
        Bounds::of((0..l.len()).filter(|&f| l[f] as usize == p).flat_map(|f| mesh.corners(f)))
    };
    let vol = |b: Bounds| {
        let s = b.size().max(DVec3::splat(1e-6));
        s.x * s.y * s.z
    };
    let mut sum = 0.0;
    let mut n = 0.0;
    for p in 0..parts {
        let (a, b) = (of(truth, p), of(got, p));
        if a.size().min_element() < 0.0 {
            continue;
        }
        n += 1.0;
        if b.size().min_element() < 0.0 {
            sum -= 1.0;
            continue;
        }
        let lo = a.min.max(b.min);
        let hi = a.max.min(b.max);
        let s = hi - lo;
        let i = if s.min_element() < 0.0 { 0.0 } else { vol(Bounds { min: lo, max: hi }) };
        let u = vol(a) + vol(b) - i;
        let c = vol(Bounds { min: a.min.min(b.min), max: a.max.max(b.max) });
        sum += i / u - (c - u) / c;
    }
    sum / n
}

fn main() {
    let mut args = std::env::args().skip(1);
    let root = std::path::PathBuf::from(args.next().unwrap());
    let filter = args.next().unwrap_or_default();
    let worst: usize = args.next().map_or(10, |w| w.parse().unwrap());
    let dump = args.next();
    let mut names: Vec<String> = std::fs::read_dir(&root)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|n| filter.split(',').any(|f| n.contains(f)))
        .collect();
    names.sort();
    let results: Vec<_> = names
        .par_iter()
        .map(|name| {
            let (mesh, c, truth) = read(&root.join(name));
            let t = std::time::Instant::now();
            let weld = Weld::new(&mesh);
            let tw = t.elapsed().as_secs_f64();
            let got = label_faces(&mesh, &c, &weld);
            let s = t.elapsed().as_secs_f64() - tw;
            let n = c.tree.len();
            if let Some(d) = &dump {
                std::fs::write(
                    format!("{d}/{name}.got"),
                    got.part_of_face.iter().flat_map(|l| l.to_le_bytes()).collect::<Vec<u8>>(),
                )
                .unwrap();
            }
            (
                name,
                miou(&mesh, &truth, &got.part_of_face, n),
                giou(&mesh, &truth, &got.part_of_face, n),
                s,
            )
        })
        .collect();
    for set in ["cad", "sim", "fused", "paper"] {
        let mut r: Vec<_> = results.iter().filter(|r| set_of(r.0) == set).collect();
        if r.is_empty() {
            continue;
        }
        let n = r.len() as f64;
        println!(
            "{set:6} n {:3} mIoU {:.4} gIoU {:.4} max s {:.2}",
            r.len(),
            r.iter().map(|r| r.1).sum::<f64>() / n,
            r.iter().map(|r| r.2).sum::<f64>() / n,
            r.iter().map(|r| r.3).fold(0.0, f64::max)
        );
        r.sort_by(|a, b| a.1.total_cmp(&b.1));
        for x in r.iter().take(worst) {
            println!("    {:.3} {:.3} {:.2}s {}", x.1, x.2, x.3, x.0);
        }
    }
}
