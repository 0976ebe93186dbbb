//! Every kernel against its formula in f64, and every gradient against a difference quotient.

use super::attention::Attention;
use super::norm::Norm;
use super::pair::Rows;
use super::{Forward, Kernel, Precision, Saved, View};

/// Numbers that look random and never change.
pub(crate) fn numbers(count: usize, seed: u32) -> Vec<f32> {
    let mut state = seed.wrapping_mul(2_654_435_761).wrapping_add(12_345);
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

type Tensor = (Vec<f32>, Vec<usize>);

fn tensor(shape: &[usize], seed: u32) -> Tensor {
    (numbers(shape.iter().product(), seed), shape.to_vec())
}

fn none() -> Tensor {
    (vec![], vec![0])
}

fn run(kernel: &Kernel, x: &[Tensor; 3]) -> Forward {
    kernel.forward(x.each_ref().map(|(data, shape)| View { data, shape }))
}

/// Compares the gradient of Σ g · y with central differences of that sum in f64.
fn check_gradients(kernel: &Kernel, x: &[Tensor; 3], tolerance: f64) {
    let forward = run(kernel, x);
    let g = numbers(forward.data.len(), 99);
    let views = x.each_ref().map(|(data, shape)| View { data, shape });
    let gradients =
        kernel.backward(views, Saved { out: &forward.data, kept: &forward.kept }, &g, [true; 3]);
    let loss = |x: &[Tensor; 3]| -> f64 {
        let y = run(kernel, x).data;
        y.iter().zip(&g).map(|(y, g)| f64::from(*y) * f64::from(*g)).sum()
    };
    for input in 0..3 {
        for i in (0..x[input].0.len()).step_by(1 + x[input].0.len() / 40) {
            let h = 1.0 / 64.0;
            let at = |shift: f32| {
                let mut moved = x.clone();
                moved[input].0[i] += shift;
                loss(&moved)
            };
            let h64 = f64::from(h);
            let first = (at(h) - at(-h)) / (2.0 * h64);
            let second = (at(2.0 * h) - at(-2.0 * h)) / (4.0 * h64);
            let truth = (4.0 * first - second) / 3.0;
            let found = f64::from(gradients[input][i]);
            let off = (found - truth).abs();
            assert!(
                off < tolerance * (1.0 + truth.abs()),
                "input {input}[{i}]: {found} for {truth}"
            );
        }
    }
}

/// Attention by its definition, in f64.
fn plain_attention(x: &[Tensor; 3], heads: usize, lengths: &[usize]) -> Vec<f64> {
    let [(q, shape), (k, keys), (v, _)] = x;
    let [batch, n, d] = [shape[0], shape[1], shape[2]];
    let (all, width) = (keys[1], d / heads);
    let mut out = vec![0.0; q.len()];
    for (row, h) in (0..batch * n).flat_map(|r| (0..heads).map(move |h| (r, h))) {
        let b = row / n;
        let count = lengths.get(b).copied().unwrap_or(all);
        let at = |x: &[f32], r: usize, c: usize| f64::from(x[r * d + h * width + c]);
        let score = |l: usize| {
            let dot: f64 = (0..width).map(|c| at(q, row, c) * at(k, b * all + l, c)).sum();
            dot / (width as f64).sqrt()
        };
        let weights: Vec<f64> = (0..count).map(|l| score(l).exp()).collect();
        let total: f64 = weights.iter().sum();
        for c in 0..width {
            let sum: f64 = (0..count).map(|l| weights[l] * at(v, b * all + l, c)).sum();
            out[row * d + h * width + c] = sum / total;
        }
    }
    out
}

#[test]
fn attention_meets_its_definition_at_odd_sizes() {
    for (n, l, d, heads, lengths) in
        [(7, 13, 10, 2, vec![]), (259, 1031, 6, 3, vec![1027, 5]), (1, 1, 4, 1, vec![1, 1])]
    {
        let x = [tensor(&[2, n, d], 1), tensor(&[2, l, d], 2), tensor(&[2, l, d], 3)];
        let found = run(&Kernel::Attention(Attention { heads, lengths: lengths.clone() }), &x);
        let truth = plain_attention(&x, heads, &lengths);
        let off = found.data.iter().zip(&truth).map(|(f, t)| (f64::from(*f) - t).abs());
        assert!(off.fold(0.0, f64::max) < 1e-6, "{n} × {l}");
    }
}

#[test]
fn attention_survives_scores_of_any_size() {
    let mut x = [tensor(&[1, 5, 4], 1), tensor(&[1, 1500, 4], 2), tensor(&[1, 1500, 4], 3)];
    x[0].0.iter_mut().for_each(|q| *q *= 1e4);
    let found = run(&Kernel::Attention(Attention { heads: 1, lengths: vec![] }), &x).data;
    assert!(found.iter().all(|y| y.is_finite() && y.abs() <= 1.0), "a mean of values");
}

#[test]
fn the_gradient_of_attention_is_the_difference_quotient() {
    for (n, l, lengths) in [(3, 5, vec![]), (5, 11, vec![7, 2]), (258, 1030, vec![])] {
        let batch = if n > 100 { 1 } else { 2 };
        let x = [tensor(&[batch, n, 6], 4), tensor(&[batch, l, 6], 5), tensor(&[batch, l, 6], 6)];
        check_gradients(&Kernel::Attention(Attention { heads: 2, lengths }), &x, 3e-3);
    }
}

#[test]
fn norms_meet_their_formulas() {
    let x = [tensor(&[3, 7, 19], 1), tensor(&[19], 2), tensor(&[19], 3)];
    let layer = run(&Kernel::Norm(Norm::Layer { eps: 1e-5 }), &x).data;
    let rms =
        run(&Kernel::Norm(Norm::Rms { eps: 1e-6 }), &[x[0].clone(), x[1].clone(), none()]).data;
    for (r, row) in x[0].0.chunks(19).enumerate() {
        let row: Vec<f64> = row.iter().map(|&v| f64::from(v)).collect();
        let mean = row.iter().sum::<f64>() / 19.0;
        let variance = row.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 19.0;
        let square = row.iter().map(|v| v * v).sum::<f64>() / 19.0;
        for (i, v) in row.iter().enumerate() {
            let [gain, bias] = [x[1].0[i], x[2].0[i]].map(f64::from);
            let l = (v - mean) / (variance + 1e-5).sqrt() * gain + bias;
            assert!((f64::from(layer[r * 19 + i]) - l).abs() < 1e-6);
            let m = v / (square + 1e-6).sqrt() * gain;
            assert!((f64::from(rms[r * 19 + i]) - m).abs() < 1e-6);
        }
    }
}

#[test]
fn the_gradients_of_norms_are_difference_quotients() {
    let x = [tensor(&[5, 19], 1), tensor(&[19], 2), tensor(&[19], 3)];
    check_gradients(&Kernel::Norm(Norm::Layer { eps: 1e-5 }), &x, 2e-3);
    check_gradients(
        &Kernel::Norm(Norm::Rms { eps: 1e-6 }),
        &[x[0].clone(), x[1].clone(), none()],
        2e-3,
    );
}

#[test]
fn the_gradients_of_layers_and_activations_are_difference_quotients() {
    let x = [tensor(&[2, 67, 5], 1), tensor(&[9, 5], 2), tensor(&[9], 3)];
    check_gradients(&Kernel::Linear(Precision::Full), &x, 1e-3);
    let x = [tensor(&[2, 67, 5], 1), tensor(&[14, 5], 2), tensor(&[14], 3)];
    check_gradients(&Kernel::Gated(Precision::Full), &x, 1e-3);
    check_gradients(&Kernel::Silu, &[tensor(&[3, 11], 4), none(), none()], 1e-3);
    check_gradients(&Kernel::Geglu, &[tensor(&[3, 14], 5), none(), none()], 1e-3);
}

#[test]
fn a_gated_layer_is_the_layer_and_then_the_gate() {
    for (half, bias) in [(7, true), (2_053, false)] {
        let bias = if bias { tensor(&[2 * half], 3) } else { none() };
        let x = [tensor(&[3, 67, 5], 1), tensor(&[2 * half, 5], 2), bias];
        let both = run(&Kernel::Linear(Precision::Full), &x);
        let apart = run(&Kernel::Geglu, &[(both.data, both.shape), none(), none()]);
        let found = run(&Kernel::Gated(Precision::Full), &x);
        assert_eq!(found.shape, [3, 67, half]);
        let off = found.data.iter().zip(&apart.data).map(|(f, t)| (f - t).abs());
        assert!(off.fold(0.0, f32::max) < 1e-6, "{half} columns");
    }
}

#[test]
fn layers_in_half_precision_are_near_those_in_full() {
    let near = |half: &Forward, full: &Forward| {
        assert_eq!(half.shape, full.shape);
        let off = half.data.iter().zip(&full.data).map(|(h, f)| (h - f).abs());
        let off = off.fold(0.0, f32::max);
        let size = full.data.iter().fold(0f32, |m, f| m.max(f.abs()));
        assert!(0.0 < off && off < 0.01 * size, "off by {off} of {size}");
    };
    for (rows, inputs, half) in [(5, 32, 33), (261, 71, 1_061), (2, 333, 32)] {
        let x = tensor(&[1, rows, inputs], 1);
        let weight = tensor(&[half, inputs], 2);
        for bias in [none(), tensor(&[half], 3)] {
            let x = [x.clone(), weight.clone(), bias];
            let [h, f] = [Precision::Half, Precision::Full].map(|p| run(&Kernel::Linear(p), &x));
            near(&h, &f);
        }
        for bias in [none(), tensor(&[2 * half], 3)] {
            let x = [x.clone(), tensor(&[2 * half, inputs], 4), bias];
            let [h, f] = [Precision::Half, Precision::Full].map(|p| run(&Kernel::Gated(p), &x));
            near(&h, &f);
        }
    }
}

#[test]
fn a_layer_too_small_for_tiles_is_full_in_any_precision() {
    for [inputs, outputs] in [[31, 64], [64, 31]] {
        let x = [tensor(&[1, 70, inputs], 1), tensor(&[outputs, inputs], 2), none()];
        let [h, f] = [Precision::Half, Precision::Full].map(|p| run(&Kernel::Linear(p), &x).data);
        assert_eq!(h, f);
    }
}

#[test]
fn pair_heads_meet_the_naive_pairs() {
    let x = [tensor(&[2, 5, 23], 1), tensor(&[2, 3, 23], 2), tensor(&[1, 23], 3)];
    let found = run(&Kernel::PairLogits, &x);
    assert_eq!(found.shape, [2, 5, 3]);
    let silu = |z: f64| z / (1.0 + (-z).exp());
    for (i, found) in found.data.iter().enumerate() {
        let (b, q, p) = (i / 15, i / 3 % 5, i % 3);
        let term = |f: usize| {
            let [a, c, w] = [x[0].0[(b * 5 + q) * 23 + f], x[1].0[(b * 3 + p) * 23 + f], x[2].0[f]];
            f64::from(w) * silu(f64::from(a) + f64::from(c))
        };
        let truth: f64 = (0..23).map(term).sum();
        assert!((f64::from(*found) - truth).abs() < 2e-6);
    }
    check_gradients(&Kernel::PairLogits, &x, 1e-3);
    let rows = Rows { query: vec![0, 9, 3, 3], case: vec![1, 0, 1, 1] };
    check_gradients(&Kernel::PairRows(rows), &[x[0].clone(), tensor(&[2, 23], 7), none()], 1e-3);
}
