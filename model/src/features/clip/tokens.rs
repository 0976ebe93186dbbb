//! CLIP's tokens: byte-pair encoding over the bytes of words, as OpenAI published it.

use std::collections::BTreeMap;

use regex::Regex;
use unicode_normalization::UnicodeNormalization;

/// What opens and what ends every text.
const START: &str = "<|startoftext|>";
const END: &str = "<|endoftext|>";
/// Marks a symbol that ends a word.
const WORD_END: &str = "</w>";
/// OpenAI's pattern of what is a word. Nothing in it matches white space, so that runs of it, at
/// the ends or between words, make no difference.
const WORDS: &str =
    r"<\|startoftext\|>|<\|endoftext\|>|'s|'t|'re|'ve|'m|'ll|'d|\p{L}+|\p{N}|[^\s\p{L}\p{N}]+";

/// A merge: its rank, the first to be applied has the lowest, and the symbol it makes.
type Merge = (u32, u32);

/// The tokenizer of a checkpoint.
#[derive(Debug)]
pub(super) struct Tokens {
    words: Regex,
    /// Symbol of each byte inside a word, and at the end of one.
    bytes: [[u32; 256]; 2],
    merges: BTreeMap<(u32, u32), Merge>,
    start: u32,
    end: u32,
}

/// What is wrong with one of the two files.
#[derive(Debug)]
pub(super) enum Unsound {
    Vocabulary(String),
    Merges(String),
}

impl Tokens {
    /// Reads `vocab.json` and `merges.txt` and proves that every text has tokens, all below `size`.
    pub(super) fn parse(vocabulary: &[u8], merges: &[u8], size: usize) -> Result<Self, Unsound> {
        let vocabulary = Vocabulary::parse(vocabulary, size).map_err(Unsound::Vocabulary)?;
        let end_of = |symbol: char, end: &str| vocabulary.id(&format!("{symbol}{end}"));
        let all = |end| letters().map(|symbol| end_of(symbol, end)).collect::<Result<Vec<_>, _>>();
        let table = |end| {
            let ids = all(end).map_err(Unsound::Vocabulary)?;
            let found = ids.len();
            let rule = |_| Unsound::Vocabulary(format!("expected 256 bytes, found {found}"));
            <[u32; 256]>::try_from(ids).map_err(rule)
        };
        let words = Regex::new(WORDS).map_err(|e| Unsound::Vocabulary(e.to_string()))?;
        let special = |name| vocabulary.id(name).map_err(Unsound::Vocabulary);
        Ok(Self {
            words,
            bytes: [table("")?, table(WORD_END)?],
            merges: vocabulary.merges(merges).map_err(Unsound::Merges)?,
            start: special(START)?,
            end: special(END)?,
        })
    }

    /// The token that ends every text.
    pub(super) fn end(&self) -> u32 {
        self.end
    }

    /// The tokens of a text between its start and its end. Texts are composed (NFC) and lower-cased
    /// letter by letter; neither mojibake nor HTML is repaired.
    pub(super) fn encode(&self, text: &str) -> Vec<u32> {
        let lower: String = text.nfc().flat_map(char::to_lowercase).collect();
        let mut ids = vec![self.start];
        for word in self.words.find_iter(&lower) {
            match word.as_str() {
                START => ids.push(self.start),
                END => ids.push(self.end),
                word => ids.extend(self.word(word)),
            }
        }
        ids.push(self.end);
        ids
    }

    /// Merges the bytes of a word, always the pair of the lowest rank and every one of it.
    fn word(&self, word: &str) -> Vec<u32> {
        let last = word.len().saturating_sub(1);
        let symbol = |(i, byte): (usize, u8)| self.bytes[usize::from(i == last)][usize::from(byte)];
        let mut symbols: Vec<u32> = word.bytes().enumerate().map(symbol).collect();
        while let Some((pair, made)) = self.first_merge(&symbols) {
            symbols = merged(&symbols, pair, made);
        }
        symbols
    }

    /// The pair of the lowest rank, and what it makes.
    fn first_merge(&self, symbols: &[u32]) -> Option<((u32, u32), u32)> {
        let pairs = symbols.windows(2).filter_map(|pair| {
            let pair = (pair[0], pair[1]);
            self.merges.get(&pair).map(|&(rank, made)| (rank, pair, made))
        });
        pairs.min().map(|(_, pair, made)| (pair, made))
    }

    /// Feeds everything that decides about tokens to a hasher.
    pub(super) fn hash(&self, hasher: &mut blake3::Hasher) {
        let mut feed = |ids: &[u32]| {
            for id in ids {
                hasher.update(&id.to_le_bytes());
            }
        };
        feed(&[self.start, self.end]);
        self.bytes.iter().for_each(|ids| feed(ids));
        self.merges.iter().for_each(|(&(a, b), &(rank, made))| feed(&[a, b, rank, made]));
    }
}

fn merged(symbols: &[u32], (a, b): (u32, u32), made: u32) -> Vec<u32> {
    let mut out = Vec::with_capacity(symbols.len());
    let mut rest = symbols;
    while let [first, tail @ ..] = rest {
        let pair = *first == a && tail.first() == Some(&b);
        out.push(if pair { made } else { *first });
        rest = if pair { &tail[1..] } else { tail };
    }
    out
}

/// The letter that stands for each byte in the files: itself where it can be printed, else one from
/// U+0100 on.
fn letters() -> impl Iterator<Item = char> {
    let mut next = 0x100u32;
    (0..=255u8).map(move |byte| match byte {
        b'!'..=b'~' | 0xa1..=0xac | 0xae..=0xff => char::from(byte),
        _ => {
            next += 1;
            char::from_u32(next - 1).unwrap_or(char::REPLACEMENT_CHARACTER)
        }
    })
}

/// Symbols and their numbers.
struct Vocabulary(BTreeMap<String, u32>);

impl Vocabulary {
    fn parse(bytes: &[u8], size: usize) -> Result<Self, String> {
        let ids: BTreeMap<String, u32> = serde_json::from_slice(bytes)
            .map_err(|e| format!("expected an object of symbols and their numbers: {e}"))?;
        match ids.iter().find(|(_, id)| **id as usize >= size) {
            Some((symbol, id)) => {
                Err(format!("numbers lie below `vocab_size` ({size}), `{symbol}` has {id}"))
            }
            None => Ok(Self(ids)),
        }
    }

    fn id(&self, symbol: &str) -> Result<u32, String> {
        let rule = || format!("every byte, merge and special symbol has a number, `{symbol}` none");
        self.0.get(symbol).copied().ok_or_else(rule)
    }

    /// A line is two symbols with a space between them, after a line that says the version.
    fn merges(&self, bytes: &[u8]) -> Result<BTreeMap<(u32, u32), Merge>, String> {
        let text = std::str::from_utf8(bytes).map_err(|e| format!("expected UTF-8: {e}"))?;
        let mut merges = BTreeMap::new();
        let lines =
            text.lines().enumerate().skip_while(|(i, l)| *i == 0 && l.starts_with("#version"));
        for (number, line) in lines.filter(|(_, line)| !line.is_empty()) {
            let told = |rule: String| format!("line {}: {rule}", number + 1);
            let pair = line.split_once(' ').filter(|(_, b)| !b.contains(' '));
            let (a, b) =
                pair.ok_or_else(|| told(format!("expected two symbols, found `{line}`")))?;
            let made = self.id(&format!("{a}{b}")).map_err(told)?;
            let pair = (self.id(a).map_err(told)?, self.id(b).map_err(told)?);
            merges.insert(pair, (number as u32, made));
        }
        Ok(merges)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes, bytes at the end of a word, merges and specials, numbered in this order.
    fn tokens(merges: &[&str]) -> Tokens {
        let mut names: Vec<String> = letters().map(String::from).collect();
        names.extend(letters().map(|l| format!("{l}{WORD_END}")));
        names.extend(merges.iter().map(|m| m.replace(' ', "")));
        names.extend([START, END].map(String::from));
        let ids: BTreeMap<_, _> = names.iter().zip(0u32..).collect();
        let text = format!("#version: 0.2\n{}\n", merges.join("\n"));
        Tokens::parse(&serde_json::to_vec(&ids).unwrap(), text.as_bytes(), names.len()).unwrap()
    }

    #[test]
    fn the_merge_that_was_learned_first_comes_first() {
        let tokens = tokens(&["o r</w>", "d o", "o o", "do or</w>"]);
        let [start, end] = [516u32, 517];
        // d o o r: `or` first, then `do`, then both
        assert_eq!(tokens.encode("  DOOR\n"), [start, 515, end]);
        assert_eq!(tokens.encode("door"), tokens.encode("Door"));
        // every one of a pair is merged, from the left
        assert_eq!(tokens.word("ooo"), [514, u32::from(b'o') + 256]);
    }

    #[test]
    fn a_text_of_nothing_is_its_two_ends() {
        assert_eq!(tokens(&[]).encode(" \t "), [512, 513]);
    }

    #[test]
    fn every_character_has_tokens() {
        let tokens = tokens(&[]);
        let all = (0..=char::MAX as u32).step_by(61).filter_map(char::from_u32);
        for text in all.map(String::from) {
            let ids = tokens.encode(&text);
            assert!(text.trim().is_empty() || ids.len() > 2, "{text:?}");
            assert!(ids.iter().all(|&id| id < 514));
        }
    }
}
