//! Whether a binary layer's counts fit its bytes, before the library that reads it is asked.
//!
//! A crate file (USD Core Specification 1.0.1, 16.3) says how long each of its lists is, how its paths branch
//! and where its values lie. The library takes all of it at its word. So each is followed here first: no list
//! is longer than the bytes it stands in can hold, no path has two parents, no value holds itself, and what
//! all of them take once they are read stays below a bound.

mod bytes;
mod most;
mod values;

use bytes::Bytes;
use most::{MOST_BYTES, Refusal, STRING, length_of};
use values::Values;

/// Levels of prims above each other: what a stage is walked to.
const MOST_DEEP: usize = 256;
/// Sections a table of contents may name; the format knows six.
const MOST_SECTIONS: usize = 64;
/// The end of a list of fields.
const NO_FIELD: u32 = u32::MAX;

/// Refuses a layer whose lists cannot be what they say.
///
/// # Errors
/// The rule that is broken and what was found.
pub(super) fn bounded(layer: &[u8]) -> Result<(), Refusal> {
    let version = version(layer)?;
    let sections = sections(layer)?;
    let section = |name: &str| -> Option<Bytes<'_>> {
        let (_, start) =
            sections.iter().find(|(called, _)| called.as_slice() == name.as_bytes())?;
        Some(Bytes::at(layer, *start))
    };
    let tokens = section("TOKENS").map_or(Ok(Vec::new()), tokens)?;
    let strings = match section("STRINGS") {
        Some(mut at) => {
            let count = at.count(4)?;
            at.words(count)?.into_iter().map(|s| length_of(&tokens, s)).collect()
        }
        None => Vec::new(),
    };
    let fields = section("FIELDS").map_or(Ok(Vec::new()), fields)?;
    let sets = match section("FIELDSETS") {
        Some(mut at) => {
            let count = at.u64()?;
            at.ints(count)?
        }
        None => Vec::new(),
    };
    let paths = section("PATHS").map_or(Ok(Vec::new()), |at| paths(at, &tokens))?;
    let mut taken = Taken::default();
    for length in tokens.iter().chain(&paths) {
        taken.add(length + STRING)?;
    }
    let mut values = Values::new(layer, version, [&tokens, &strings, &paths]);
    let weights =
        fields.into_iter().map(|rep| values.weight(rep)).collect::<Result<Vec<_>, _>>()?;
    let Some(mut at) = section("SPECS") else { return Ok(()) };
    let count = at.u64()?;
    let [_, firsts, _] = [at.ints(count)?, at.ints(count)?, at.ints(count)?];
    for first in firsts {
        let set = sets.get(first as usize..).unwrap_or_default();
        for &field in set.iter().take_while(|f| **f != NO_FIELD) {
            // A number beyond the fields is found by the reader.
            taken.add(STRING + weights.get(field as usize).copied().unwrap_or(0))?;
        }
    }
    Ok(())
}

/// What has been counted so far, bytes.
#[derive(Default)]
struct Taken(usize);

impl Taken {
    fn add(&mut self, bytes: usize) -> Result<(), Refusal> {
        self.0 = self.0.saturating_add(bytes);
        if self.0 > MOST_BYTES {
            return Err(format!("it may take at most {MOST_BYTES} bytes once read, found more"));
        }
        Ok(())
    }
}

/// Minor version of the format; only those with compressed sections are read.
fn version(layer: &[u8]) -> Result<u8, Refusal> {
    let mut at = Bytes::at(layer, 0);
    if at.take(8)? != b"PXR-USDC" {
        return Err("it must begin with #usda or PXR-USDC, found neither".into());
    }
    let version = at.take(8)?;
    if version[0] != 0 || version[1] < 4 {
        let [major, minor, patch] = [version[0], version[1], version[2]];
        return Err(format!("its format must be 0.4 or later, found {major}.{minor}.{patch}"));
    }
    Ok(version[1])
}

/// Names and places of the sections.
fn sections(layer: &[u8]) -> Result<Vec<(Vec<u8>, usize)>, Refusal> {
    let table = Bytes::at(layer, 16).u64()?;
    let mut at = Bytes::at(layer, usize::try_from(table).unwrap_or(usize::MAX));
    let count = at.count(32)?;
    if count >= MOST_SECTIONS {
        return Err(format!("it may have fewer than {MOST_SECTIONS} sections, found {count}"));
    }
    let mut sections = Vec::with_capacity(count);
    for _ in 0..count {
        let name = at.take(16)?.split(|b| *b == 0).next().unwrap_or_default().to_vec();
        let (start, _size) = (at.u64()?, at.u64()?);
        sections.push((name, usize::try_from(start).unwrap_or(usize::MAX)));
    }
    Ok(sections)
}

/// Length of each token, bytes.
fn tokens(mut at: Bytes<'_>) -> Result<Vec<usize>, Refusal> {
    let _count = at.u64()?;
    let unpacked = at.u64()?;
    let text = at.unpacked(unpacked)?;
    Ok(text.split(|b| *b == 0).map(<[u8]>::len).collect())
}

/// Each field's value, as the format packs it.
fn fields(mut at: Bytes<'_>) -> Result<Vec<u64>, Refusal> {
    let count = at.u64()?;
    at.ints(count)?;
    let bytes = at.unpacked(count.saturating_mul(8))?;
    Ok(bytes
        .chunks_exact(8)
        .map(|b| b.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b)))
        .collect())
}

/// Length of each path, bytes. Every entry of the tree is some other's child or next sibling, once.
fn paths(mut at: Bytes<'_>, tokens: &[usize]) -> Result<Vec<usize>, Refusal> {
    let most = at.u64()?;
    let count = at.u64()?;
    let [numbers, names, jumps] = [at.ints(count)?, at.ints(count)?, at.ints(count)?];
    let most =
        usize::try_from(most).ok().filter(|most| *most <= numbers.len()).ok_or_else(|| {
            format!("it must have no more paths than entries of their tree ({count}), found {most}")
        })?;
    let (mut lengths, mut is_met) = (vec![0; most], vec![false; numbers.len()]);
    let mut taken = Taken::default();
    let mut pending = if is_met.is_empty() { Vec::new() } else { vec![(0, 0, 0)] };
    while let Some((entry, above, depth)) = pending.pop() {
        match is_met.get_mut(entry) {
            Some(met) if !*met => *met = true,
            _ => {
                return Err(format!(
                    "its tree of paths must reach each once, entry {entry} is not"
                ));
            }
        }
        if depth > MOST_DEEP {
            return Err(format!("its prims may lie at most {MOST_DEEP} deep, found more"));
        }
        let name = length_of(tokens, (names[entry] as i32).unsigned_abs());
        let length = above + 1 + name;
        taken.add(length + STRING)?;
        if let Some(place) = lengths.get_mut(numbers[entry] as usize) {
            *place = length;
        }
        let jump = jumps[entry] as i32;
        let has_child = jump > 0 || jump == -1;
        if jump >= 0 {
            let to = if has_child { entry.saturating_add(jump as usize) } else { entry + 1 };
            pending.push((to, above, depth));
        }
        if has_child {
            pending.push((entry + 1, length, depth + 1));
        }
    }
    Ok(lengths)
}

#[cfg(test)]
mod tests;
