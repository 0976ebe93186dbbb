//! The network's operations on tensors: our kernels on the CPU, burn's own operations elsewhere.
//!
//! Letters: B batch · N rows · L keys · P parts · D width · F hidden width · R rows of pairs.

use burn::tensor::activation;
use burn::tensor::{Device, Int, Tensor, TensorData};

use super::kernel::Kernel;
use super::kernel::attention::Attention;
use super::kernel::norm::Norm;
use super::kernel::pair::Rows;
use super::op::run;
use super::precision::Precision;

/// Whether our kernels run on this device.
fn on_cpu(device: &Device) -> bool {
    *device == Device::flex()
}

fn none(device: &Device) -> Tensor<1> {
    Tensor::from_data(TensorData::new(Vec::<f32>::new(), [0]), device)
}

/// What remains of a wish where gradients are recorded: they are those of the full network.
fn untrained(precision: Precision, device: &Device) -> Precision {
    if device.is_autodiff() { Precision::Full } else { precision }
}

/// x [B, N, I], weight [O, I], bias [O] → [B, N, O].
pub(crate) fn linear(
    x: Tensor<3>,
    weight: Tensor<2>,
    bias: Option<Tensor<1>>,
    precision: Precision,
) -> Tensor<3> {
    let device = x.device();
    if on_cpu(&device) {
        let bias = bias.unwrap_or_else(|| none(&device));
        return run(Kernel::Linear(untrained(precision, &device)), x, weight, bias);
    }
    let y = x.matmul(weight.transpose().unsqueeze());
    match bias {
        Some(bias) => y + bias.unsqueeze(),
        None => y,
    }
}

/// LayerNorm of x [B, N, D] over D; gain and bias [D].
pub(crate) fn layer_norm(x: Tensor<3>, gain: Tensor<1>, bias: Tensor<1>, eps: f32) -> Tensor<3> {
    if on_cpu(&x.device()) {
        return run(Kernel::Norm(Norm::Layer { eps }), x, gain, bias);
    }
    let centred = x.clone() - x.mean_dim(2);
    let variance = centred.clone().powi_scalar(2).mean_dim(2);
    centred / (variance + eps).sqrt() * gain.unsqueeze() + bias.unsqueeze()
}

/// RMSNorm of each head of x [B, N, D]; the gain is as wide as a head.
pub(crate) fn rms_norm(x: Tensor<3>, gain: Tensor<1>, eps: f32) -> Tensor<3> {
    let device = x.device();
    if on_cpu(&device) {
        return run(Kernel::Norm(Norm::Rms { eps }), x, gain, none(&device));
    }
    let [b, n, d] = x.dims();
    let width = gain.dims()[0];
    let heads: Tensor<4> = x.reshape([b, n, d / width, width]);
    let square = heads.clone().powi_scalar(2).mean_dim(3);
    let normal = heads / (square + eps).sqrt() * gain.unsqueeze();
    normal.reshape([b, n, d])
}

/// softmax(q kᵀ / √(D / heads)) v with q [B, N, D], k and v [B, L, D]; `lengths` says how many keys
/// of each batch element count (empty: all).
pub(crate) fn attention(qkv: [Tensor<3>; 3], heads: usize, lengths: &[usize]) -> Tensor<3> {
    let [q, k, v] = qkv;
    if on_cpu(&q.device()) {
        let attention = Attention { heads, lengths: lengths.to_vec() };
        return run(Kernel::Attention(attention), q, k, v);
    }
    plain_attention([q, k, v], heads, lengths)
}

/// Attention by burn's own operations, with the score matrix; for other backends and for tests.
pub(crate) fn plain_attention(qkv: [Tensor<3>; 3], heads: usize, lengths: &[usize]) -> Tensor<3> {
    let (keys, device) = (qkv[1].dims()[1], qkv[1].device());
    let mask = (!lengths.is_empty()).then(|| beyond(lengths, keys, &device));
    masked_attention(qkv, heads, mask)
}

/// Attention in which row n sees rows 0 to n and no more; q, k, v [B, N, D], for short texts.
pub(crate) fn causal_attention(qkv: [Tensor<3>; 3], heads: usize) -> Tensor<3> {
    let (rows, device) = (qkv[0].dims()[1], qkv[0].device());
    let lengths: Vec<usize> = (1..=rows).collect();
    let mask = beyond(&lengths, rows, &device).swap_dims(0, 2); // [1, 1, N, N]
    masked_attention(qkv, heads, Some(mask))
}

/// Attention whose scores [B, heads, N, L] have a mask added that spreads to them.
fn masked_attention(qkv: [Tensor<3>; 3], heads: usize, mask: Option<Tensor<4>>) -> Tensor<3> {
    let [b, n, d] = qkv[0].dims();
    let width = d / heads;
    let [q, k, v] = qkv.map(|x| {
        let rows = x.dims()[1];
        let split: Tensor<4> = x.reshape([b, rows, heads, width]);
        split.swap_dims(1, 2)
    });
    let mut scores = q.matmul(k.transpose()) / (width as f32).sqrt();
    if let Some(mask) = mask {
        scores = scores + mask;
    }
    activation::softmax(scores, 3).matmul(v).swap_dims(1, 2).reshape([b, n, d])
}

/// [B, 1, 1, L]: 0 for keys that count, −1e9 for those beyond their length.
pub(crate) fn beyond(lengths: &[usize], all: usize, device: &Device) -> Tensor<4> {
    let one = |&length: &usize| (0..all).map(move |l| if l < length { 0.0f32 } else { -1e9 });
    let mask: Vec<f32> = lengths.iter().flat_map(one).collect();
    Tensor::from_data(TensorData::new(mask, [lengths.len(), 1, 1, all]), device)
}

/// x · sigmoid(x).
pub(crate) fn silu(x: Tensor<3>) -> Tensor<3> {
    let device = x.device();
    if on_cpu(&device) {
        return run(Kernel::Silu, x, none(&device), none(&device));
    }
    activation::silu(x)
}

/// x [B, N, I], weight [2 F, I], bias [2 F] → value · gelu(gate) [B, N, F] of [value, gate] = x Wᵀ + b.
pub(crate) fn gated(
    x: Tensor<3>,
    weight: Tensor<2>,
    bias: Option<Tensor<1>>,
    precision: Precision,
) -> Tensor<3> {
    let device = x.device();
    if on_cpu(&device) && !device.is_autodiff() {
        let bias = bias.unwrap_or_else(|| none(&device));
        return run(Kernel::Gated(precision), x, weight, bias);
    }
    geglu(linear(x, weight, bias, Precision::Full)) // keeps the product, which the backward pass wants
}

/// [value, gate] [B, N, 2 F] → value · gelu(gate) [B, N, F], with the exact (erf) GELU.
pub(crate) fn geglu(x: Tensor<3>) -> Tensor<3> {
    let device = x.device();
    if on_cpu(&device) {
        return run(Kernel::Geglu, x, none(&device), none(&device));
    }
    let mut halves = x.chunk(2, 2);
    match (halves.pop(), halves.pop()) {
        (Some(gate), Some(value)) => value * activation::gelu(gate),
        (only, _) => only.unwrap_or_else(|| Tensor::zeros([0, 0, 0], &device)),
    }
}

/// Σ_f w[f] · silu(a[n, f] + b[p, f]) for all pairs: a [B, N, F], b [B, P, F], w [1, F] → [B, N, P].
pub(crate) fn pair_logits(a: Tensor<3>, b: Tensor<3>, w: Tensor<2>) -> Tensor<3> {
    if on_cpu(&a.device()) {
        return run(Kernel::PairLogits, a, b, w);
    }
    let pairs: Tensor<4> = a.unsqueeze_dim::<4>(2) + b.unsqueeze_dim::<4>(1);
    let w: Tensor<4> = w.reshape([1, 1, 1, -1]);
    (activation::silu(pairs) * w).sum_dim(3).squeeze_dim(3)
}

/// silu(a[query] + c[case]) for chosen pairs: a [B, N, F] counted through B N, c [E, F] → [1, R, F].
pub(crate) fn pair_rows(a: Tensor<3>, c: Tensor<2>, query: &[u32], case: &[u32]) -> Tensor<3> {
    let device = a.device();
    let rows = query.len();
    let [b, n, f] = a.dims();
    if on_cpu(&device) {
        let kernel = Kernel::PairRows(Rows { query: query.to_vec(), case: case.to_vec() });
        let out: Tensor<2> = run(kernel, a, c, none(&device));
        return out.reshape([1, rows, f]);
    }
    let a: Tensor<2> = a.reshape([b * n, f]);
    let sum = a.select(0, indices(query, &device)) + c.select(0, indices(case, &device));
    activation::silu(sum).reshape([1, rows, f])
}

/// Row numbers as a tensor.
pub(crate) fn indices(rows: &[u32], device: &Device) -> Tensor<1, Int> {
    let rows: Vec<i32> = rows.iter().map(|&r| r as i32).collect();
    let count = rows.len();
    Tensor::from_data(TensorData::new(rows, [count]), device)
}

#[cfg(test)]
mod tests {
    use super::super::kernel::tests::numbers;
    use super::*;

    fn tensor<const D: usize>(shape: [usize; D], seed: u32, device: &Device) -> Tensor<D> {
        let data = TensorData::new(numbers(shape.iter().product(), seed), shape);
        Tensor::<D>::from_data(data, device).require_grad()
    }

    fn worst<const D: usize>(a: Tensor<D>, b: Tensor<D>) -> f32 {
        (a - b).abs().max().into_scalar()
    }

    #[test]
    fn the_gradient_of_fused_attention_is_that_of_the_naive_one() {
        let device = Device::flex().autodiff();
        let lengths = [301, 17];
        let x = [
            tensor([2, 263, 24], 1, &device),
            tensor([2, 301, 24], 2, &device),
            tensor([2, 301, 24], 3, &device),
        ];
        let weights = tensor([2, 263, 24], 4, &device).detach();
        let fused = attention(x.clone(), 3, &lengths);
        let naive = plain_attention(x.clone(), 3, &lengths);
        assert!(worst(fused.clone(), naive.clone()) < 1e-6);
        let [fused, naive] = [fused, naive].map(|y| (y * weights.clone()).sum().backward());
        for x in x {
            let [a, b] = [&fused, &naive].map(|g| x.grad(g).unwrap());
            let size: f32 = b.clone().abs().max().into_scalar();
            assert!(worst(a, b) < 1e-5 * size.max(1.0));
        }
    }
}
