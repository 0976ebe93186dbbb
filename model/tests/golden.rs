//! Parity with recorded outputs of the public reference networks, which stand beside the
//! repository (`KINFOLD_SHARED`, default `../shared`) because of their licence.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use std::collections::BTreeSet;
use std::fs::File;
use std::path::PathBuf;

use burn::tensor::Device;
use model::net::Points;
use model::net::partfield::PartField;
use model::net::particulate::{Decision, Particulate, RawParticulate};
use model::weights::TensorFile;

/// Largest error, as a share of the tensor's largest value.
const TOLERANCE: f64 = 1e-5;

fn golden(name: &str) -> Option<TensorFile<File>> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let shared = std::env::var_os("KINFOLD_SHARED").map_or_else(beside, PathBuf::from);
    let path = shared.join("data/golden").join(name);
    let file = File::open(&path).map_err(|e| e.to_string());
    match file.and_then(|f| TensorFile::open(f).map_err(|e| e.to_string())) {
        Ok(file) => Some(file),
        Err(e) => {
            eprintln!("SKIPPED: golden parity, {}: {e}", path.display());
            None
        }
    }
}

fn agree(file: &mut TensorFile<File>, name: &str, found: &[f32]) {
    let truth = file.values(name).unwrap();
    let largest = truth.iter().fold(0.0, |m: f64, t| m.max(f64::from(*t).abs()));
    assert_eq!(found.len(), truth.len(), "{name}");
    let off = found.iter().zip(&truth).map(|(f, t)| (f64::from(*f) - f64::from(*t)).abs());
    let worst = off.fold(0.0, f64::max) / largest.max(f64::MIN_POSITIVE);
    assert!(worst <= TOLERANCE, "{name}: off by {worst:.2e} of its largest value");
    eprintln!("{name}: {worst:.1e}");
}

fn triples(values: &[f32]) -> Vec<[f32; 3]> {
    values.as_chunks::<3>().0.to_vec()
}

fn columns(values: &[f32], width: usize, columns: std::ops::Range<usize>) -> Vec<f32> {
    values.chunks(width).flat_map(|row| row[columns.clone()].to_vec()).collect()
}

fn agree_on_raw(io: &mut TensorFile<File>, raw: &RawParticulate) {
    agree(io, "out.point_mask_logits", &raw.mask);
    agree(io, "out.part_adjacency_logits", &raw.adjacency);
    agree(io, "out.part_motion_logits", &raw.motion);
    agree(io, "out.revolute_axis_raw", &columns(&raw.revolute, 5, 0..3));
    agree(io, "out.revolute_range", &columns(&raw.revolute, 5, 3..5));
    agree(io, "out.prismatic_axis_raw", &columns(&raw.prismatic, 5, 0..3));
    agree(io, "out.prismatic_range", &columns(&raw.prismatic, 5, 3..5));
}

fn agree_on_decision(io: &mut TensorFile<File>, decision: &Decision) {
    let integers = |values: Vec<bool>| values.into_iter().map(i64::from).collect::<Vec<_>>();
    let parts: Vec<i64> = decision.part_of_point.iter().map(|&p| p.into()).collect();
    assert_eq!(parts, io.integers("out.part_ids").unwrap());
    agree(io, "out.closest_point_on_axis", &decision.axis_points.concat());
    let truth = io.integers("post.motion_hierarchy").unwrap();
    let truth: BTreeSet<_> = truth.as_chunks::<2>().0.iter().map(|&[p, c]| (p, c)).collect();
    let tree: BTreeSet<_> = decision.tree.iter().map(|&(p, c)| (p.into(), c.into())).collect();
    assert_eq!(tree, truth);
    let of = |f: &dyn Fn(usize) -> bool| integers((0..decision.motions.len()).map(f).collect());
    let used = &decision.used;
    let revolute = of(&|s| used[s] && decision.motions[s].revolute);
    let prismatic = of(&|s| used[s] && decision.motions[s].prismatic);
    let truth =
        ["post.is_part_revolute", "post.is_part_prismatic"].map(|n| io.integers(n).unwrap());
    let masked = |t: &[i64]| t.iter().zip(used).map(|(t, u)| t * i64::from(*u)).collect::<Vec<_>>();
    assert_eq!([revolute, prismatic], [masked(&truth[0]), masked(&truth[1])]);
    let narrow = |v: [f64; 3]| v.map(|x| x as f32);
    let axes = |f: &dyn Fn(usize) -> [f64; 3]| {
        (0..used.len()).flat_map(|s| narrow(f(s))).collect::<Vec<_>>()
    };
    agree(io, "post.revolute_axis_unit", &axes(&|s| decision.motions[s].revolute_axis.to_array()));
    agree(
        io,
        "post.prismatic_axis_unit",
        &axes(&|s| decision.motions[s].prismatic_axis.to_array()),
    );
    let pluecker = (0..used.len()).flat_map(|s| decision.pluecker(s)).map(|x| x as f32);
    agree(io, "post.revolute_plucker", &pluecker.collect::<Vec<_>>());
}

fn particulate(set: &str, least_confidence: f64) {
    let weights = golden(&format!("{set}_weights.safetensors"));
    let (Some(mut weights), Some(mut io)) = (weights, golden(&format!("{set}_io.safetensors")))
    else {
        return;
    };
    let device = Device::flex();
    let network = Particulate::load(&mut weights, 6, &device).unwrap();
    let points = Points {
        positions: triples(&io.values("in.xyz").unwrap()),
        normals: Some(triples(&io.values("in.normals").unwrap())),
        features: io.values("in.feats").unwrap(),
    };
    let raw = network.forward(&points, &device).unwrap();
    agree_on_raw(&mut io, &raw);
    agree_on_decision(&mut io, &network.decide(&raw, least_confidence).unwrap());
}

#[test]
fn particulate_answers_as_the_reference_does() {
    particulate("pat_tiny", 0.0);
}

#[test]
fn particulate_prunes_as_the_reference_does() {
    particulate("pat_tiny_pruned", 0.6);
}

#[test]
fn partfield_answers_as_the_reference_does() {
    let weights = golden("partfield_tiny_weights.safetensors");
    let (Some(mut weights), Some(mut io)) = (weights, golden("partfield_tiny_io.safetensors"))
    else {
        return;
    };
    let device = Device::flex();
    let network = PartField::load(&mut weights, [4, 8], &device).unwrap();
    let seen = triples(&io.values("in.points_enc").unwrap());
    let planes = network.encode(&seen, &device).unwrap();
    agree(&mut io, "out.planes", planes.values());
    let asked = triples(&io.values("in.points_dec").unwrap());
    agree(&mut io, "out.point_feat", &planes.features(&asked));
}
