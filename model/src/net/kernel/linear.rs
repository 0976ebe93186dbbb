//! The dense layer: y = x · Wᵀ + b, with W as PyTorch stores it, [O, I].

use rayon::prelude::*;

use super::matmul::{Into, Mat, MatMut, matmul};
use super::simd::{Work, add_to, vectorised};
use super::tiles::BLOCK;
use super::{Forward, Gradients, Precision, View, half};

/// Rows one task takes: two tasks a thread, four at least, within bounds that keep the packing of W
/// cheap.
pub(crate) fn rows_per_task(rows: usize) -> usize {
    let tasks = (2 * rayon::current_num_threads()).max(4);
    rows.div_ceil(tasks).next_multiple_of(32).clamp(64, 1024)
}

/// A weight [O, I] of which many products will be made.
pub(crate) enum Weight<'a> {
    Full(Mat<'a>),
    Half { columns: half::Factor, inputs: usize },
}

/// Rows [N, I] on their way through a layer.
pub(crate) enum Product<'a> {
    Full([Mat<'a>; 2]),
    Half { rows: half::Factor, columns: &'a half::Factor },
}

impl<'a> Weight<'a> {
    /// Of this many inputs. A weight that fills no block of tiles is left as it is.
    pub(crate) fn new(data: &'a [f32], inputs: usize, precision: Precision) -> Self {
        let outputs = data.len() / inputs;
        if precision == Precision::Half && inputs.min(outputs) >= BLOCK {
            return Self::Half { columns: half::Factor::right(data, inputs), inputs };
        }
        Self::Full(Mat::new(data, outputs, inputs, inputs))
    }

    /// Takes rows as wide as the inputs.
    pub(crate) fn of_rows<'b>(&'b self, x: &'b [f32]) -> Product<'b> {
        match self {
            Self::Full(weight) => {
                let inputs = weight.size()[1];
                Product::Full([Mat::new(x, x.len() / inputs, inputs, inputs), *weight])
            }
            Self::Half { columns, inputs } => {
                Product::Half { rows: half::Factor::left(x, *inputs), columns }
            }
        }
    }
}

impl Product<'_> {
    /// `y = x · Wᵀ` or `y += x · Wᵀ`: as many of its columns as y has, from `first`, a multiple
    /// of [`BLOCK`].
    pub(crate) fn columns(&self, y: MatMut, first: usize, into: Into) {
        match self {
            Self::Full([x, weight]) => {
                let columns = weight.rows(first, y.size()[1]);
                matmul(y, *x, columns.transposed(), into);
            }
            Self::Half { rows, columns } => half::product(y, rows, columns, first, into),
        }
    }
}

/// x [.., I], weight [O, I], bias [O] or none → [.., O].
pub(crate) fn forward([x, weight, bias]: [View; 3], precision: Precision) -> Forward {
    let (rows, inputs) = (x.rows(), x.width());
    let outputs = weight.shape[0];
    let mut data = vec![0.0; rows * outputs];
    let step = rows_per_task(rows);
    let weight = Weight::new(weight.data, inputs, precision);
    data.par_chunks_mut(step * outputs).zip(x.data.par_chunks(step * inputs)).for_each(|(y, x)| {
        let n = x.len() / inputs;
        let into = if bias.data.is_empty() { Into::Fresh } else { Into::Sum };
        if into == Into::Sum {
            y.chunks_exact_mut(outputs).for_each(|row| row.copy_from_slice(bias.data));
        }
        weight.of_rows(x).columns(MatMut::new(y, n, outputs, outputs), 0, into);
    });
    let mut shape = x.shape.to_vec();
    if let Some(last) = shape.last_mut() {
        *last = outputs;
    }
    Forward { data, shape, kept: vec![] }
}

/// Gradients of x, weight and bias.
pub(crate) fn backward([x, weight, bias]: [View; 3], grad: &[f32], wanted: [bool; 3]) -> Gradients {
    let of_x = if wanted[0] { input_gradient(x, weight, grad) } else { vec![] };
    let of_weight = if wanted[1] { weight_gradient(x, weight, grad) } else { vec![] };
    let bias = wanted[2] && !bias.data.is_empty();
    let of_bias = if bias { column_sums(grad, weight.shape[0]) } else { vec![] };
    [of_x, of_weight, of_bias]
}

fn input_gradient(x: View, weight: View, grad: &[f32]) -> Vec<f32> {
    let (rows, inputs, outputs) = (x.rows(), x.width(), weight.shape[0]);
    let mut out = vec![0.0; x.data.len()];
    let step = rows_per_task(rows);
    out.par_chunks_mut(step * inputs).zip(grad.par_chunks(step * outputs)).for_each(|(dx, g)| {
        let n = g.len() / outputs;
        let w = Mat::new(weight.data, outputs, inputs, inputs);
        let g = Mat::new(g, n, outputs, outputs);
        matmul(MatMut::new(dx, n, inputs, inputs), g, w, Into::Fresh);
    });
    out
}

fn weight_gradient(x: View, weight: View, grad: &[f32]) -> Vec<f32> {
    let (rows, inputs, outputs) = (x.rows(), x.width(), weight.shape[0]);
    let mut out = vec![0.0; weight.data.len()];
    let step = outputs.div_ceil(4).next_multiple_of(16).clamp(16, 512);
    out.par_chunks_mut(step * inputs).enumerate().for_each(|(i, dw)| {
        let n = dw.len() / inputs;
        let g = Mat::new(&grad[i * step..], rows, n, outputs).transposed();
        matmul(
            MatMut::new(dw, n, inputs, inputs),
            g,
            Mat::new(x.data, rows, inputs, inputs),
            Into::Fresh,
        );
    });
    out
}

struct AddRows<'a> {
    sums: &'a mut [f32],
    rows: &'a [f32],
}

impl Work for AddRows<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for row in self.rows.chunks_exact(self.sums.len()) {
            add_to(self.sums, row);
        }
    }
}

/// Sum of each column of a row-major matrix, added in pieces of fixed size and fixed order.
pub(crate) fn column_sums(data: &[f32], width: usize) -> Vec<f32> {
    const ROWS: usize = 512;
    let partial = |rows: &[f32]| {
        let mut sums = vec![0.0; width];
        vectorised(AddRows { sums: &mut sums, rows });
        sums
    };
    let pieces: Vec<_> = data.par_chunks(ROWS * width).map(partial).collect();
    let mut total = vec![0.0; width];
    pieces.iter().for_each(|p| add_to(&mut total, p));
    total
}
