//! The network on an accelerator agrees with the CPU: its answers, and those after a training step.
//!
//! Built with `--features vulkan`, `metal` or `cuda`; run where `KINFOLD_ACCELERATOR` names the
//! device, for a build machine need not have one.
#![cfg(any(feature = "vulkan", feature = "metal", feature = "cuda"))]
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use burn::optim::{AdamWConfig, GradientsParams};
use burn::tensor::{Device, Tensor};
use model::net::{
    Answer, Batch, Config, Example, JointQuestion, MotionType, Network, PartPrompt, Points, device,
};

/// Largest difference, as a share of the largest value.
const TOLERANCE: f32 = 1e-3;

fn sizes() -> Config {
    Config {
        width: 48,
        heads: 3,
        blocks: 2,
        points: 131,
        tokens: 37,
        queries: 67,
        ..Config::small()
    }
}

fn wave(i: usize) -> f32 {
    (i as f32 * 0.618_034).fract() - 0.5
}

fn points(count: usize, config: &Config, from: usize) -> Points {
    Points {
        positions: (0..count).map(|i| [3, 5, 7].map(|k| wave(k * i + from))).collect(),
        normals: Some(vec![[0.0, 0.6, 0.8]; count]),
        features: (0..count * config.features).map(|i| wave(i + from)).collect(),
    }
}

fn example(config: &Config, parts: usize, from: usize) -> Example {
    let part = |p: usize| PartPrompt {
        text: Some((0..config.text).map(|i| wave(i * (p + 2))).collect()),
        point: Some(points(1, config, p)),
    };
    let joint =
        JointQuestion { parent: 0, child: 1, motion: MotionType::Revolute, queries: vec![0, 7, 5] };
    Example {
        shape: points(config.points, config, from),
        parts: (0..parts).map(part).collect(),
        queries: points(config.queries, config, from + 1),
        joints: vec![joint],
    }
}

fn values<const D: usize>(x: Tensor<D>) -> Vec<f32> {
    x.into_data().try_to_vec().unwrap()
}

/// Logits, votes and loss, before and after one step.
fn answers(device: &Device) -> [Vec<f32>; 6] {
    let (config, device) = (sizes(), device.clone().autodiff());
    let mut network = Network::new(&config, 5, &device).unwrap();
    let mut optimiser = AdamWConfig::new().with_weight_decay(0.01).init();
    let examples = [example(&config, 3, 2), example(&config, 5, 11)];
    let batch = Batch::new(&examples, &config, &device).unwrap();
    let mut told = Vec::new();
    for _ in 0..2 {
        let Answer { logits, joints } = network.forward(&batch);
        let real = logits.clone().clamp_min(-1e3);
        let loss = real.clone().powi_scalar(2).mean() + joints.clone().powi_scalar(2).mean();
        told.extend([values(real), values(joints), values(loss.clone())]);
        let grads = GradientsParams::from_grads(loss.backward(), &network);
        network = optimiser.step(1e-3, network, grads);
    }
    told.try_into().unwrap()
}

#[test]
fn an_accelerator_answers_and_learns_as_the_cpu_does() {
    let Ok(name) = std::env::var("KINFOLD_ACCELERATOR") else {
        eprintln!("SKIPPED: accelerator parity, KINFOLD_ACCELERATOR names no device");
        return;
    };
    let (truth, found) = (answers(&Device::flex()), answers(&device(&name).unwrap()));
    for (truth, found) in truth.iter().zip(&found) {
        assert_eq!(truth.len(), found.len());
        let largest = truth.iter().fold(0.0, |m: f32, t| m.max(t.abs()));
        let off = truth.iter().zip(found).map(|(t, f)| (t - f).abs()).fold(0.0, f32::max);
        assert!(off <= TOLERANCE * largest, "off by {off:e} of {largest}");
    }
}
