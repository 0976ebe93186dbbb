//! Softmax attention in blocks, forward and backward; no score matrix is ever stored.
//!
//! A task takes [`ROWS`] queries and walks over the keys in tiles of [`KEYS`], keeping a running
//! maximum and sum per row; the backward pass recomputes the scores from the saved
//! log-sum-exp. Heads are column ranges of [B, N, D], so nothing is transposed or copied.

use rayon::prelude::*;

use super::matmul::{Into, Mat, MatMut, matmul};
use super::simd::{LANES, Work, dot, exp_negative, largest, sum_of, vectorised};
use super::{Forward, Gradients, Saved, View};

/// Queries of one task, and keys of one tile: their scores (1 MiB) stay in the second-level cache.
const ROWS: usize = 256;
const KEYS: usize = 1024;

/// softmax(q kᵀ / √(D / heads)) v, head by head.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Attention {
    /// Heads; D is a multiple of it.
    pub(crate) heads: usize,
    /// How many keys of each batch element count; empty means all of them.
    pub(crate) lengths: Vec<usize>,
}

/// One head of one batch element: where its columns lie.
#[derive(Clone, Copy)]
struct Head<'a> {
    k: &'a [f32],
    v: &'a [f32],
    keys: usize,
    stride: usize,
    width: usize,
    scale: f32,
}

impl Attention {
    fn keys(&self, batch: usize, all: usize) -> usize {
        self.lengths.get(batch).map_or(all, |&l| l.min(all))
    }

    fn head<'a>(&self, k: View<'a>, v: View<'a>, batch: usize, head: usize) -> Head<'a> {
        let (all, stride) = (k.shape[1], k.shape[2]);
        let width = stride / self.heads;
        let from = batch * all * stride + head * width;
        let keys = self.keys(batch, all);
        let scale = 1.0 / (width as f32).sqrt();
        let (k, v) = (k.data.get(from..).unwrap_or(&[]), v.data.get(from..).unwrap_or(&[]));
        Head { k, v, keys, stride, width, scale }
    }

    /// q [B, N, D], k and v [B, L, D] → [B, N, D]; keeps the log-sum-exp of the scores [B, N, heads].
    pub(crate) fn forward(&self, q: View, k: View, v: View) -> Forward {
        let [batch, n, d] = [q.shape[0], q.shape[1], q.shape[2]];
        let mut data = vec![0.0; batch * n * d];
        let mut kept = vec![0.0; batch * n * self.heads];
        for b in 0..batch {
            let q = &q.data[b * n * d..][..n * d];
            let out = data[b * n * d..][..n * d].par_chunks_mut(ROWS * d);
            let sums =
                kept[b * n * self.heads..][..n * self.heads].par_chunks_mut(ROWS * self.heads);
            out.zip(sums).zip(q.par_chunks(ROWS * d)).for_each(|((out, sums), q)| {
                let mut block = Block::new(q.len() / d, self.keys(b, k.shape[1]));
                for h in 0..self.heads {
                    let head = self.head(k, v, b, h);
                    let from = h * head.width;
                    block.forward(&mut out[from..], &q[from..], head);
                    let lse = sums[h..].iter_mut().step_by(self.heads);
                    lse.zip(block.log_sum_exp()).for_each(|(s, l)| *s = l);
                }
            });
        }
        Forward { data, shape: q.shape.to_vec(), kept }
    }

    /// Gradients of q, k and v.
    pub(crate) fn backward(&self, [q, k, v]: [View; 3], saved: Saved, grad: &[f32]) -> Gradients {
        let ([batch, n, d], all) = ([q.shape[0], q.shape[1], q.shape[2]], k.shape[1]);
        let mut out = [q, k, v].map(|x| vec![0.0; x.data.len()]);
        let pairs: Vec<_> = (0..batch * self.heads).collect();
        let gradients: Vec<Gradients> = pairs
            .par_iter()
            .map(|&i| {
                let (b, h) = (i / self.heads, i % self.heads);
                let head = self.head(k, v, b, h);
                let from = b * n * d + h * head.width;
                let [q, o, g] = [q.data, saved.out, grad].map(|x| x.get(from..).unwrap_or(&[]));
                let lse = saved.kept[b * n * self.heads + h..].iter().step_by(self.heads);
                let lse: Vec<f32> = lse.copied().take(n).collect();
                Backward { q, o, g, lse, head }.run(n)
            })
            .collect();
        for (i, parts) in gradients.iter().enumerate() {
            let (b, h) = (i / self.heads, i % self.heads);
            let width = d / self.heads;
            for (out, (part, rows)) in out.iter_mut().zip(parts.iter().zip([n, all, all])) {
                let to = out[b * rows * d..][..rows * d].chunks_exact_mut(d);
                let columns = h * width..(h + 1) * width;
                to.zip(part.chunks_exact(width))
                    .for_each(|(t, p)| t[columns.clone()].copy_from_slice(p));
            }
        }
        out
    }
}

/// Working space of one task.
struct Block {
    scores: Vec<f32>,
    /// Running maximum of each row's scaled scores, and the sum of exponentials under it.
    top: Vec<f32>,
    sum: Vec<f32>,
}

impl Block {
    fn new(rows: usize, keys: usize) -> Self {
        let scores = vec![0.0; rows * keys.min(KEYS)];
        Self { scores, top: vec![0.0; rows], sum: vec![0.0; rows] }
    }

    /// `out` and `q` begin at the head's first column; their rows lie `head.stride` apart.
    fn forward(&mut self, out: &mut [f32], q: &[f32], head: Head) {
        let rows = self.top.len();
        self.top.fill(f32::NEG_INFINITY);
        self.sum.fill(0.0);
        for from in (0..head.keys).step_by(KEYS) {
            let tile = KEYS.min(head.keys - from);
            let scores = &mut self.scores[..rows * tile];
            let [k, v] = [head.k, head.v]
                .map(|x| Mat::new(&x[from * head.stride..], tile, head.width, head.stride));
            let q = Mat::new(q, rows, head.width, head.stride);
            matmul(MatMut::new(scores, rows, tile, tile), q, k.transposed(), Into::Fresh);
            let (top, sum) = (&mut self.top[..], &mut self.sum[..]);
            vectorised(Soften { scores, out, top, sum, tile, head });
            let into = if from > 0 { Into::Sum } else { Into::Fresh };
            let weights = Mat::new(scores, rows, tile, tile);
            matmul(MatMut::new(out, rows, head.width, head.stride), weights, v, into);
        }
        for (r, &sum) in self.sum.iter().enumerate() {
            let share = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            out[r * head.stride..][..head.width].iter_mut().for_each(|x| *x *= share);
        }
    }

    fn log_sum_exp(&self) -> impl Iterator<Item = f32> {
        self.top.iter().zip(&self.sum).map(|(top, sum)| top + sum.ln())
    }
}

/// One tile of scores on its way to exponentials, and what was summed before it.
struct Soften<'a> {
    scores: &'a mut [f32],
    out: &'a mut [f32],
    top: &'a mut [f32],
    sum: &'a mut [f32],
    tile: usize,
    head: Head<'a>,
}

impl Work for Soften<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Head { scale, stride, width, .. } = self.head;
        let sums = self.top.iter_mut().zip(self.sum);
        let rows = self.scores.chunks_exact_mut(self.tile).zip(self.out.chunks_mut(stride));
        for ((row, out), (top, sum)) in rows.zip(sums) {
            let shrink = exponentials(row, scale, top, sum);
            if shrink != 1.0 {
                for x in &mut out[..width] {
                    *x *= shrink;
                }
            }
        }
    }
}

/// Turns scores into exponentials under the running maximum; gives the factor by which everything
/// summed before must shrink.
#[inline(always)]
fn exponentials(row: &mut [f32], scale: f32, top: &mut f32, sum: &mut f32) -> f32 {
    let new = (largest(row) * scale).max(*top);
    let shrink = exp_negative((*top - new).max(f32::MIN));
    *sum = *sum * shrink + exponentiate(row, scale, new);
    *top = new;
    shrink
}

/// Turns each score into exp(scale · score − top), in place, and sums them.
#[inline(always)]
fn exponentiate(row: &mut [f32], scale: f32, top: f32) -> f32 {
    let (chunks, tail) = row.as_chunks_mut::<LANES>();
    let mut lanes = [0f32; LANES];
    for chunk in chunks {
        for (lane, x) in lanes.iter_mut().zip(chunk) {
            *x = exp_negative(x.mul_add(scale, -top));
            *lane += *x;
        }
    }
    tail.iter_mut().for_each(|x| *x = exp_negative(x.mul_add(scale, -top)));
    sum_of(&lanes, |x| x) + sum_of(tail, |x| x)
}

/// What one head's backward pass reads; slices begin at the head's first column.
struct Backward<'a> {
    q: &'a [f32],
    o: &'a [f32],
    g: &'a [f32],
    lse: Vec<f32>,
    head: Head<'a>,
}

impl Backward<'_> {
    /// Gradients of the head's q [n, width], k and v [keys, width].
    fn run(&self, n: usize) -> Gradients {
        let Head { keys, width, .. } = self.head;
        let mut out = [vec![0.0; n * width], vec![0.0; keys * width], vec![0.0; keys * width]];
        let size = ROWS.min(n) * KEYS.min(keys);
        let (mut p, mut ds) = (vec![0.0; size], vec![0.0; size]);
        for row in (0..n).step_by(ROWS) {
            let rows = ROWS.min(n - row);
            let turn = self.turn(row, rows);
            for key in (0..keys).step_by(KEYS) {
                let tile = KEYS.min(keys - key);
                let (p, ds) = (&mut p[..rows * tile], &mut ds[..rows * tile]);
                self.tile([p, ds], &mut out, &turn, [row, key]);
            }
        }
        out
    }

    /// For each row, the product of output and its gradient.
    fn turn(&self, row: usize, rows: usize) -> Vec<f32> {
        let Head { stride, width, .. } = self.head;
        let at = |r: usize| (row + r) * stride..(row + r) * stride + width;
        (0..rows).map(|r| dot(&self.o[at(r)], &self.g[at(r)])).collect()
    }

    /// One block of rows against one tile of keys: dv += pᵀ g, dk += dsᵀ q, dq += ds k.
    fn tile(
        &self,
        [p, ds]: [&mut [f32]; 2],
        out: &mut Gradients,
        turn: &[f32],
        [row, key]: [usize; 2],
    ) {
        let Head { stride, width, scale, .. } = self.head;
        let rows = turn.len();
        let tile = p.len() / rows;
        let [q, g] = [self.q, self.g].map(|x| Mat::new(&x[row * stride..], rows, width, stride));
        let [k, v] =
            [self.head.k, self.head.v].map(|x| Mat::new(&x[key * stride..], tile, width, stride));
        matmul(MatMut::new(p, rows, tile, tile), q, k.transposed(), Into::Fresh);
        matmul(MatMut::new(ds, rows, tile, tile), g, v.transposed(), Into::Fresh);
        let lse = &self.lse[row..];
        vectorised(ScoreSlopes { p: &mut *p, ds: &mut *ds, lse, turn, tile, scale });
        let [p, ds] = [&*p, &*ds].map(|x| Mat::new(x, rows, tile, tile));
        let [dq, dk, dv] = out;
        let to = |x, n| MatMut::new(x, n, width, width);
        matmul(to(&mut dv[key * width..], tile), p.transposed(), g, Into::Sum);
        matmul(to(&mut dk[key * width..], tile), ds.transposed(), q, Into::Sum);
        matmul(to(&mut dq[row * width..], rows), ds, k, Into::Sum);
    }
}

/// Turns tiles of scores p and of gradients ds of the weights into weights and gradients of scores,
/// given each row's log-sum-exp and turn.
struct ScoreSlopes<'a> {
    p: &'a mut [f32],
    ds: &'a mut [f32],
    lse: &'a [f32],
    turn: &'a [f32],
    tile: usize,
    scale: f32,
}

impl Work for ScoreSlopes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let rows = self.p.chunks_exact_mut(self.tile).zip(self.ds.chunks_exact_mut(self.tile));
        for ((p, ds), (&lse, &turn)) in rows.zip(self.lse.iter().zip(self.turn)) {
            for (p, ds) in p.iter_mut().zip(ds) {
                *p = exp_negative(p.mul_add(self.scale, -lse));
                *ds = *p * (*ds - turn) * self.scale;
            }
        }
    }
}
