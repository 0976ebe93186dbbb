//! Products of tiles of bf16 numbers, as the processor's tile unit (AMX) makes them, and the same
//! in plain Rust, bit for bit, where there is no such unit.

use super::simd::{Work, vectorised};
pub(crate) use block::{BLOCK, Block, NOTHING, SIDE, Sums, Tile, Tiles};

#[cfg(all(target_arch = "x86_64", target_os = "linux", not(miri)))]
mod amx;
mod block;
#[cfg(test)]
mod tests;

/// Whether the processor multiplies tiles, and the system lets us.
pub(crate) fn at_hand() -> bool {
    #[cfg(all(target_arch = "x86_64", target_os = "linux", not(miri)))]
    return amx::permitted();
    #[cfg(not(all(target_arch = "x86_64", target_os = "linux", not(miri))))]
    false
}

/// Does work with the processor's tiles, or with [`Plain`] ones where it has none.
pub(crate) fn with_tiles(work: impl FnOnce(&mut dyn Tiles)) {
    #[cfg(all(target_arch = "x86_64", target_os = "linux", not(miri)))]
    if let Some(mut tiles) = amx::Amx::new() {
        return work(&mut tiles);
    }
    work(&mut Plain);
}

/// What the manual says of TDPBF16PS, in plain Rust (Intel 64 and IA-32 Architectures Software
/// Developer's Manual, volume 2).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain;

impl Tiles for Plain {
    fn multiply(&mut self, a: [&[Tile]; 2], b: [&[Tile]; 2], sums: &mut Block) {
        for (of, sums) in sums.iter_mut().enumerate() {
            *sums = NOTHING[0];
            vectorised(Column { a: a[of / 2], b: b[of % 2], sums });
        }
    }
}

/// One tile of sums.
struct Column<'a> {
    a: &'a [Tile],
    b: &'a [Tile],
    sums: &'a mut Sums,
}

impl Work for Column<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (a, b) in self.a.iter().zip(self.b) {
            for (a, sums) in a.0.iter().zip(&mut self.sums.0) {
                add_pairs(sums, a, b);
            }
        }
    }
}

/// One row of TDPBF16PS: the first numbers of the pairs and the second ones are summed apart, by
/// fused multiply-adds, and their sums then added to what is there.
#[inline(always)]
fn add_pairs(sums: &mut [f32; SIDE], a: &[u32; SIDE], b: &Tile) {
    let [mut firsts, mut seconds] = [[0f32; SIDE]; 2];
    for (&a, b) in a.iter().zip(&b.0) {
        let [a0, a1] = [first(a), second(a)];
        for n in 0..SIDE {
            firsts[n] = flushed(a0.mul_add(first(b[n]), firsts[n]));
            seconds[n] = flushed(a1.mul_add(second(b[n]), seconds[n]));
        }
    }
    for n in 0..SIDE {
        sums[n] = flushed(sums[n] + flushed(firsts[n] + seconds[n]));
    }
}

#[inline(always)]
fn first(pair: u32) -> f32 {
    flushed(f32::from_bits(pair << 16))
}

#[inline(always)]
fn second(pair: u32) -> f32 {
    flushed(f32::from_bits(pair & 0xffff_0000))
}

/// Zero, with its sign, for what is too small to be normal.
#[inline(always)]
fn flushed(x: f32) -> f32 {
    let kept = if x.abs() < f32::MIN_POSITIVE { 1 << 31 } else { u32::MAX };
    f32::from_bits(x.to_bits() & kept)
}
