//! Convolutions and normalisations over planes and voxels; names and shapes are PyTorch's.
//!
//! Letters: I, O channels in and out · H, V rows and columns of a plane.

use burn::module::Param;
use burn::tensor::module::conv2d;
use burn::tensor::ops::ConvOptions;
use burn::tensor::{Tensor, activation};

use crate::net::source::{Builder, Start};

/// A square convolution that keeps the size.
#[derive(Debug)]
pub(super) struct Conv2d {
    weight: Param<Tensor<4>>, // [O, I, k, k]
    bias: Param<Tensor<1>>,   // [O]
    side: usize,
}

impl Conv2d {
    pub(super) fn new(mut b: Builder, [inputs, outputs, side]: [usize; 3]) -> Self {
        let start = Start::Uniform(((inputs * side * side) as f32).sqrt().recip());
        let weight = b.parameter("weight", [outputs, inputs, side, side], start);
        Self { weight, bias: b.parameter("bias", [outputs], start), side }
    }

    /// [B, I, H, V] → [B, O, H, V].
    pub(super) fn forward(&self, x: Tensor<4>) -> Tensor<4> {
        let pad = self.side / 2;
        let options = ConvOptions::new([1, 1], [pad, pad], [1, 1], 1);
        conv2d(x, self.weight.val(), Some(self.bias.val()), options)
    }
}

/// Group normalisation with gain and bias, eps 1e-6, of at most 32 groups.
#[derive(Debug)]
pub(super) struct GroupNorm {
    weight: Param<Tensor<1>>,
    bias: Param<Tensor<1>>,
}

impl GroupNorm {
    pub(super) fn new(mut b: Builder, channels: usize) -> Self {
        let weight = b.parameter("weight", [channels], Start::Constant(1.0));
        Self { weight, bias: b.parameter("bias", [channels], Start::Constant(0.0)) }
    }

    /// [B, C, H, V] → the same.
    pub(super) fn forward(&self, x: Tensor<4>) -> Tensor<4> {
        let [b, c, h, v] = x.dims();
        let rows: Tensor<3> = x.reshape([b, 32.min(c), c / 32.min(c) * h * v]);
        let normal = standardised(rows, 1e-6).reshape([b, c, h, v]);
        normal * self.weight.val().reshape([1, c, 1, 1]) + self.bias.val().reshape([1, c, 1, 1])
    }

    /// The same, then SiLU.
    pub(super) fn silu(&self, x: Tensor<4>) -> Tensor<4> {
        activation::silu(self.forward(x))
    }
}

/// Rows with their mean taken off, divided by their standard deviation.
pub(super) fn standardised(rows: Tensor<3>, eps: f32) -> Tensor<3> {
    let centred = rows.clone() - rows.mean_dim(2);
    let variance = centred.clone().powi_scalar(2).mean_dim(2);
    centred / (variance + eps).sqrt()
}
