//! The network's arithmetic on plain slices: each kernel with its own forward and backward pass.
//!
//! Nothing here knows burn; `super::op` hands these kernels to burn as one operation. Every kernel
//! splits its work into pieces whose size does not depend on the number of threads and adds their
//! results in order, so the bits do not depend on it either.
//!
//! Letters: B batch · N rows · L keys · P parts · D width · I, O widths in and out of a layer.

pub(crate) mod activation;
pub(crate) mod attention;
pub(crate) mod gated;
pub(crate) mod half;
pub(crate) mod linear;
pub(crate) mod matmul;
pub(crate) mod norm;
pub(crate) mod pair;
mod passes;
pub(crate) mod simd;
pub(crate) mod tiles;

#[cfg(test)]
pub(crate) mod tests;

use super::precision::Precision;
pub(crate) use passes::{Forward, Gradients, Saved, View};

/// An operation on up to three tensors; unused ones are empty.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kernel {
    /// Softmax attention of q [B, N, D] over k, v [B, L, D]; see [`attention`].
    Attention(attention::Attention),
    /// LayerNorm or RMSNorm of x over rows as wide as the gain; see [`norm`].
    Norm(norm::Norm),
    /// x [.., I], weight [O, I], bias [O] or none → [.., O].
    Linear(Precision),
    /// x [.., I], weight [2 F, I], bias [2 F] or none → value · gelu(gate) [.., F]; see [`gated`].
    Gated(Precision),
    /// x · sigmoid(x).
    Silu,
    /// [value, gate] [.., 2 F] → value · gelu(gate) [.., F].
    Geglu,
    /// a [B, N, F], b [B, P, F], w [1, F] → Σ w · silu(a + b) [B, N, P].
    PairLogits,
    /// a [.., F], c [E, F] → silu(a[row] + c[case]) [R, F].
    PairRows(pair::Rows),
}

impl Kernel {
    pub(crate) fn forward(&self, x: [View; 3]) -> Forward {
        let [a, b, c] = x;
        match self {
            Self::Attention(attention) => attention.forward(a, b, c),
            Self::Norm(norm) => norm.forward(a, b, c),
            Self::Linear(precision) => linear::forward([a, b, c], *precision),
            Self::Gated(precision) => gated::forward([a, b, c], *precision),
            Self::Silu => activation::silu(a),
            Self::Geglu => activation::geglu(a),
            Self::PairLogits => pair::logits(a, b, c),
            Self::PairRows(rows) => rows.forward(a, b),
        }
    }

    /// Gradients of the inputs in full precision, given what the forward pass left and the gradient
    /// of its result. `wanted` says which inputs need one.
    pub(crate) fn backward(
        &self,
        x: [View; 3],
        saved: Saved,
        grad: &[f32],
        wanted: [bool; 3],
    ) -> Gradients {
        let [a, b, c] = x;
        match self {
            Self::Attention(attention) => attention.backward(x, saved, grad),
            Self::Norm(norm) => norm.backward(a, b, grad),
            Self::Linear(_) => linear::backward([a, b, c], grad, wanted),
            Self::Gated(_) => gated::backward([a, b, c], grad, wanted),
            Self::Silu => [activation::silu_backward(a, grad), vec![], vec![]],
            Self::Geglu => [activation::geglu_backward(a, grad), vec![], vec![]],
            Self::PairLogits => pair::logits_backward([a, b, c], grad),
            Self::PairRows(rows) => rows.backward(a, b, grad),
        }
    }
}
