//! How much a layer may say, and how it is said that it says more.

/// What everything a layer says may take once it is read, bytes: over twice the largest mesh that is taken,
/// with normals and texture coordinates.
pub(super) const MOST_BYTES: usize = 2 << 30;
/// What a list's element takes beside its own bytes: a string's three words.
pub(super) const STRING: usize = 24;

/// What is wrong with a layer, in a sentence's second half.
pub(super) type Refusal = String;

/// A number beyond the list is found by the reader.
pub(super) fn length_of(lengths: &[usize], number: u32) -> usize {
    lengths.get(number as usize).copied().unwrap_or(0)
}
