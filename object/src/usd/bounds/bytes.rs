//! A place in a layer's bytes: numbers, lists and packed blocks from there on.

use super::most::{MOST_BYTES, Refusal};

/// An LZ4 block is at most so many times its own size once unpacked, and a little (LZ4 block format).
const LZ4: usize = 255;

/// Bytes from a place on.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a> {
    whole: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// From byte `at` of `whole`, which may lie beyond its end: then nothing can be read.
    pub(super) fn at(whole: &'a [u8], at: usize) -> Self {
        Self { whole, at }
    }

    fn rest(&self) -> &'a [u8] {
        self.whole.get(self.at..).unwrap_or_default()
    }

    /// The next `count` bytes.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], Refusal> {
        let (at, left) = (self.at, self.rest().len());
        let taken = self
            .rest()
            .get(..count)
            .ok_or_else(|| format!("byte {at} must be followed by {count} bytes, found {left}"))?;
        self.at += count;
        Ok(taken)
    }

    fn little<const N: usize>(&mut self) -> Result<[u8; N], Refusal> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        Ok(bytes)
    }

    pub(super) fn u8(&mut self) -> Result<u8, Refusal> {
        Ok(u8::from_le_bytes(self.little()?))
    }

    pub(super) fn u32(&mut self) -> Result<u32, Refusal> {
        Ok(u32::from_le_bytes(self.little()?))
    }

    pub(super) fn u64(&mut self) -> Result<u64, Refusal> {
        Ok(u64::from_le_bytes(self.little()?))
    }

    /// Goes where the next number says: it counts from its own place.
    pub(super) fn leap(&mut self) -> Result<(), Refusal> {
        let from = self.at;
        let offset = i64::from_le_bytes(self.little()?);
        let to = i64::try_from(from).ok().and_then(|from| from.checked_add(offset));
        self.at = to.and_then(|to| usize::try_from(to).ok()).ok_or_else(|| {
            format!("byte {from} must point into the file, found an offset of {offset}")
        })?;
        Ok(())
    }

    /// A list's length, if its elements of `size` bytes can stand behind it.
    pub(super) fn count(&mut self, size: usize) -> Result<usize, Refusal> {
        let count = self.u64()?;
        self.fits(count, size)
    }

    /// `count` elements of `size` bytes, if they can stand here.
    pub(super) fn fits(&self, count: u64, size: usize) -> Result<usize, Refusal> {
        let (at, left) = (self.at, self.rest().len());
        let count_here = usize::try_from(count).ok();
        count_here.filter(|n| n.checked_mul(size).is_some_and(|b| b <= left)).ok_or_else(|| {
            format!("byte {at} must be followed by {count} times {size} bytes, found {left}")
        })
    }

    /// The next `count` numbers of four bytes.
    pub(super) fn words(&mut self, count: usize) -> Result<Vec<u32>, Refusal> {
        let bytes = self.take(count.saturating_mul(4))?;
        let word = |b: &[u8]| b.iter().rev().fold(0, |n, b| n << 8 | u32::from(*b));
        Ok(bytes.chunks_exact(4).map(word).collect())
    }

    /// A packed block, its own size before it, of at most `most` bytes once unpacked.
    pub(super) fn unpacked(&mut self, most: u64) -> Result<Vec<u8>, Refusal> {
        let (block, most) = self.block(most)?;
        let mut bytes = vec![0; most.min(block.len().saturating_mul(LZ4))];
        let found = lz4_flex::block::decompress_into(block, &mut bytes);
        let found = found.map_err(|e| format!("a packed block does not unpack: {e}"))?;
        bytes.truncate(found);
        Ok(bytes)
    }

    /// A packed block and what it may unpack to: the reader makes room for as much.
    fn block(&mut self, most: u64) -> Result<(&'a [u8], usize), Refusal> {
        let at = self.at;
        let size = self.count(1)?;
        let pieces = self.u8()?;
        let block = self.take(size.checked_sub(1).ok_or("a packed block must not be empty")?)?;
        if pieces != 0 {
            return Err(format!(
                "a block must be packed in one piece, found {pieces} at byte {at}"
            ));
        }
        let fit = usize::try_from(most).ok().filter(|most| *most <= MOST_BYTES / 4);
        let fit = fit.ok_or_else(|| {
            format!("a block may unpack to {} bytes, found {most} at byte {at}", MOST_BYTES / 4)
        })?;
        Ok((block, fit))
    }

    /// Passes `count` packed whole numbers; they may be that many if two bits are there for each.
    pub(super) fn pass_ints(&mut self, count: u64) -> Result<usize, Refusal> {
        let at = self.at;
        let (block, _) =
            self.block(count.saturating_mul(4).saturating_add(count / 4).saturating_add(5))?;
        let most = block.len().saturating_mul(LZ4).saturating_mul(4);
        usize::try_from(count).ok().filter(|count| *count <= most).ok_or_else(|| {
            format!(
                "{} packed bytes hold at most {most} numbers, found {count} at byte {at}",
                block.len()
            )
        })
    }

    /// `count` packed whole numbers of four bytes, as the format packs them: the commonest difference, two bits
    /// for each difference's width, and the differences that are not the commonest.
    pub(super) fn ints(&mut self, count: u64) -> Result<Vec<u32>, Refusal> {
        let at = self.at;
        let mut copy = *self;
        let count = copy.pass_ints(count)?;
        let bytes = self.unpacked((4 + count.div_ceil(4) + 4 * count) as u64)?;
        if count == 0 {
            return Ok(Vec::new());
        }
        let short = || format!("{count} packed numbers at byte {at} break off");
        let common = bytes.first_chunk().map(|b| i32::from_le_bytes(*b)).ok_or_else(short)?;
        let widths = bytes.get(4..4 + count.div_ceil(4)).ok_or_else(short)?;
        let mut rest = &bytes[4 + widths.len()..];
        let (mut last, mut numbers) = (0_i32, Vec::with_capacity(count));
        for number in 0..count {
            let width = widths[number / 4] >> (2 * (number % 4)) & 3;
            let step = match width {
                0 => common,
                1 => i32::from(i8::from_le_bytes(*split(&mut rest).ok_or_else(short)?)),
                2 => i32::from(i16::from_le_bytes(*split(&mut rest).ok_or_else(short)?)),
                _ => i32::from_le_bytes(*split(&mut rest).ok_or_else(short)?),
            };
            last = last.wrapping_add(step);
            numbers.push(last as u32);
        }
        Ok(numbers)
    }
}

fn split<'a, const N: usize>(rest: &mut &'a [u8]) -> Option<&'a [u8; N]> {
    let (first, others) = rest.split_first_chunk()?;
    *rest = others;
    Some(first)
}
