//! Processor seconds of the network with random parameters: `cargo bench -p kinfold-model --bench
//! network -- <preset> <what> [queries] [device] [repeats] [half]`, preset `paper` or `small`, what
//! `infer`, `train` or `object` (mesh in, articulated object out: 40,000 faces, 20 parts), device
//! `cpu` or one the build has; `half`, anywhere, infers in half precision. Threads by
//! `RAYON_NUM_THREADS`. One line of JSON a run.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::time::Instant;

use burn::optim::{AdamWConfig, GradientsParams};
use burn::tensor::Device;
use model::net::{
    Answer, Batch, Config, Example, JointQuestion, MotionType, Network, PartPrompt, Points,
    Precision, device, source::Random,
};

use model::{Articulate, Neural};
use object::{Condition, DVec3, Mesh};

/// As the program has it.
#[global_allocator]
static HEAP: mimalloc::MiMalloc = mimalloc::MiMalloc;

const PARTS: usize = 16;

/// User and system seconds of this process so far, and its peak memory in MiB, from /proc.
fn spent() -> (f64, f64) {
    let read = |path| std::fs::read_to_string(path).unwrap_or_default();
    let stat = read("/proc/self/stat");
    let ticks: f64 = stat
        .rsplit(')')
        .next()
        .map(|rest| rest.split_whitespace().skip(11).take(2).flat_map(str::parse::<f64>).sum())
        .unwrap_or(f64::NAN);
    let status = read("/proc/self/status");
    let peak = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let peak = peak.and_then(|l| l.split_whitespace().next()).and_then(|k| k.parse::<f64>().ok());
    (ticks / 100.0, peak.unwrap_or(f64::NAN) / 1024.0)
}

fn wave(i: usize, scale: f32) -> f32 {
    ((i as f32 * 0.618_034).fract() - 0.5) * scale
}

fn points(count: usize, features: usize, from: usize) -> Points {
    let triple =
        |i: usize| [wave(3 * i + from, 1.0), wave(5 * i + from, 1.0), wave(7 * i + from, 1.0)];
    Points {
        positions: (0..count).map(triple).collect(),
        normals: Some((0..count).map(|_| [0.0, 0.6, 0.8]).collect()),
        features: (0..count * features).map(|i| wave(i + from, 2.0)).collect(),
    }
}

fn example(config: &Config, queries: usize, from: usize) -> Example {
    let part = |p: usize| PartPrompt {
        text: Some((0..config.text).map(|i| wave(i * (p + 2), 2.0)).collect()),
        point: Some(points(1, config.features, p)),
    };
    let joint = |p: usize| JointQuestion {
        parent: 0,
        child: p,
        motion: MotionType::Revolute,
        queries: (0..queries as u32).filter(|q| *q as usize % PARTS == p).collect(),
    };
    Example {
        shape: points(config.points, config.features, from),
        parts: (0..PARTS).map(part).collect(),
        queries: points(queries, config.features, from + 1),
        joints: (1..PARTS).map(joint).collect(),
    }
}

fn random(config: &Config, device: &Device, precision: Precision) -> Option<Network> {
    Network::build(config, &mut Random { seed: 1 }, device, precision).ok()
}

fn infer(network: &Network, queries: usize, repeats: usize) {
    let config = network.config();
    let Ok(question) = network.question(&example(config, 1, 3)) else { return };
    let all = points(queries, config.features, 9);
    for _ in 0..repeats {
        let (start, (before, _)) = (Instant::now(), spent());
        let Ok(memory) = network.digest(&question) else { return };
        for from in (0..queries).step_by(config.chunk) {
            let chunk = all.slice(from..queries.min(from + config.chunk), config.features);
            if network.labels(&memory, &chunk).is_err() {
                return;
            }
        }
        let what = match network.precision() {
            Precision::Full => "infer",
            Precision::Half => "infer, half",
        };
        report(what, queries, start, before);
    }
}

/// Twenty boxes in a row, each side a grid, 40,000 faces in all.
fn boxes() -> Option<(Mesh, Condition)> {
    const CELLS: u32 = 13;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (part, side) in (0..20u32).flat_map(|p| (0..6u32).map(move |s| (p, s))) {
        let start = vertices.len() as u32;
        for (i, j) in (0..=CELLS).flat_map(|i| (0..=CELLS).map(move |j| (i, j))) {
            let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(CELLS));
            let w = f64::from(side % 2);
            let p = match side / 2 {
                0 => DVec3::new(u, v, w),
                1 => DVec3::new(w, u, v),
                _ => DVec3::new(v, w, u),
            };
            vertices.push(p * 0.04 + DVec3::X * 0.05 * f64::from(part));
        }
        for (i, j) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j))) {
            let at = |i: u32, j: u32| start + i * (CELLS + 1) + j;
            faces.extend([
                [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
            ]);
        }
    }
    let part = |p: usize| {
        let joint =
            if p == 0 { String::new() } else { r#","parent":"part_0","joint":"revolute""#.into() };
        format!(
            r#"{{"name":"part_{p}","text":"box number {p}","point":[{},0.02,-0.02]{joint}}}"#,
            0.05 * p as f64
        )
    };
    let parts: Vec<_> = (0..20).map(part).collect();
    let text = format!(r#"{{"schema":"kinfold-condition/1","parts":[{}]}}"#, parts.join(","));
    Some((Mesh::new(vertices, faces).ok()?, Condition::from_json(&text).ok()?))
}

fn object(network: Network) {
    let Some((mesh, condition)) = boxes() else { return eprintln!("the boxes are no mesh") };
    let queries = network.config().queries;
    let neural = Neural::new(network, "random");
    for seed in 0..3 {
        let (start, (before, _)) = (Instant::now(), spent());
        if let Err(e) = neural.articulate(&mesh, &condition, seed) {
            eprintln!("{e}");
        }
        report("object", queries, start, before);
    }
}

fn train(config: &Config, queries: usize, device: &Device) {
    let device = device.clone().autodiff();
    let Ok(mut network) = Network::new(config, 1, &device) else { return };
    let mut optimiser = AdamWConfig::new().with_weight_decay(0.01).init();
    let examples: Vec<_> = (0..8).map(|i| example(config, queries, i)).collect();
    for _ in 0..3 {
        let (start, (before, _)) = (Instant::now(), spent());
        let Ok(batch) = Batch::new(&examples, config, &device) else { return };
        let Answer { logits, joints } = network.forward(&batch);
        let loss = logits.powi_scalar(2).mean() + joints.powi_scalar(2).mean();
        let grads = GradientsParams::from_grads(loss.backward(), &network);
        network = optimiser.step(6.4e-5, network, grads);
        if device.sync().is_err() {
            return eprintln!("the device could not be waited for");
        }
        report("train, batch 8", queries, start, before);
    }
}

fn report(what: &str, queries: usize, start: Instant, before: f64) {
    let ((after, peak), wall) = (spent(), start.elapsed().as_secs_f64());
    println!(
        r#"{{"what":"{what}","queries":{queries},"cpu_s":{:.2},"wall_s":{wall:.2},"peak_mib":{peak:.0}}}"#,
        after - before
    );
}

fn main() {
    let mut words: Vec<String> =
        std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let half = words.iter().any(|w| w == "half");
    words.retain(|w| w != "half");
    let precision = if half { Precision::Half } else { Precision::Full };
    if half && Precision::best() == Precision::Full {
        eprintln!("this processor has no bf16 tiles: plain code stands in for them, slowly");
    }
    let word = |i: usize| words.get(i).map(String::as_str);
    let config = if word(0) == Some("paper") { Config::paper() } else { Config::small() };
    let queries = word(2).and_then(|q| q.parse().ok());
    let device = match device(word(3).unwrap_or("cpu")) {
        Ok(device) => device,
        Err(e) => return eprintln!("error: {e}"),
    };
    let repeats = word(4).and_then(|r| r.parse().ok()).unwrap_or(3);
    if word(1) == Some("train") {
        return train(&config, queries.unwrap_or(1_024), &device);
    }
    let Some(network) = random(&config, &device, precision) else { return };
    match word(1) {
        Some("object") => object(network),
        _ => infer(&network, queries.unwrap_or(10_240), repeats),
    }
}
