//! Texts to vectors without a download: hashed character n-grams.

use std::fmt;

use object::condition::MAX_TEXT;

use super::FeatureError;

/// Numbers of the embedded encoder.
pub const NGRAM_WIDTH: usize = 256;
/// Lengths of the n-grams, in characters.
const LENGTHS: std::ops::RangeInclusive<usize> = 3..=5;

/// Describes a text by numbers.
///
/// Promise: [`TextFeatures::width`] finite numbers that depend on the text alone.
pub trait TextFeatures: fmt::Debug + Send + Sync {
    /// Name and version; changes whenever results may.
    fn identity(&self) -> String;

    /// Numbers for each text.
    fn width(&self) -> usize;

    /// The vector of a text.
    ///
    /// # Errors
    /// [`FeatureError::TextTooLong`] for more characters than a condition's texts may have; what
    /// else an encoder cannot describe.
    fn embed(&self, text: &str) -> Result<Vec<f32>, FeatureError>;
}

/// Signed hashes of words and of their pieces of three to five letters, so that `drawers` lies near
/// `drawer` and `left door` near `door`. Each number has a mean square of 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NgramText;

impl TextFeatures for NgramText {
    fn identity(&self) -> String {
        "ngram/1".into()
    }

    fn width(&self) -> usize {
        NGRAM_WIDTH
    }

    fn embed(&self, text: &str) -> Result<Vec<f32>, FeatureError> {
        let found = text.chars().count();
        if found > MAX_TEXT {
            return Err(FeatureError::TextTooLong { limit: MAX_TEXT, found });
        }
        let mut out = vec![0.0f32; NGRAM_WIDTH];
        let lower = text.to_lowercase();
        for word in lower.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()) {
            add_word(&mut out, word);
        }
        let square: f32 = out.iter().map(|x| x * x).sum();
        let scale = if square > 0.0 { (NGRAM_WIDTH as f32 / square).sqrt() } else { 0.0 };
        out.iter_mut().for_each(|x| *x *= scale);
        Ok(out)
    }
}

/// A word counts as much as all its pieces together.
fn add_word(out: &mut [f32], word: &str) {
    let letters: Vec<char> = format!("<{word}>").chars().collect();
    let pieces: Vec<&[char]> = LENGTHS.flat_map(|n| letters.windows(n)).collect();
    let share = 1.0 / (pieces.len().max(1) as f32).sqrt();
    pieces.iter().for_each(|piece| add(out, piece, share));
    add(out, &letters, 1.0);
}

fn add(out: &mut [f32], letters: &[char], weight: f32) {
    let step =
        |hash: u64, &c: &char| (hash ^ u64::from(u32::from(c))).wrapping_mul(0x0100_0000_01b3);
    let hash = letters.iter().fold(0xcbf2_9ce4_8422_2325, step);
    let hash = (hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let hash = hash ^ (hash >> 32);
    let sign = if hash & 1 == 0 { 1.0 } else { -1.0 };
    out[(hash >> 1) as usize % NGRAM_WIDTH] += sign * weight;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn likeness(a: &str, b: &str) -> f32 {
        let [a, b] = [a, b].map(|t| NgramText.embed(t).unwrap());
        a.iter().zip(&b).map(|(a, b)| a * b).sum::<f32>() / NGRAM_WIDTH as f32
    }

    #[test]
    fn words_of_one_stem_lie_near_each_other() {
        assert!((likeness("Left Door", "left door") - 1.0).abs() < 1e-5);
        assert!(likeness("drawer", "drawers") > 0.3);
        assert!(likeness("left door", "door") > 0.5);
        assert!(likeness("drawer", "wheel").abs() < 0.25);
        assert!(likeness("left door", "door") > likeness("left door", "lid"));
    }

    #[test]
    fn the_empty_text_is_nothing_and_a_long_one_is_refused() {
        assert!(NgramText.embed(" - ").unwrap().iter().all(|&x| x == 0.0));
        let told = NgramText.embed(&"a".repeat(121)).unwrap_err();
        assert_eq!(told, FeatureError::TextTooLong { limit: 120, found: 121 });
    }
}
