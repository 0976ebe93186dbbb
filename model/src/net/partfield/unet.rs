//! A UNet over the three planes, stacked along their rows; its 3×3 convolutions run over the seams
//! on purpose, and a cross-plane layer lets each plane see the means of the other two.
//!
//! Letters: C channels · R resolution of a plane; rolled planes are [1, C, 3 R, R].

use burn::tensor::Tensor;
use burn::tensor::module::{avg_pool2d, interpolate};
use burn::tensor::ops::{AvgPoolOptions, InterpolateMode, InterpolateOptions};

use super::conv::{Conv2d, GroupNorm};
use crate::net::source::Builder;

/// Each plane beside the means of the other two, through a 1×1 convolution of its own.
#[derive(Debug)]
struct CrossPlane {
    convs: Vec<Conv2d>,
}

impl CrossPlane {
    fn new(mut b: Builder, channels: usize) -> Self {
        let conv = |i| Conv2d::new(b.at(format!("plane_convs.{i}")), [3 * channels, channels, 1]);
        Self { convs: (0..3).map(conv).collect() }
    }

    fn forward(&self, rolled: Tensor<4>) -> Tensor<4> {
        let [_, c, _, r] = rolled.dims();
        let plane = |i: usize| rolled.clone().narrow(2, i * r, r);
        let planes = [plane(0), plane(1), plane(2).swap_dims(2, 3)];
        let mixed = self.convs.iter().enumerate().map(|(i, conv)| {
            let [next, last] = [1, 2].map(|k| planes[(i + k) % 3].clone());
            let along = next.mean_dim(3).swap_dims(2, 3).expand([1, c, r, r]);
            let down = last.mean_dim(2).swap_dims(2, 3).expand([1, c, r, r]);
            let out = conv.forward(Tensor::cat(vec![planes[i].clone(), along, down], 1));
            if i == 2 { out.swap_dims(2, 3) } else { out }
        });
        Tensor::cat(mixed.collect(), 2)
    }
}

/// Three normalised convolutions with a shortcut around them.
#[derive(Debug)]
struct ResBlock {
    norms: [GroupNorm; 3],
    conv1: Conv2d,
    cross: CrossPlane,
    conv2: Conv2d,
    shortcut: Option<Conv2d>,
}

impl ResBlock {
    fn new(mut b: Builder, inputs: usize, outputs: usize) -> Self {
        let norms = [
            GroupNorm::new(b.at("norm1"), inputs),
            GroupNorm::new(b.at("norm_mid"), outputs),
            GroupNorm::new(b.at("norm2"), outputs),
        ];
        let other = inputs != outputs;
        Self {
            norms,
            conv1: Conv2d::new(b.at("conv1"), [inputs, outputs, 3]),
            cross: CrossPlane::new(b.at("conv_3daware"), outputs),
            conv2: Conv2d::new(b.at("conv2"), [outputs, outputs, 3]),
            shortcut: other.then(|| Conv2d::new(b.at("nin_shortcut"), [inputs, outputs, 1])),
        }
    }

    fn forward(&self, x: Tensor<4>) -> Tensor<4> {
        let y = self.conv1.forward(self.norms[0].silu(x.clone()));
        let y = self.cross.forward(self.norms[1].silu(y));
        let y = self.conv2.forward(self.norms[2].silu(y));
        match &self.shortcut {
            Some(conv) => y + conv.forward(x),
            None => y + x,
        }
    }
}

/// Three levels down, two up.
#[derive(Debug)]
pub(super) struct PlaneUnet {
    down: Vec<ResBlock>,
    up: Vec<(GroupNorm, ResBlock)>,
    norm_out: GroupNorm,
    last: Conv2d,
}

impl PlaneUnet {
    pub(super) fn new(mut b: Builder, channels: usize, hidden: usize) -> Self {
        let widths = [channels, hidden, 2 * hidden, 4 * hidden];
        let down = (0..3).map(|i| {
            ResBlock::new(b.at(format!("down_convs.{i}.block")), widths[i], widths[i + 1])
        });
        let down = down.collect();
        let up = (0..2).map(|i| {
            let (from, to) = (widths[3 - i] + widths[2 - i], widths[2 - i]);
            let norm = GroupNorm::new(b.at(format!("up_convs.{i}.norm1")), from);
            (norm, ResBlock::new(b.at(format!("up_convs.{i}.block")), from, to))
        });
        let up = up.collect();
        let norm_out = GroupNorm::new(b.at("norm_out"), hidden);
        Self { down, up, norm_out, last: Conv2d::new(b.at("conv_final"), [hidden, channels, 1]) }
    }

    /// [1, C, 3 R, R] → the same.
    pub(super) fn forward(&self, mut x: Tensor<4>) -> Tensor<4> {
        let mut skips = Vec::new();
        for (i, block) in self.down.iter().enumerate() {
            x = block.forward(x);
            if i + 1 < self.down.len() {
                skips.push(x.clone());
                x = avg_pool2d(x, AvgPoolOptions::new([2, 2]));
            }
        }
        for (norm, block) in &self.up {
            let double =
                InterpolateOptions::new(InterpolateMode::Nearest).with_scale_factor([2.0, 2.0]);
            let wide = interpolate(x, double);
            let both = wide_and_skip(wide, skips.pop());
            x = block.forward(norm.forward(both));
        }
        self.last.forward(self.norm_out.silu(x))
    }
}

fn wide_and_skip(wide: Tensor<4>, skip: Option<Tensor<4>>) -> Tensor<4> {
    let all: Vec<_> = std::iter::once(wide).chain(skip).collect();
    Tensor::cat(all, 1)
}
