//! The first layer of a GEGLU feed-forward in one piece: x · Wᵀ + b, then value · gate · Φ(gate).
//!
//! Only a strip of the wide product [value, gate] exists at any time, so that it need not travel
//! to memory and back; the backward pass computes it again.

use std::cell::Cell;

use rayon::prelude::*;

use super::activation::{Gate, geglu_backward};
use super::linear::{self, rows_per_task};
use super::matmul::{Into, Mat, MatMut, matmul};
use super::simd::vectorised;
use super::{Forward, Gradients, View};

/// Columns of the result one strip gives.
const STRIP: usize = 1024;

thread_local! {
    /// Strips of one task after the other: fresh memory costs a page fault every 4 KiB.
    static STRIPS: Cell<Vec<f32>> = const { Cell::new(Vec::new()) };
}

/// x [.., I], weight [2 F, I], bias [2 F] or none → [.., F].
pub(crate) fn forward(x: View, weight: View, bias: View) -> Forward {
    let (inputs, half) = (x.width(), weight.shape[0] / 2);
    let step = rows_per_task(x.rows());
    let mut data = vec![0.0; x.rows() * half];
    data.par_chunks_mut(step * half).zip(x.data.par_chunks(step * inputs)).for_each(|(y, x)| {
        let mut strips = STRIPS.take();
        for from in (0..half).step_by(STRIP) {
            let strip = Strip { from, width: STRIP.min(half - from), half, inputs };
            strip.run(y, x, [weight.data, bias.data], &mut strips);
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
    inputs: usize,
}

impl Strip {
    /// Rows of y [n, F] from rows of x [n, I].
    fn run(&self, y: &mut [f32], x: &[f32], [weight, bias]: [&[f32]; 2], both: &mut Vec<f32>) {
        let (rows, stride) = (x.len() / self.inputs, 2 * self.width);
        both.resize(both.len().max(rows * stride), 0.0);
        let both = &mut both[..rows * stride];
        for (side, first) in [self.from, self.half + self.from].into_iter().enumerate() {
            let columns = &mut both[side * self.width..];
            let into = self.start(columns, bias.get(first..first + self.width));
            let w = &weight[first * self.inputs..];
            let w = Mat::new(w, self.width, self.inputs, self.inputs).transposed();
            let x = Mat::new(x, rows, self.inputs, self.inputs);
            matmul(MatMut::new(columns, rows, self.width, stride), x, w, into);
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
    let both = linear::forward(x, weight, bias);
    let both = View { data: &both.data, shape: &both.shape };
    linear::backward([x, weight, bias], &geglu_backward(both, grad), wanted)
}
