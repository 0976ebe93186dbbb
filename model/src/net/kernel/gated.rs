//! The first layer of a GEGLU feed-forward in one piece: x · Wᵀ + b, then value · gate · Φ(gate).
//!
//! Only a strip of the wide product [value, gate] exists at any time, so that it need not travel
//! to memory and back; the backward pass computes it again.

use std::cell::Cell;

use rayon::prelude::*;

use super::activation::{Gate, geglu_backward};
use super::linear::{self, Product, Weight, rows_per_task};
use super::matmul::{Into, MatMut};
use super::simd::vectorised;
use super::{Forward, Gradients, Precision, View};

/// Columns of the result one strip gives.
const STRIP: usize = 1024;

thread_local! {
    /// Strips of one task after the other: fresh memory costs a page fault every 4 KiB.
    static STRIPS: Cell<Vec<f32>> = const { Cell::new(Vec::new()) };
}

/// x [.., I], weight [2 F, I], bias [2 F] or none → [.., F].
pub(crate) fn forward([x, weight, bias]: [View; 3], precision: Precision) -> Forward {
    let (inputs, half) = (x.width(), weight.shape[0] / 2);
    let step = rows_per_task(x.rows());
    let mut data = vec![0.0; x.rows() * half];
    let (value, gate) = weight.data.split_at(half * inputs);
    let weights = [value, gate].map(|side| Weight::new(side, inputs, precision));
    data.par_chunks_mut(step * half).zip(x.data.par_chunks(step * inputs)).for_each(|(y, x)| {
        let sides = weights.each_ref().map(|side| side.of_rows(x));
        let mut strips = STRIPS.take();
        for from in (0..half).step_by(STRIP) {
            let strip = Strip { from, width: STRIP.min(half - from), half };
            strip.run(y, &sides, bias.data, &mut strips);
        }
        STRIPS.set(strips);
    });
    let mut shape = x.shape.to_vec();
    if let Some(last) = shape.last_mut() {
        *last = half;
    }
    Forward { data, shape, kept: vec![] }
}

/// Columns `from..from + width` of the F = `half` columns of the result.
struct Strip {
    from: usize,
    width: usize,
    half: usize,
}

impl Strip {
    /// Rows of y [n, F], from the products of their rows of x with both sides of the weight.
    fn run(&self, y: &mut [f32], sides: &[Product; 2], bias: &[f32], both: &mut Vec<f32>) {
        let (rows, stride) = (y.len() / self.half, 2 * self.width);
        both.resize(both.len().max(rows * stride), 0.0);
        let both = &mut both[..rows * stride];
        for (side, product) in sides.iter().enumerate() {
            let columns = &mut both[side * self.width..];
            let first = side * self.half + self.from;
            let into = self.start(columns, bias.get(first..first + self.width));
            let y = MatMut::new(columns, rows, self.width, stride);
            product.columns(y, self.from, into);
        }
        let y = &mut y[self.from..];
        vectorised(Gate { y, stride: self.half, width: self.width, x: both });
    }

    /// Puts the bias, where there is one, into the columns.
    fn start(&self, columns: &mut [f32], bias: Option<&[f32]>) -> Into {
        let Some(bias) = bias else { return Into::Fresh };
        let rows = columns.chunks_mut(2 * self.width);
        rows.for_each(|row| row[..self.width].copy_from_slice(bias));
        Into::Sum
    }
}

/// Gradients of x, weight and bias.
pub(crate) fn backward([x, weight, bias]: [View; 3], grad: &[f32], wanted: [bool; 3]) -> Gradients {
    let both = linear::forward([x, weight, bias], Precision::Full);
    let both = View { data: &both.data, shape: &both.shape };
    linear::backward([x, weight, bias], &geglu_backward(both, grad), wanted)
}
