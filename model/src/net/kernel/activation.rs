//! SiLU and GEGLU, forward and backward, on all cores.

use rayon::prelude::*;

use super::simd::{Work, normal, sigmoid, vectorised};
use super::{Forward, View};

/// Elements or rows one task takes.
const PIECE: usize = 1 << 14;

/// x · sigmoid(x).
pub(crate) fn silu(x: View) -> Forward {
    let mut data = vec![0.0; x.data.len()];
    data.par_chunks_mut(PIECE).zip(x.data.par_chunks(PIECE)).for_each(|(y, x)| {
        vectorised(Silu { y, x });
    });
    Forward { data, shape: x.shape.to_vec(), kept: vec![] }
}

struct Silu<'a> {
    y: &'a mut [f32],
    x: &'a [f32],
}

impl Work for Silu<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (y, &x) in self.y.iter_mut().zip(self.x) {
            *y = x * sigmoid(x);
        }
    }
}

/// What stands in d, times the slope at x.
struct SiluSlope<'a> {
    d: &'a mut [f32],
    x: &'a [f32],
}

impl Work for SiluSlope<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (d, &x) in self.d.iter_mut().zip(self.x) {
            *d *= silu_slope(x);
        }
    }
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
        vectorised(SiluSlope { d: dx, x });
    });
    dx
}

/// Rows of [value, gate] [.., 2 F] → value · gate · Φ(gate) [.., F].
pub(crate) fn geglu(x: View) -> Forward {
    let half = x.width() / 2;
    let rows = rows_per_task(half);
    let mut data = vec![0.0; x.data.len() / 2];
    data.par_chunks_mut(rows * half).zip(x.data.par_chunks(2 * rows * half)).for_each(|(y, x)| {
        vectorised(Gate { y, stride: half, width: half, x });
    });
    let mut shape = x.shape.to_vec();
    if let Some(last) = shape.last_mut() {
        *last = half;
    }
    Forward { data, shape, kept: vec![] }
}

/// Rows of [value, gate], `width` numbers each, and where their products go: the first `width`
/// numbers of rows of y, which lie `stride` apart.
pub(crate) struct Gate<'a> {
    pub(crate) y: &'a mut [f32],
    pub(crate) stride: usize,
    pub(crate) width: usize,
    pub(crate) x: &'a [f32],
}

impl Work for Gate<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let rows = self.x.chunks_exact(2 * self.width);
        for (y, x) in self.y.chunks_mut(self.stride).zip(rows) {
            let (value, gate) = x.split_at(self.width);
            for ((y, v), &g) in y.iter_mut().zip(value).zip(gate) {
                *y = v * g * normal(g).0;
            }
        }
    }
}

pub(crate) fn geglu_backward(x: View, grad: &[f32]) -> Vec<f32> {
    let half = x.width() / 2;
    let rows = rows_per_task(half);
    let mut dx = vec![0.0; x.data.len()];
    let pieces = dx.par_chunks_mut(2 * rows * half).zip(x.data.par_chunks(2 * rows * half));
    pieces.zip(grad.par_chunks(rows * half)).for_each(|((dx, x), g)| {
        vectorised(GateSlope { dx, x, g, half });
    });
    dx
}

struct GateSlope<'a> {
    dx: &'a mut [f32],
    x: &'a [f32],
    g: &'a [f32],
    half: usize,
}

impl Work for GateSlope<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (two, half) = (2 * self.half, self.half);
        let rows = self.dx.chunks_exact_mut(two).zip(self.x.chunks_exact(two));
        for ((dx, x), g) in rows.zip(self.g.chunks_exact(half)) {
            geglu_row_backward(dx, x, g);
        }
    }
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
