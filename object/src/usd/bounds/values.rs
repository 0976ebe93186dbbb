//! What a layer's values take once they are read, and that none holds itself.

use super::bytes::Bytes;
use super::most::{MOST_BYTES, Refusal, STRING, length_of};

/// Dictionaries in dictionaries: a guess well above what programs write, and far below what the stack holds.
const MOST_NESTED: usize = 32;
/// Values that may be met, those in dictionaries and time samples with them, for each byte of the layer.
/// Sound layers share a few values between places; a guess with room.
const MOST_MET: usize = 4;

const IS_ARRAY: u64 = 1 << 63;
const IS_INLINED: u64 = 1 << 62;
const IS_COMPRESSED: u64 = 1 << 61;
const PLACE: u64 = (1 << 48) - 1;

/// What the numbers of a list stand for.
#[derive(Clone, Copy)]
enum Named {
    Token,
    Text,
    Path,
}

/// The values of one layer.
pub(super) struct Values<'a> {
    layer: &'a [u8],
    version: u8,
    /// Lengths of tokens, strings and paths.
    lengths: [&'a [usize]; 3],
    /// Values that may yet be met.
    left: usize,
}

impl<'a> Values<'a> {
    pub(super) fn new(layer: &'a [u8], version: u8, lengths: [&'a [usize]; 3]) -> Self {
        let left = layer.len().saturating_mul(MOST_MET);
        Self { layer, version, lengths, left }
    }

    /// Bytes that a value takes once it is read.
    pub(super) fn weight(&mut self, rep: u64) -> Result<usize, Refusal> {
        self.value(rep, 0)
    }

    fn value(&mut self, rep: u64, nested: usize) -> Result<usize, Refusal> {
        if nested > MOST_NESTED {
            return Err(format!("its values may lie {MOST_NESTED} deep in each other, found more"));
        }
        self.left = self.left.checked_sub(1).ok_or("its values refer to each other without end")?;
        let is_array = rep & IS_ARRAY != 0;
        let is_inlined = rep & IS_INLINED != 0;
        let place = (rep & PLACE) as usize;
        let mut at = Bytes::at(self.layer, place);
        // Numbers of the types: the specification's table of value types.
        let kind = (rep >> 48 & 0xff) as u8;
        match kind {
            10 | 12 | 57 if is_array => self.named(&mut at, Named::Text),
            11 if is_array => {
                let Some(count) = self.length(&mut at, place)? else { return Ok(0) };
                let count = at.fits(count, 4)?;
                self.names(&mut at, count, Named::Token)
            }
            1..=30 | 56 if is_array => self.array(at, place, rep),
            48 => self.array(at, place, rep),
            31 if is_inlined => Ok(0),
            31 => self.dictionary(&mut at, nested + 1),
            32 => self.list_op(at, |own, at| own.named(at, Named::Token)),
            33 | 54 => self.list_op(at, |own, at| own.named(at, Named::Text)),
            34 => self.list_op(at, |own, at| own.named(at, Named::Path)),
            36 | 38 => self.list_op(at, |_, at| plain(at, 4)),
            37 | 39 => self.list_op(at, |_, at| plain(at, 8)),
            35 => self.list_op(at, |own, at| own.arcs(at, true, nested)),
            55 => self.list_op(at, |own, at| own.arcs(at, false, nested)),
            40 => self.named(&mut at, Named::Path),
            41 => self.named(&mut at, Named::Token),
            50 => self.named(&mut at, Named::Text),
            45 | 58 => {
                let mut copy = at;
                copy.count(8)?;
                let pairs = at.u64()?.saturating_mul(2) as usize;
                let what = if kind == 45 { Named::Text } else { Named::Path };
                self.names(&mut at, pairs, what)
            }
            46 => self.samples(at, nested + 1),
            49 => plain(&mut at, 16),
            _ => Ok(STRING),
        }
    }

    /// An array's length; none where it is empty and stands nowhere.
    fn length(&self, at: &mut Bytes<'_>, place: usize) -> Result<Option<u64>, Refusal> {
        if place == 0 {
            return Ok(None);
        }
        if self.version < 5 {
            at.u32()?;
        }
        Ok(Some(if self.version < 7 { u64::from(at.u32()?) } else { at.u64()? }))
    }

    fn array(&self, mut at: Bytes<'_>, place: usize, rep: u64) -> Result<usize, Refusal> {
        let kind = (rep >> 48 & 0xff) as u8;
        let Some(count) = self.length(&mut at, place)? else { return Ok(0) };
        let since = match kind {
            3..=6 => Some(5),
            7..=9 | 48 | 56 => Some(6),
            _ => None,
        };
        let size = size(kind);
        let is_packed = rep & IS_COMPRESSED != 0 && since.is_some_and(|v| self.version >= v);
        // The shortest are never packed; where a writer thinks otherwise, the reader does not follow it.
        let count = if !is_packed || count < 4 {
            at.fits(count, size)?
        } else if since == Some(5) {
            at.pass_ints(count)?
        } else {
            match at.u8()? {
                b'i' => at.pass_ints(count)?,
                b't' => {
                    let table = at.u32()?;
                    let table = at.fits(u64::from(table), size)?;
                    at.take(table * size)?;
                    at.pass_ints(count)?
                }
                other => {
                    return Err(format!(
                        "numbers must be packed as `i` or `t`, found byte {other}"
                    ));
                }
            }
        };
        // Packed numbers are unpacked before they are widened.
        Ok(count.saturating_mul(size + if is_packed { 8 } else { 0 }))
    }

    /// A list of numbers that stand for texts, its length before it.
    fn named(&self, at: &mut Bytes<'_>, what: Named) -> Result<usize, Refusal> {
        let count = at.count(4)?;
        self.names(at, count, what)
    }

    fn names(&self, at: &mut Bytes<'_>, count: usize, what: Named) -> Result<usize, Refusal> {
        let lengths = self.lengths[what as usize];
        let mut taken = 0_usize;
        for number in at.words(count)? {
            taken = taken.saturating_add(length_of(lengths, number) + STRING);
        }
        Ok(taken)
    }

    /// Up to six lists, as the first byte says.
    fn list_op(
        &mut self,
        mut at: Bytes<'_>,
        mut list: impl FnMut(&mut Self, &mut Bytes<'_>) -> Result<usize, Refusal>,
    ) -> Result<usize, Refusal> {
        let lists = at.u8()?;
        let mut taken = 0_usize;
        for bit in 1..=6 {
            if lists >> bit & 1 == 1 {
                taken = taken.saturating_add(list(self, &mut at)?);
            }
        }
        Ok(taken)
    }

    /// References, which carry a dictionary each, or payloads.
    fn arcs(
        &mut self,
        at: &mut Bytes<'_>,
        is_reference: bool,
        nested: usize,
    ) -> Result<usize, Refusal> {
        let offset = if is_reference || self.version >= 8 { 16 } else { 0 };
        let count = at.count(8 + offset)?;
        let mut taken = 0_usize;
        for _ in 0..count {
            let [text, path] = [at.u32()?, at.u32()?];
            at.take(offset)?;
            let own = length_of(self.lengths[1], text) + length_of(self.lengths[2], path);
            taken = taken.saturating_add(own + 8 * STRING);
            if is_reference {
                taken = taken.saturating_add(self.dictionary(at, nested + 1)?);
            }
            if taken > MOST_BYTES {
                break;
            }
        }
        Ok(taken)
    }

    /// Keys and values; each value lies where an offset says, and the next key behind it.
    fn dictionary(&mut self, at: &mut Bytes<'_>, nested: usize) -> Result<usize, Refusal> {
        let count = at.count(12)?;
        let mut taken = 0_usize;
        for _ in 0..count {
            let key = at.u32()?;
            at.leap()?;
            let rep = at.u64()?;
            let own = length_of(self.lengths[1], key) + 4 * STRING;
            taken = taken.saturating_add(own).saturating_add(self.value(rep, nested)?);
        }
        Ok(taken)
    }

    /// Times, then a value for each.
    fn samples(&mut self, mut at: Bytes<'_>, nested: usize) -> Result<usize, Refusal> {
        at.leap()?;
        let times = at.u64()?;
        let mut taken = self.value(times, nested)?;
        at.leap()?;
        for _ in 0..at.count(8)? {
            let rep = at.u64()?;
            taken = taken.saturating_add(self.value(rep, nested)?).saturating_add(STRING);
        }
        Ok(taken)
    }
}

/// A list of plain elements, its length before it.
fn plain(at: &mut Bytes<'_>, size: usize) -> Result<usize, Refusal> {
    let count = at.count(size)?;
    at.take(count * size)?;
    Ok(count * size)
}

/// Bytes of an element of each type that stands in arrays.
fn size(kind: u8) -> usize {
    match kind {
        1 | 2 => 1,
        7 => 2,
        3 | 4 | 8 | 21 => 4,
        25 => 6,
        5 | 6 | 9 | 18 | 20 | 22 | 29 | 48 | 56 => 8,
        24 | 26 => 12,
        17 | 19 | 28 | 30 => 16,
        23 => 24,
        13 | 16 | 27 => 32,
        14 => 72,
        _ => 128,
    }
}
