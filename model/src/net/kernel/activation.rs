//! SiLU and GEGLU, forward and backward, on all cores.

use rayon::prelude::*;

use super::simd::{normal, sigmoid, vectorised};
use super::{Forward, View};

/// Elements or rows one task takes.
const PIECE: usize = 1 << 14;

/// x · sigmoid(x).
pub(crate) fn silu(x: View) -> Forward {
    let mut data = vec![0.0; x.data.len()];
    data.par_chunks_mut(PIECE).zip(x.data.par_chunks(PIECE)).for_each(|(y, x)| {
        vectorised(|| y.iter_mut().zip(x).for_each(|(y, &x)| *y = x * sigmoid(x)));
    });
    Forward { data, shape: x.shape.to_vec(), kept: vec![] }
}

/// The slope of SiLU: s + x · s · (1 − s).
#[inline(always)]
pub(crate) fn silu_slope(x: f32) -> f32 {
    let s = sigmoid(x);
    s + x * s * (1.0 - s)
}

pub(crate) fn silu_backward(x: View, grad: &[f32]) -> Vec<f32> {
    let mut dx = grad.to_vec();
    dx.par_chunks_mut(PIECE).zip(x.data.par_chunks(PIECE)).for_each(|(dx, x)| {
        vectorised(|| dx.iter_mut().zip(x).for_each(|(d, &x)| *d *= silu_slope(x)));
    });
    dx
}

/// Rows of [value, gate] [.., 2 F] → value · gate · Φ(gate) [.., F].
pub(crate) fn geglu(x: View) -> Forward {
    let half = x.width() / 2;
    let rows = rows_per_task(half);
    let mut data = vec![0.0; x.data.len() / 2];
    data.par_chunks_mut(rows * half).zip(x.data.par_chunks(2 * rows * half)).for_each(|(y, x)| {
        vectorised(|| {
            for (y, x) in y.chunks_exact_mut(half).zip(x.chunks_exact(2 * half)) {
                let (value, gate) = x.split_at(half);
                for i in 0..half {
                    y[i] = value[i] * gate[i] * normal(gate[i]).0;
                }
            }
        });
    });
    let mut shape = x.shape.to_vec();
    if let Some(last) = shape.last_mut() {
        *last = half;
    }
    Forward { data, shape, kept: vec![] }
}

pub(crate) fn geglu_backward(x: View, grad: &[f32]) -> Vec<f32> {
    let half = x.width() / 2;
    let rows = rows_per_task(half);
    let mut dx = vec![0.0; x.data.len()];
    let pieces = dx.par_chunks_mut(2 * rows * half).zip(x.data.par_chunks(2 * rows * half));
    pieces.zip(grad.par_chunks(rows * half)).for_each(|((dx, x), g)| {
        vectorised(|| {
            let rows = dx.chunks_exact_mut(2 * half).zip(x.chunks_exact(2 * half));
            for ((dx, x), g) in rows.zip(g.chunks_exact(half)) {
                geglu_row_backward(dx, x, g);
            }
        });
    });
    dx
}

#[inline(always)]
fn geglu_row_backward(dx: &mut [f32], x: &[f32], g: &[f32]) {
    let half = g.len();
    let (value, gate) = x.split_at(half);
    let (d_value, d_gate) = dx.split_at_mut(half);
    for i in 0..half {
        let (below, density) = normal(gate[i]);
        d_value[i] = g[i] * gate[i] * below;
        d_gate[i] = g[i] * value[i] * (below + gate[i] * density);
    }
}

fn rows_per_task(half: usize) -> usize {
    (PIECE / half.max(1)).max(1)
}
