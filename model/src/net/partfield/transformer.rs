//! A transformer over the pixels of the three planes, at a quarter of their resolution.
//!
//! Letters: C plane channels · R resolution · r = R / 4 · W width · T channels out.

use burn::module::Param;
use burn::tensor::module::{conv_transpose2d, max_pool2d};
use burn::tensor::ops::{ConvTransposeOptions, MaxPoolOptions};
use burn::tensor::{Tensor, activation};

use super::conv::Conv2d;
use super::sizes::PartFieldSizes;
use crate::net::layers::Linear;
use crate::net::ops;
use crate::net::precision::Precision;
use crate::net::source::{Builder, Start};

/// Added to the variance in LayerNorm.
const EPS: f32 = 1e-6;

/// LayerNorm with gain and bias.
#[derive(Debug)]
struct Norm {
    weight: Param<Tensor<1>>,
    bias: Param<Tensor<1>>,
}

impl Norm {
    fn new(mut b: Builder, width: usize) -> Self {
        let weight = b.parameter("weight", [width], Start::Constant(1.0));
        Self { weight, bias: b.parameter("bias", [width], Start::Constant(0.0)) }
    }

    fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        ops::layer_norm(x, self.weight.val(), self.bias.val(), EPS)
    }
}

/// A pre-norm layer: self-attention without biases, feed-forward with GELU.
#[derive(Debug)]
struct Layer {
    norms: [Norm; 2],
    in_proj: Param<Tensor<2>>, // [3 W, W]: q, k, v
    out_proj: Linear,
    inner: Linear,
    outer: Linear,
    heads: usize,
}

impl Layer {
    fn new(mut b: Builder, width: usize, heads: usize) -> Self {
        let start = Start::Uniform((width as f32).sqrt().recip());
        Self {
            norms: [Norm::new(b.at("norm1"), width), Norm::new(b.at("norm2"), width)],
            in_proj: b.at("self_attn").parameter("in_proj_weight", [3 * width, width], start),
            out_proj: Linear::unbiased(b.at("self_attn.out_proj"), width, width),
            inner: Linear::new(b.at("mlp.0"), width, 4 * width),
            outer: Linear::new(b.at("mlp.3"), 4 * width, width),
            heads,
        }
    }

    fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let w = x.dims()[2];
        let y = self.norms[0].forward(x.clone());
        let qkv = [0, 1, 2].map(|i| {
            let weight = self.in_proj.val().slice([i * w..(i + 1) * w, 0..w]);
            ops::linear(y.clone(), weight, None, Precision::Full)
        });
        let x = x + self.out_proj.forward(ops::attention(qkv, self.heads, &[]));
        let y = activation::gelu(self.inner.forward(self.norms[1].forward(x.clone())));
        x + self.outer.forward(y)
    }
}

/// Planes in, planes of features out.
#[derive(Debug)]
pub(super) struct PlaneTransformer {
    down: [Conv2d; 2],
    places: Param<Tensor<3>>, // [1, 3 r r, W]
    layers: Vec<Layer>,
    norm: Norm,
    up: Param<Tensor<4>>, // [W, T, 4, 4]
    up_bias: Param<Tensor<1>>,
    pixel: [Linear; 2],
}

impl PlaneTransformer {
    pub(super) fn new(mut b: Builder, sizes: &PartFieldSizes) -> Self {
        let PartFieldSizes { channels: c, width: w, out: t, .. } = *sizes;
        let places = 3 * (sizes.resolution / 4).pow(2);
        let start = Start::Uniform((w as f32).sqrt().recip());
        let layer = |i, b: &mut Builder| {
            Layer::new(b.at(format!("transformer.layers.{i}")), w, sizes.heads)
        };
        Self {
            down: [
                Conv2d::new(b.at("downsampler.0"), [c, w, 3]),
                Conv2d::new(b.at("downsampler.3"), [w, w, 3]),
            ],
            places: b.parameter("pos_embed", [1, places, w], Start::Normal(0.02)),
            layers: (0..sizes.layers).map(|i| layer(i, &mut b)).collect(),
            norm: Norm::new(b.at("transformer.norm"), w),
            up: b.at("upsampler").parameter("weight", [w, t, 4, 4], start),
            up_bias: b.at("upsampler").parameter("bias", [t], start),
            pixel: [Linear::new(b.at("mlp.0"), c, t), Linear::new(b.at("mlp.2"), t, t)],
        }
    }

    /// [1, C, 3 R, R] → [3, T, R, R].
    pub(super) fn forward(&self, rolled: Tensor<4>) -> Tensor<4> {
        let [_, c, _, r] = rolled.dims();
        let planes = rolled.reshape([c, 3, r, r]).swap_dims(0, 1);
        let mut low = planes.clone();
        for conv in &self.down {
            let pool = MaxPoolOptions::new([2, 2]);
            low = max_pool2d(activation::relu(conv.forward(low)), pool);
        }
        let [_, w, side, _] = low.dims();
        let tokens: Tensor<3> = low.reshape([3, w, side * side]);
        let mut x: Tensor<3> = tokens.swap_dims(1, 2).reshape([1, 3 * side * side, w]);
        x = x + self.places.val();
        for layer in &self.layers {
            x = layer.forward(x);
        }
        let x: Tensor<3> = self.norm.forward(x).reshape([3, side * side, w]);
        let x: Tensor<4> = x.swap_dims(1, 2).reshape([3, w, side, side]);
        let options = ConvTransposeOptions::new([4, 4], [0, 0], [0, 0], [1, 1], 1);
        conv_transpose2d(x, self.up.val(), Some(self.up_bias.val()), options) + self.pixels(planes)
    }

    /// The per-pixel branch [3, C, R, R] → [3, T, R, R].
    fn pixels(&self, planes: Tensor<4>) -> Tensor<4> {
        let [_, c, r, _] = planes.dims();
        let rows: Tensor<3> = planes.reshape([3, c, r * r]);
        let inner = activation::relu(self.pixel[0].forward(rows.swap_dims(1, 2)));
        let out = self.pixel[1].forward(inner);
        let t = out.dims()[2];
        out.swap_dims(1, 2).reshape([3, t, r, r])
    }
}
