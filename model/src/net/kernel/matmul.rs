//! Matrix products on borrowed, strided matrices: the safe face of the `gemm` crate.

#![allow(unsafe_code)]

use gemm::Parallelism;

use super::simd::add_to;

/// A matrix inside a slice: element (r, c) is `data[r * row_stride + c * col_stride]`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mat<'a> {
    data: &'a [f32],
    rows: usize,
    cols: usize,
    row_stride: usize,
    col_stride: usize,
}

impl<'a> Mat<'a> {
    /// The first `rows` × `cols` of row-major data whose rows lie `stride` apart.
    pub(crate) fn new(data: &'a [f32], rows: usize, cols: usize, stride: usize) -> Self {
        assert!(fits(data.len(), rows, cols, stride), "matrix {rows} × {cols} leaves its slice");
        Self { data, rows, cols, row_stride: stride, col_stride: 1 }
    }

    /// Rows and columns.
    pub(crate) fn size(self) -> [usize; 2] {
        [self.rows, self.cols]
    }

    /// Some of its rows.
    pub(crate) fn rows(self, first: usize, count: usize) -> Self {
        assert!(first + count <= self.rows, "rows {first} to {} of {}", first + count, self.rows);
        Self { data: &self.data[first * self.row_stride..], rows: count, ..self }
    }

    /// Rows and columns exchanged, without moving data.
    pub(crate) fn transposed(self) -> Self {
        Self {
            rows: self.cols,
            cols: self.rows,
            row_stride: self.col_stride,
            col_stride: self.row_stride,
            ..self
        }
    }
}

/// A row-major matrix that is written: rows lie `stride` apart.
#[derive(Debug)]
pub(crate) struct MatMut<'a> {
    data: &'a mut [f32],
    rows: usize,
    cols: usize,
    stride: usize,
}

impl<'a> MatMut<'a> {
    /// The first `rows` × `cols` of row-major data whose rows lie `stride` apart.
    pub(crate) fn new(data: &'a mut [f32], rows: usize, cols: usize, stride: usize) -> Self {
        assert!(fits(data.len(), rows, cols, stride), "matrix {rows} × {cols} leaves its slice");
        Self { data, rows, cols, stride }
    }

    /// Rows and columns.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.rows, self.cols]
    }

    /// Puts the block whose first element belongs at this row and column; what of it lies outside
    /// is left out.
    pub(crate) fn put<const N: usize>(
        &mut self,
        [row, col]: [usize; 2],
        block: &[[f32; N]],
        into: Into,
    ) {
        if row >= self.rows || col >= self.cols {
            return;
        }
        let width = N.min(self.cols - col);
        let rows = self.data[row * self.stride + col..].chunks_mut(self.stride);
        for (to, from) in rows.take(self.rows - row).zip(block) {
            match into {
                Into::Fresh => to[..width].copy_from_slice(&from[..width]),
                Into::Sum => add_to(&mut to[..width], &from[..width]),
            }
        }
    }
}

fn fits(len: usize, rows: usize, cols: usize, stride: usize) -> bool {
    rows == 0 || cols == 0 || (cols <= stride && (rows - 1) * stride + cols <= len)
}

/// What becomes of the values that stand in the result's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Into {
    /// They are overwritten.
    Fresh,
    /// The product is added to them.
    Sum,
}

/// `out = a · b` or `out += a · b`, on the calling thread.
pub(crate) fn matmul(out: MatMut, a: Mat, b: Mat, into: Into) {
    assert!(
        out.rows == a.rows && out.cols == b.cols && a.cols == b.rows,
        "product of {} × {} and {} × {} into {} × {}",
        a.rows,
        a.cols,
        b.rows,
        b.cols,
        out.rows,
        out.cols
    );
    if out.rows == 0 || out.cols == 0 {
        return;
    }
    if a.cols == 0 {
        clear_unless_summed(out, into);
        return;
    }
    let add = into == Into::Sum;
    let alpha = if add { 1.0 } else { 0.0 };
    // SAFETY: `Mat::new` and `MatMut::new` proved that every element a stride reaches lies inside
    // its slice (a transposed view reaches the same elements), the shapes agree (assertion above),
    // and `out` is borrowed mutably, so it overlaps neither factor.
    unsafe {
        gemm::gemm(
            out.rows,
            out.cols,
            a.cols,
            out.data.as_mut_ptr(),
            1,
            out.stride as isize,
            add,
            a.data.as_ptr(),
            a.col_stride as isize,
            a.row_stride as isize,
            b.data.as_ptr(),
            b.col_stride as isize,
            b.row_stride as isize,
            alpha,
            1.0,
            false,
            false,
            false,
            Parallelism::None,
        );
    }
}

/// A product over nothing is zero.
fn clear_unless_summed(out: MatMut, into: Into) {
    if into == Into::Fresh {
        for r in 0..out.rows {
            out.data[r * out.stride..][..out.cols].fill(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_of_views_meets_the_sum_over_indices() {
        let a: Vec<f32> = (0..7 * 5).map(|i| i as f32 * 0.5 - 3.0).collect();
        let b: Vec<f32> = (0..3 * 5).map(|i| 1.0 - i as f32 * 0.25).collect();
        let mut out = vec![1.0; 7 * 4];
        let views = (Mat::new(&a, 7, 5, 5), Mat::new(&b, 3, 5, 5).transposed());
        matmul(MatMut::new(&mut out, 7, 3, 4), views.0, views.1, Into::Fresh);
        matmul(MatMut::new(&mut out, 7, 3, 4), views.0, views.1, Into::Sum);
        for r in 0..7 {
            for c in 0..3 {
                let truth: f32 = (0..5).map(|k| a[r * 5 + k] * b[c * 5 + k]).sum();
                assert!((out[r * 4 + c] - 2.0 * truth).abs() < 1e-4);
            }
            assert_eq!(out[r * 4 + 3], 1.0, "the gap between rows is left alone");
        }
    }

    #[test]
    #[should_panic(expected = "leaves its slice")]
    fn a_matrix_larger_than_its_slice_is_refused() {
        Mat::new(&[0.0; 11], 3, 4, 4);
    }
}
