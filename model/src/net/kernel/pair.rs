//! Heads over pairs without the tensor of all pairs: the first layer of ψ([q; l]) splits into
//! A q + C l, so only silu(a + c) is formed, a row at a time.

use rayon::prelude::*;

use super::activation::silu_slope;
use super::simd::{LANES, Work, add_to, sigmoid, vectorised};
use super::{Forward, Gradients, View};

/// Rows of queries one task takes.
const ROWS: usize = 128;

/// Σ_f w[f] · silu(a[f] + b[f]).
#[inline(always)]
fn logit(a: &[f32], b: &[f32], w: &[f32]) -> f32 {
    let term = |a: f32, b: f32, w: f32| (a + b) * sigmoid(a + b) * w;
    let ((xs, x), (ys, y), (ws, v)) =
        (a.as_chunks::<LANES>(), b.as_chunks::<LANES>(), w.as_chunks::<LANES>());
    let mut lanes = [0f32; LANES];
    for ((x, y), w) in xs.iter().zip(ys).zip(ws) {
        for i in 0..LANES {
            lanes[i] += term(x[i], y[i], w[i]);
        }
    }
    let tail: f32 = x.iter().zip(y).zip(v).map(|((&x, &y), &w)| term(x, y, w)).sum();
    super::simd::sum_of(&lanes, |x| x) + tail
}

/// A row of logits for each row of a.
struct Logits<'a> {
    out: &'a mut [f32],
    a: &'a [f32],
    b: &'a [f32],
    w: &'a [f32],
}

impl Work for Logits<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let f = self.w.len();
        let rows = self.out.chunks_exact_mut(self.b.len() / f).zip(self.a.chunks_exact(f));
        for (out, a) in rows {
            for (out, b) in out.iter_mut().zip(self.b.chunks_exact(f)) {
                *out = logit(a, b, self.w);
            }
        }
    }
}

/// a [B, N, F], b [B, P, F], w [1, F] → [B, N, P].
pub(crate) fn logits(a: View, b: View, w: View) -> Forward {
    let ([batch, n, f], parts) = ([a.shape[0], a.shape[1], a.shape[2]], b.shape[1]);
    let mut data = vec![0.0; batch * n * parts];
    for i in 0..batch {
        let (a, b) = (&a.data[i * n * f..][..n * f], &b.data[i * parts * f..][..parts * f]);
        let out = &mut data[i * n * parts..][..n * parts];
        out.par_chunks_mut(ROWS * parts).zip(a.par_chunks(ROWS * f)).for_each(|(out, a)| {
            vectorised(Logits { out, a, b, w: w.data });
        });
    }
    Forward { data, shape: vec![batch, n, parts], kept: vec![] }
}

/// Gradients of a, b and w of [`logits`].
pub(crate) fn logits_backward([a, b, w]: [View; 3], grad: &[f32]) -> Gradients {
    let ([batch, n, f], parts) = ([a.shape[0], a.shape[1], a.shape[2]], b.shape[1]);
    let mut out = [vec![0.0; a.data.len()], vec![0.0; b.data.len()], vec![0.0; f]];
    for i in 0..batch {
        let (x, y) = (&a.data[i * n * f..][..n * f], &b.data[i * parts * f..][..parts * f]);
        let da = &mut out[0][i * n * f..][..n * f];
        let g = &grad[i * n * parts..][..n * parts];
        let pieces: Vec<_> = da
            .par_chunks_mut(ROWS * f)
            .zip(x.par_chunks(ROWS * f))
            .zip(g.par_chunks(ROWS * parts))
            .map(|((da, a), g)| {
                let mut sums = vec![0.0; (parts + 1) * f];
                vectorised(LogitSlopes { da, sums: &mut sums, a, b: y, w: w.data, grad: g });
                sums
            })
            .collect();
        for piece in &pieces {
            add_to(&mut out[1][i * parts * f..][..parts * f], piece);
            add_to(&mut out[2], &piece[parts * f..]);
        }
    }
    out
}

struct LogitSlopes<'a> {
    da: &'a mut [f32],
    /// The gradients of b's rows, then that of w.
    sums: &'a mut [f32],
    a: &'a [f32],
    b: &'a [f32],
    w: &'a [f32],
    grad: &'a [f32],
}

impl Work for LogitSlopes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { da, sums, a, b, w, grad } = self;
        let f = w.len();
        let parts = b.len() / f;
        let (db, dw) = sums.split_at_mut(parts * f);
        for ((da, a), grad) in
            da.chunks_exact_mut(f).zip(a.chunks_exact(f)).zip(grad.chunks_exact(parts))
        {
            for ((db, b), &g) in db.chunks_exact_mut(f).zip(b.chunks_exact(f)).zip(grad) {
                for i in 0..f {
                    let z = a[i] + b[i];
                    let s = sigmoid(z);
                    let d = g * w[i] * (s + z * s * (1.0 - s));
                    da[i] += d;
                    db[i] += d;
                    dw[i] += g * z * s;
                }
            }
        }
    }
}

/// Which pairs are wanted: row r takes query `query[r]` and case `case[r]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Rows {
    pub(crate) query: Vec<u32>,
    pub(crate) case: Vec<u32>,
}

/// Some of the rows: `out` has one of `f` numbers for each.
struct Pairs<'a> {
    out: &'a mut [f32],
    query: &'a [u32],
    case: &'a [u32],
    a: &'a [f32],
    c: &'a [f32],
    f: usize,
}

/// silu(a + c).
struct Activate<'a>(Pairs<'a>);

/// What stands there, times the slope of silu at a + c.
struct Slopes<'a>(Pairs<'a>);

impl Work for Activate<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Pairs { out, query, case, a, c, f } = self.0;
        let rows = out.chunks_exact_mut(f).zip(query.iter().zip(case));
        for (out, (&q, &e)) in rows {
            let (a, c) = (&a[q as usize * f..][..f], &c[e as usize * f..][..f]);
            for i in 0..f {
                out[i] = (a[i] + c[i]) * sigmoid(a[i] + c[i]);
            }
        }
    }
}

impl Work for Slopes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Pairs { out, query, case, a, c, f } = self.0;
        let rows = out.chunks_exact_mut(f).zip(query.iter().zip(case));
        for (out, (&q, &e)) in rows {
            let (a, c) = (&a[q as usize * f..][..f], &c[e as usize * f..][..f]);
            for i in 0..f {
                out[i] *= silu_slope(a[i] + c[i]);
            }
        }
    }
}

impl Rows {
    /// a [.., F], c [E, F] → silu(a[query] + c[case]) [R, F].
    pub(crate) fn forward(&self, a: View, c: View) -> Forward {
        let f = a.width();
        let mut data = vec![0.0; self.query.len() * f];
        let pairs = self.query.par_chunks(ROWS).zip(self.case.par_chunks(ROWS));
        data.par_chunks_mut(ROWS * f).zip(pairs).for_each(|(out, (query, case))| {
            let pairs = Pairs { out, query, case, a: a.data, c: c.data, f };
            vectorised(Activate(pairs));
        });
        Forward { data, shape: vec![self.query.len(), f], kept: vec![] }
    }

    /// Gradients of a and c of [`Rows::forward`].
    pub(crate) fn backward(&self, a: View, c: View, grad: &[f32]) -> Gradients {
        let f = a.width();
        let mut slope = grad.to_vec();
        let pairs = self.query.par_chunks(ROWS).zip(self.case.par_chunks(ROWS));
        slope.par_chunks_mut(ROWS * f).zip(pairs).for_each(|(d, (query, case))| {
            let pairs = Pairs { out: d, query, case, a: a.data, c: c.data, f };
            vectorised(Slopes(pairs));
        });
        let (mut da, mut dc) = (vec![0.0; a.data.len()], vec![0.0; c.data.len()]);
        for (d, (&q, &e)) in slope.chunks_exact(f).zip(self.query.iter().zip(&self.case)) {
            add_to(&mut da[q as usize * f..][..f], d);
            add_to(&mut dc[e as usize * f..][..f], d);
        }
        [da, dc, vec![]]
    }
}
