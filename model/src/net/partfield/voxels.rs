//! Points through a coarse voxel grid and, beside it, one by one; both added.
//!
//! Letters: N points · C channels · S = 32 voxels along a side.

use burn::module::Param;
use burn::tensor::module::conv3d;
use burn::tensor::ops::ConvOptions;
use burn::tensor::{Device, Tensor, TensorData, activation};

use super::conv::standardised;
use super::numbers::read;
use crate::net::source::{Builder, Start};
use crate::weights::WeightsError;

/// S.
const SIDE: usize = 32;
/// Numbers of a point on entry: p, 2 p, 0, 0.
const INPUT: usize = 8;

/// A 3×3×3 convolution that keeps the size, instance norm, leaky ReLU.
#[derive(Debug)]
struct VoxelLayer {
    weight: Param<Tensor<5>>, // [O, I, 3, 3, 3]
    bias: Param<Tensor<1>>,   // [O]
}

impl VoxelLayer {
    fn new(mut b: Builder, inputs: usize, outputs: usize) -> Self {
        let start = Start::Uniform((27.0 * inputs as f32).sqrt().recip());
        let weight = b.parameter("weight", [outputs, inputs, 3, 3, 3], start);
        Self { weight, bias: b.parameter("bias", [outputs], start) }
    }

    /// [1, I, S, S, S] → [1, O, S, S, S].
    fn forward(&self, x: Tensor<5>) -> Tensor<5> {
        let options = ConvOptions::new([1; 3], [1; 3], [1; 3], 1);
        let y = conv3d(x, self.weight.val(), Some(self.bias.val()), options);
        let channels = y.dims()[1];
        let rows = standardised(y.reshape([1, channels, SIDE * SIDE * SIDE]), 1e-4);
        activation::leaky_relu(rows, 0.1).reshape([1, channels, SIDE, SIDE, SIDE])
    }
}

/// The first stage: 8 numbers a point to C.
#[derive(Debug)]
pub(super) struct PointVoxels {
    voxels: [VoxelLayer; 2],
    weight: Param<Tensor<3>>, // [C, 8, 1]
    bias: Param<Tensor<1>>,   // [C]
}

impl PointVoxels {
    pub(super) fn new(mut b: Builder, channels: usize) -> Self {
        let first = VoxelLayer::new(b.at("voxel_layers.0"), INPUT, channels);
        let second = VoxelLayer::new(b.at("voxel_layers.3"), channels, channels);
        let mut b = b.at("point_features.layers.0");
        let start = Start::Uniform((INPUT as f32).sqrt().recip());
        let weight = b.parameter("weight", [channels, INPUT, 1], start);
        Self { voxels: [first, second], weight, bias: b.parameter("bias", [channels], start) }
    }

    /// Points in [−0.9, 0.9]³ → [C, N], row-major.
    pub(super) fn forward(
        &self,
        points: &[[f32; 3]],
        device: &Device,
    ) -> Result<Vec<f32>, WeightsError> {
        let grid = Tensor::<5>::from_data(
            TensorData::new(voxelised(points), [1, INPUT, SIDE, SIDE, SIDE]),
            device,
        );
        let grid = self.voxels[1].forward(self.voxels[0].forward(grid));
        let mut out = read("the voxel branch", grid).map(|grid| devoxelised(&grid, points))?;
        let inputs: Vec<f32> =
            (0..INPUT).flat_map(|c| points.iter().map(move |p| input(*p)[c])).collect();
        let inputs = Tensor::<2>::from_data(TensorData::new(inputs, [INPUT, points.len()]), device);
        let channels = self.bias.dims()[0];
        let weight: Tensor<2> = self.weight.val().reshape([channels, INPUT]);
        let alone = weight.matmul(inputs) + self.bias.val().reshape([channels, 1]);
        let alone = activation::relu(standardised(alone.unsqueeze(), 1e-5));
        for (o, a) in out.iter_mut().zip(read("the point branch", alone)?) {
            *o += a;
        }
        Ok(out)
    }
}

fn input([x, y, z]: [f32; 3]) -> [f32; INPUT] {
    [x, y, z, 2.0 * x, 2.0 * y, 2.0 * z, 0.0, 0.0]
}

/// Where a point lies in the grid, in voxels.
fn place(p: [f32; 3]) -> [f32; 3] {
    p.map(|c| ((c + 1.0) / 2.0 * SIDE as f32).clamp(0.0, (SIDE - 1) as f32))
}

/// Mean of the points' numbers in each voxel [8, S, S, S] by x, y, z; 0 where there are none.
fn voxelised(points: &[[f32; 3]]) -> Vec<f32> {
    let cells = SIDE * SIDE * SIDE;
    let (mut sum, mut count) = (vec![0.0f32; INPUT * cells], vec![0.0f32; cells]);
    for &p in points {
        let [x, y, z] = place(p).map(|c| c.round_ties_even() as usize);
        let cell = (x * SIDE + y) * SIDE + z;
        count[cell] += 1.0;
        input(p).iter().enumerate().for_each(|(c, v)| sum[c * cells + cell] += v);
    }
    for channel in sum.chunks_exact_mut(cells) {
        channel.iter_mut().zip(&count).for_each(|(s, n)| *s /= n.max(1.0));
    }
    sum
}

/// The grid [C, S, S, S] read between voxels at each point → [C, N]. The axes are read in reverse, a
/// quirk the weights know: the grid's first index runs with z here.
fn devoxelised(grid: &[f32], points: &[[f32; 3]]) -> Vec<f32> {
    let cells = SIDE * SIDE * SIDE;
    let corners: Vec<[(usize, f32); 8]> = points.iter().map(|&p| corners(place(p))).collect();
    let at = |channel: &[f32], c: &[(usize, f32); 8]| c.iter().map(|&(i, w)| channel[i] * w).sum();
    grid.chunks_exact(cells)
        .flat_map(|ch| corners.iter().map(move |c| at(ch, c)).collect::<Vec<f32>>())
        .collect()
}

fn corners([x, y, z]: [f32; 3]) -> [(usize, f32); 8] {
    let split = |c: f32| (c.floor() as usize, c - c.floor());
    let reversed = [split(z), split(y), split(x)];
    std::array::from_fn(|k| {
        let pick = |axis: usize| {
            let (low, part) = reversed[axis];
            let up = k >> axis & 1;
            ((low + up).min(SIDE - 1), if up == 1 { part } else { 1.0 - part })
        };
        let [(a, u), (b, v), (c, w)] = [pick(0), pick(1), pick(2)];
        ((a * SIDE + b) * SIDE + c, u * v * w)
    })
}
