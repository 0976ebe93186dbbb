//! LayerNorm and RMSNorm over short rows, in one pass over memory.

use rayon::prelude::*;

use super::simd::{add_to, dot, sum_of, vectorised};
use super::{Forward, Gradients, View};

/// Rows one task takes.
const ROWS: usize = 256;

/// How a row is normalised before gain and bias.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Norm {
    /// Mean taken off, divided by the standard deviation; `eps` is added to the variance.
    Layer { eps: f32 },
    /// Divided by the root mean square; `eps` is added to the mean square.
    Rms { eps: f32 },
}

/// Mean that is taken off a row, and the factor it is multiplied with.
#[inline(always)]
fn statistics(norm: Norm, row: &[f32]) -> (f32, f32) {
    let n = row.len() as f32;
    let (mean, eps) = match norm {
        Norm::Layer { eps } => (sum_of(row, |x| x) / n, eps),
        Norm::Rms { eps } => (0.0, eps),
    };
    let square = sum_of(row, |x| (x - mean) * (x - mean)) / n;
    (mean, 1.0 / (square + eps).sqrt())
}

impl Norm {
    /// x as rows as wide as the gain; the bias is the gain's size or none.
    pub(crate) fn forward(self, x: View, gain: View, bias: View) -> Forward {
        let width = gain.data.len();
        let mut data = vec![0.0; x.data.len()];
        let step = ROWS * width;
        data.par_chunks_mut(step).zip(x.data.par_chunks(step)).for_each(|(y, x)| {
            vectorised(|| self.forward_rows(y, x, gain.data, bias.data));
        });
        Forward { data, shape: x.shape.to_vec(), kept: vec![] }
    }

    #[inline(always)]
    fn forward_rows(self, y: &mut [f32], x: &[f32], gain: &[f32], bias: &[f32]) {
        let width = gain.len();
        for (y, x) in y.chunks_exact_mut(width).zip(x.chunks_exact(width)) {
            let (mean, scale) = statistics(self, x);
            for i in 0..width {
                y[i] = (x[i] - mean) * scale * gain[i];
            }
            add_to(y, bias);
        }
    }

    /// Gradients of x, gain and bias (the last only for [`Norm::Layer`]).
    pub(crate) fn backward(self, x: View, gain: View, grad: &[f32]) -> Gradients {
        let width = gain.data.len();
        let step = ROWS * width;
        let mut dx = vec![0.0; x.data.len()];
        let pieces: Vec<_> = dx
            .par_chunks_mut(step)
            .zip(x.data.par_chunks(step))
            .zip(grad.par_chunks(step))
            .map(|((dx, x), g)| {
                let mut sums = vec![0.0; 2 * width];
                vectorised(|| self.backward_rows(dx, &mut sums, [x, g, gain.data]));
                sums
            })
            .collect();
        let mut sums = vec![0.0; 2 * width];
        pieces.iter().for_each(|p| add_to(&mut sums, p));
        let bias = sums.split_off(width);
        [dx, sums, if matches!(self, Self::Layer { .. }) { bias } else { vec![] }]
    }

    /// With n the normalised row and h = grad · gain: dx = scale (h − mean h − n · mean(h n)).
    #[inline(always)]
    fn backward_rows(self, dx: &mut [f32], sums: &mut [f32], [x, g, gain]: [&[f32]; 3]) {
        let width = gain.len();
        let (of_gain, of_bias) = sums.split_at_mut(width);
        let mut normal = vec![0.0; width];
        let rows = dx.chunks_exact_mut(width).zip(x.chunks_exact(width));
        for ((dx, x), g) in rows.zip(g.chunks_exact(width)) {
            let (mean, scale) = statistics(self, x);
            for i in 0..width {
                normal[i] = (x[i] - mean) * scale;
                dx[i] = g[i] * gain[i];
                of_gain[i] += g[i] * normal[i];
                of_bias[i] += g[i];
            }
            let along = dot(dx, &normal) / width as f32;
            let level = match self {
                Self::Layer { .. } => sum_of(dx, |h| h) / width as f32,
                Self::Rms { .. } => 0.0,
            };
            for i in 0..width {
                dx[i] = scale * (dx[i] - level - normal[i] * along);
            }
        }
    }
}
