//! The layers both networks are made of; names and shapes are PyTorch's.
//!
//! Letters: B batch · N rows · L keys · D width · I, O widths in and out · F hidden width.

use burn::module::{Module, Param};
use burn::tensor::Tensor;

use super::ops;
use super::precision::Precision;
use super::source::{Builder, Start};

/// Added to the variance in LayerNorm, and to the mean square in RMSNorm.
const LAYER_EPS: f32 = 1e-5;
const RMS_EPS: f32 = 1e-6;

/// y = x Wᵀ + b.
#[derive(Module, Debug)]
pub struct Linear {
    weight: Param<Tensor<2>>,       // [O, I]
    bias: Option<Param<Tensor<1>>>, // [O]
    #[module(skip)]
    precision: Precision,
}

impl Linear {
    /// With a bias.
    pub fn new(mut b: Builder, inputs: usize, outputs: usize) -> Self {
        let start = Start::Uniform((inputs as f32).sqrt().recip());
        let weight = b.parameter("weight", [outputs, inputs], start);
        let bias = Some(b.parameter("bias", [outputs], start));
        Self { weight, bias, precision: b.precision() }
    }

    /// Without a bias.
    pub fn unbiased(mut b: Builder, inputs: usize, outputs: usize) -> Self {
        let start = Start::Uniform((inputs as f32).sqrt().recip());
        let weight = b.parameter("weight", [outputs, inputs], start);
        Self { weight, bias: None, precision: b.precision() }
    }

    /// [B, N, I] → [B, N, O].
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        ops::linear(x, self.weight(), self.bias(), self.precision)
    }

    /// Applies only the columns `from..from + width` of the weight, to an x that wide: the share of
    /// one member of a concatenated input. The bias is added where `from` is 0.
    pub(crate) fn share(&self, x: Tensor<3>, from: usize) -> Tensor<3> {
        let width = x.dims()[2];
        let weight = self.weight.val().slice([0..self.weight.dims()[0], from..from + width]);
        let bias = if from == 0 { self.bias() } else { None };
        ops::linear(x, weight, bias, self.precision)
    }

    pub(crate) fn weight(&self) -> Tensor<2> {
        self.weight.val()
    }

    pub(crate) fn bias(&self) -> Option<Tensor<1>> {
        self.bias.as_ref().map(Param::val)
    }
}

/// LayerNorm with gain and bias, eps 1e-5.
#[derive(Module, Debug)]
pub struct LayerNorm {
    weight: Param<Tensor<1>>, // [D]
    bias: Param<Tensor<1>>,   // [D]
}

impl LayerNorm {
    /// Of rows of this width.
    pub fn new(mut b: Builder, width: usize) -> Self {
        let weight = b.parameter("weight", [width], Start::Constant(1.0));
        Self { weight, bias: b.parameter("bias", [width], Start::Constant(0.0)) }
    }

    /// [B, N, D] → [B, N, D].
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        ops::layer_norm(x, self.weight.val(), self.bias.val(), LAYER_EPS)
    }
}

/// RMSNorm of each head, eps 1e-6, gain of a head's width.
#[derive(Module, Debug)]
pub struct HeadNorm {
    weight: Param<Tensor<1>>, // [D / heads]
}

impl HeadNorm {
    fn new(mut b: Builder, width: usize) -> Self {
        Self { weight: b.parameter("weight", [width], Start::Constant(1.0)) }
    }

    fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        ops::rms_norm(x, self.weight.val(), RMS_EPS)
    }
}

/// Linear · SiLU · Linear, at `0` and `2`.
#[derive(Module, Debug)]
pub struct Mlp {
    first: Linear,
    second: Linear,
}

impl Mlp {
    /// Widths in, hidden and out.
    pub fn new(mut b: Builder, [inputs, hidden, outputs]: [usize; 3]) -> Self {
        let first = Linear::new(b.at(0), inputs, hidden);
        Self { first, second: Linear::new(b.at(2), hidden, outputs) }
    }

    /// [B, N, I] → [B, N, O].
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        self.second.forward(ops::silu(self.first.forward(x)))
    }

    pub(crate) fn first(&self) -> &Linear {
        &self.first
    }

    pub(crate) fn second(&self) -> &Linear {
        &self.second
    }
}

/// GEGLU feed-forward of four times the width.
#[derive(Module, Debug)]
pub struct FeedForward {
    inner: Linear, // [8 D, D]: value, then gate
    outer: Linear, // [D, 4 D]
}

impl FeedForward {
    /// Of this width.
    pub fn new(mut b: Builder, width: usize) -> Self {
        let inner = Linear::new(b.at("net.0.proj"), width, 8 * width);
        Self { inner, outer: Linear::new(b.at("net.2"), 4 * width, width) }
    }

    /// [B, N, D] → [B, N, D], without the residual.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let (weight, bias) = (self.inner.weight(), self.inner.bias());
        self.outer.forward(ops::gated(x, weight, bias, self.inner.precision))
    }
}

/// Keys and values of a context, computed once and attended to any number of times.
#[derive(Clone, Debug)]
pub struct Context {
    keys: Tensor<3>,     // [B, L, D]
    values: Tensor<3>,   // [B, L, D]
    lengths: Vec<usize>, // how many of L count, per batch element; empty: all
}

/// Multi-head attention: q, k, v without bias, RMSNorm of each head of q and k, output with bias.
#[derive(Module, Debug)]
pub struct Attention {
    to_q: Linear,
    to_k: Linear,
    to_v: Linear,
    norm_q: HeadNorm,
    norm_k: HeadNorm,
    to_out: Linear,
    heads: usize,
}

impl Attention {
    /// Of this width and number of heads.
    pub fn new(mut b: Builder, width: usize, heads: usize) -> Self {
        Self {
            to_q: Linear::unbiased(b.at("to_q"), width, width),
            to_k: Linear::unbiased(b.at("to_k"), width, width),
            to_v: Linear::unbiased(b.at("to_v"), width, width),
            norm_q: HeadNorm::new(b.at("norm_q"), width / heads),
            norm_k: HeadNorm::new(b.at("norm_k"), width / heads),
            to_out: Linear::new(b.at("to_out.0"), width, width),
            heads,
        }
    }

    /// Keys and values of a context [B, L, D], of which `lengths` count (empty: all).
    pub fn context(&self, x: Tensor<3>, lengths: &[usize]) -> Context {
        let keys = self.norm_k.forward(self.to_k.forward(x.clone()));
        Context { keys, values: self.to_v.forward(x), lengths: lengths.to_vec() }
    }

    /// What the rows of x [B, N, D] find in the context, without the residual.
    pub fn forward(&self, x: Tensor<3>, context: &Context) -> Tensor<3> {
        let queries = self.norm_q.forward(self.to_q.forward(x));
        let qkv = [queries, context.keys.clone(), context.values.clone()];
        self.to_out.forward(ops::attention(qkv, self.heads, &context.lengths))
    }
}
