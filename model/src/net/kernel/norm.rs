//! LayerNorm and RMSNorm over short rows, in one pass over memory.

use rayon::prelude::*;

use super::simd::{Work, add_to, dot, sum_of, vectorised};
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
            vectorised(Normalise { norm: self, y, x, gain: gain.data, bias: bias.data });
        });
        Forward { data, shape: x.shape.to_vec(), kept: vec![] }
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
                vectorised(Slopes { norm: self, dx, sums: &mut sums, x, g, gain: gain.data });
                sums
            })
            .collect();
        let mut sums = vec![0.0; 2 * width];
        pieces.iter().for_each(|p| add_to(&mut sums, p));
        let bias = sums.split_off(width);
        [dx, sums, if matches!(self, Self::Layer { .. }) { bias } else { vec![] }]
    }
}

/// Rows of y from rows of x.
struct Normalise<'a> {
    norm: Norm,
    y: &'a mut [f32],
    x: &'a [f32],
    gain: &'a [f32],
    bias: &'a [f32],
}

impl Work for Normalise<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (gain, width) = (self.gain, self.gain.len());
        for (y, x) in self.y.chunks_exact_mut(width).zip(self.x.chunks_exact(width)) {
            let (mean, scale) = statistics(self.norm, x);
            for i in 0..width {
                y[i] = (x[i] - mean) * scale * gain[i];
            }
            add_to(y, self.bias);
        }
    }
}

/// With n the normalised row and h = grad · gain: dx = scale (h − mean h − n · mean(h n)).
struct Slopes<'a> {
    norm: Norm,
    dx: &'a mut [f32],
    /// Gradients of the gain, then of the bias.
    sums: &'a mut [f32],
    x: &'a [f32],
    g: &'a [f32],
    gain: &'a [f32],
}

impl Work for Slopes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { norm, dx, sums, x, g, gain } = self;
        let width = gain.len();
        let (of_gain, of_bias) = sums.split_at_mut(width);
        let mut normal = vec![0.0; width];
        let rows = dx.chunks_exact_mut(width).zip(x.chunks_exact(width));
        for ((dx, x), g) in rows.zip(g.chunks_exact(width)) {
            let (mean, scale) = statistics(norm, x);
            for i in 0..width {
                normal[i] = (x[i] - mean) * scale;
                dx[i] = g[i] * gain[i];
                of_gain[i] += g[i] * normal[i];
                of_bias[i] += g[i];
            }
            let along = dot(dx, &normal) / width as f32;
            let level = match norm {
                Norm::Layer { .. } => sum_of(dx, |h| h) / width as f32,
                Norm::Rms { .. } => 0.0,
            };
            for i in 0..width {
                dx[i] = scale * (dx[i] - level - normal[i] * along);
            }
        }
    }
}
