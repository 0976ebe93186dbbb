//! Matrix products in half precision: factors rounded to bf16 and cut into tiles, sums in f32.
//!
//! An element of the product is a sum over k in an order of its own, so it does not depend on which
//! other rows and columns are asked for, nor on who multiplies the tiles.

use rayon::prelude::*;

use super::matmul::{Into, MatMut};
use super::simd::{Work, vectorised};
use super::tiles::{BLOCK, NOTHING, SIDE, Tile, with_tiles};

/// Rows of the left factor that are multiplied with all columns before the next: at a few thousand
/// columns of it they stay in the second-level cache.
const ROWS: usize = 256;

/// Numbers of a row of a tile.
const DEEP: usize = 2 * SIDE;

/// A factor, padded with zeros to whole blocks: strips of 16 of its rows (of the left factor) or
/// columns (of the right one), each a run of tiles along k.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    tiles: Vec<Tile>,
    lines: usize, // rows or columns without the padding
    run: usize,   // tiles of a strip
}

impl Factor {
    /// The left factor, row-major with rows of this width.
    pub(crate) fn left(rows: &[f32], width: usize) -> Self {
        let mut factor = Self::zeros(rows.len() / width, width);
        let strips = factor.tiles.chunks_mut(factor.run).zip(rows.chunks(SIDE * width));
        strips.for_each(|(tiles, rows)| {
            vectorised(Rows { tiles, rows, width });
        });
        factor
    }

    /// The right factor, from its transpose, row-major with rows of this width: what a dense layer
    /// has as its weight.
    pub(crate) fn right(columns: &[f32], width: usize) -> Self {
        let mut factor = Self::zeros(columns.len() / width, width);
        let strips = factor.tiles.par_chunks_mut(factor.run);
        strips.zip(columns.par_chunks(SIDE * width)).for_each(|(tiles, columns)| {
            vectorised(Columns { tiles, columns, width });
        });
        factor
    }

    fn zeros(lines: usize, width: usize) -> Self {
        let (strips, run) = (lines.next_multiple_of(BLOCK) / SIDE, width.div_ceil(DEEP));
        Self { tiles: vec![Tile([[0; SIDE]; SIDE]); strips * run], lines, run }
    }

    /// The two strips of a block of lines; `line` is a multiple of [`BLOCK`].
    fn block(&self, line: usize) -> [&[Tile]; 2] {
        let strip = |i: usize| &self.tiles[(line / SIDE + i) * self.run..][..self.run];
        [strip(0), strip(1)]
    }
}

/// `out = a · b` or `out += a · b`, with the columns of b from `first`, a multiple of [`BLOCK`]; on
/// the calling thread.
pub(crate) fn product(mut out: MatMut, a: &Factor, b: &Factor, first: usize, into: Into) {
    let [rows, columns] = out.size();
    assert!(
        a.run == b.run
            && rows <= a.lines
            && first.is_multiple_of(BLOCK)
            && first + columns <= b.lines,
        "product of {rows} of {} rows and columns {first} to {} of {}, {} and {} tiles long",
        a.lines,
        first + columns,
        b.lines,
        a.run,
        b.run
    );
    with_tiles(|tiles| {
        let mut sums = NOTHING;
        for top in (0..rows).step_by(ROWS) {
            for column in (0..columns).step_by(BLOCK) {
                for row in (top..rows.min(top + ROWS)).step_by(BLOCK) {
                    tiles.multiply(a.block(row), b.block(first + column), &mut sums);
                    for (i, sums) in sums.iter().enumerate() {
                        out.put([row + i / 2 * SIDE, column + i % 2 * SIDE], &sums.0, into);
                    }
                }
            }
        }
    });
}

/// A strip of the left factor: row m of a tile is a piece of row m.
struct Rows<'a> {
    tiles: &'a mut [Tile],
    rows: &'a [f32],
    width: usize,
}

impl Work for Rows<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (m, row) in self.rows.chunks_exact(self.width).enumerate() {
            for (tile, piece) in self.tiles.iter_mut().zip(row.chunks(DEEP)) {
                tile.0[m] = pairs(piece);
            }
        }
    }
}

/// A strip of the right factor: column n of a tile is a piece of column n.
struct Columns<'a> {
    tiles: &'a mut [Tile],
    columns: &'a [f32],
    width: usize,
}

impl Work for Columns<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (n, column) in self.columns.chunks_exact(self.width).enumerate() {
            for (tile, piece) in self.tiles.iter_mut().zip(column.chunks(DEEP)) {
                for (row, pair) in tile.0.iter_mut().zip(pairs(piece)) {
                    row[n] = pair;
                }
            }
        }
    }
}

/// Up to 32 numbers as pairs of bf16, the first of a pair in the low bits; zeros after the last.
#[inline(always)]
fn pairs(piece: &[f32]) -> [u32; SIDE] {
    let mut whole = [0f32; DEEP];
    whole[..piece.len()].copy_from_slice(piece);
    let mut pairs = [0; SIDE];
    for (pair, x) in pairs.iter_mut().zip(whole.as_chunks::<2>().0) {
        *pair = rounded(x[0]) >> 16 | rounded(x[1]) & 0xffff_0000;
    }
    pairs
}

/// The nearest bf16, of two the one with an even last bit, in the upper half.
#[inline(always)]
fn rounded(x: f32) -> u32 {
    const QUIET: u32 = 1 << 22;
    let bits = x.to_bits();
    let up = bits.wrapping_add(0x7fff + (bits >> 16 & 1));
    if x.is_nan() { bits | QUIET } else { up }
}

#[cfg(test)]
mod tests {
    use super::super::tests::numbers;
    use super::*;

    /// Sums over k of the rounded factors in f64, and of their absolute values.
    fn truth(x: &[f32], w: &[f32], width: usize) -> Vec<[f64; 2]> {
        let near = |x: &f32| f64::from(half::bf16::from_f32(*x));
        let dot = |x: &[f32], w: &[f32]| {
            let terms = x.iter().zip(w).map(|(x, w)| near(x) * near(w));
            terms.fold([0.0, 0.0], |[sum, size], t| [sum + t, size + t.abs()])
        };
        x.chunks(width).flat_map(|x| w.chunks(width).map(move |w| dot(x, w))).collect()
    }

    fn multiplied(x: &[f32], w: &[f32], width: usize) -> Vec<f32> {
        let (rows, columns) = (x.len() / width, w.len() / width);
        let mut out = vec![0.0; rows * columns];
        let (a, b) = (Factor::left(x, width), Factor::right(w, width));
        product(MatMut::new(&mut out, rows, columns, columns), &a, &b, 0, Into::Fresh);
        out
    }

    #[test]
    fn a_product_of_any_size_is_that_of_the_rounded_factors() {
        let sizes: &[_] = if cfg!(miri) {
            &[[1, 1, 1], [17, 33, 3], [3, 5, 18]]
        } else {
            &[
                [1, 1, 1],
                [3, 5, 7],
                [16, 32, 16],
                [17, 33, 15],
                [32, 64, 32],
                [33, 95, 65],
                [259, 37, 70],
                [300, 257, 31],
            ]
        };
        for &[m, k, n] in sizes {
            let (x, w) = (numbers(m * k, 1), numbers(n * k, 2));
            let found = multiplied(&x, &w, k);
            for (found, [sum, size]) in found.iter().zip(truth(&x, &w, k)) {
                let off = (f64::from(*found) - sum).abs();
                assert!(off <= 1e-6 * size, "{m} × {k} × {n}: {found} for {sum}");
            }
        }
    }

    #[test]
    fn a_product_can_be_added_and_its_columns_taken_from_any_block() {
        let (m, k, n) = (5, 40, 71);
        let (x, w) = (numbers(m * k, 3), numbers(n * k, 4));
        let whole = multiplied(&x, &w, k);
        let (a, b) = (Factor::left(&x, k), Factor::right(&w, k));
        let mut out = vec![1.0; m * 9];
        product(MatMut::new(&mut out, m, 7, 9), &a, &b, 64, Into::Sum);
        for (out, whole) in out.chunks(9).zip(whole.chunks(n)) {
            assert!(out[..7].iter().zip(&whole[64..]).all(|(o, w)| *o == 1.0 + w));
            assert_eq!(out[7..], [1.0, 1.0], "the gap between rows is left alone");
        }
    }

    #[test]
    fn a_row_does_not_know_which_others_are_multiplied_with_it() {
        let (m, k, n) = (41, 50, 37);
        let (x, w) = (numbers(m * k, 5), numbers(n * k, 6));
        let whole = multiplied(&x, &w, k);
        for (from, to) in [(0, 1), (13, 40), (40, 41)] {
            let part = multiplied(&x[from * k..to * k], &w, k);
            assert_eq!(part, whole[from * n..to * n]);
        }
    }

    #[test]
    fn numbers_are_rounded_to_the_nearest_and_ties_to_even() {
        // 1 + 2⁻⁸ and 1 + 3 · 2⁻⁸ lie midway between neighbours
        assert_eq!(rounded(1.0 + 1.0 / 256.0) >> 16, 0x3f80);
        assert_eq!(rounded(1.0 + 3.0 / 256.0) >> 16, 0x3f82);
        let step = if cfg!(miri) { 9_999_991 } else { 9_973 };
        for bits in (0..=u32::MAX).step_by(step).chain([0x7f7f_ffff, 0x7f80_0000, 0xff80_0001]) {
            let x = f32::from_bits(bits);
            let (found, truth) = (rounded(x) >> 16, half::bf16::from_f32(x));
            assert_eq!(found, u32::from(truth.to_bits()), "{x}");
        }
    }

    #[test]
    fn what_is_no_number_stays_none() {
        let mut x = numbers(3 * 40, 7);
        x[45] = f32::NAN;
        let found = multiplied(&x, &numbers(33 * 40, 8), 40);
        let lost: Vec<_> = found.chunks(33).map(|row| row.iter().all(|y| y.is_nan())).collect();
        assert_eq!(lost, [false, true, false]);
    }
}
