//! Tiles of bf16 numbers, blocks of their products, and whoever multiplies them.

/// Rows of a tile, numbers of a row of f32, pairs of a row of bf16.
pub(crate) const SIDE: usize = 16;

/// Rows and columns of a [`Block`].
pub(crate) const BLOCK: usize = 2 * SIDE;

/// Sixteen rows of sixteen pairs of bf16; the first of a pair lies in the low bits.
///
/// Of a left factor, row m holds row m of the matrix, 32 columns of it. Of a right factor, row k
/// holds the matrix' rows 2 k and 2 k + 1, a pair for each of 16 columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(64))]
pub(crate) struct Tile(pub(crate) [[u32; SIDE]; SIDE]);

/// Sixteen rows of sixteen sums.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Sums(pub(crate) [[f32; SIDE]; SIDE]);

/// Two by two tiles of a product, row by row.
pub(crate) type Block = [Sums; 4];

/// Nothing summed yet.
pub(crate) const NOTHING: Block = [Sums([[0.0; SIDE]; SIDE]); 4];

/// Something that multiplies tiles.
pub(crate) trait Tiles {
    /// `sums[2 i + j] = Σ a[i][t] · b[j][t]`, added in the order of t, each term as the instruction
    /// TDPBF16PS gives it. All four factors have as many tiles.
    fn multiply(&mut self, a: [&[Tile]; 2], b: [&[Tile]; 2], sums: &mut Block);
}
