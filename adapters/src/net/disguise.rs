//! How a text may be written so that it still can be read: escapes, white space between, base64.

use std::borrow::Cow;
use std::ops::Range;

/// Shortest run of base64 letters that is decoded: shorter ones hold no twelve characters.
const SHORTEST_RUN: usize = 11;
/// Shortest run of hexadecimal digits and of base32 letters that is decoded: twelve characters of a key
/// in one more form.
const SHORTEST_HEX: usize = 32;
const SHORTEST_BASE32: usize = 26;
/// Longest run of base64 letters that is decoded. Pictures and meshes are longer, and what stands
/// in them in base64 alone is found without.
const LONGEST_RUN: usize = 1 << 16;

/// A text as it reads once something was decoded, with the place in the original of every byte.
#[derive(Clone)]
pub(super) struct View<'a> {
    /// What it reads.
    pub bytes: Cow<'a, [u8]>,
    /// Where each byte begins and ends in the original; none for the original.
    at: Option<Vec<(u32, u32)>>,
}

impl<'a> View<'a> {
    /// The original.
    pub(super) fn of(bytes: &'a [u8]) -> Self {
        Self { bytes: Cow::Borrowed(bytes), at: None }
    }

    /// What some bytes of this view are in the original.
    pub(super) fn origin(&self, range: Range<usize>) -> Range<usize> {
        match range.end.checked_sub(1) {
            Some(last) if range.start <= last => {
                self.place(range.start).0 as usize..self.place(last).1 as usize
            }
            _ => 0..0,
        }
    }

    /// Where a byte begins and ends in the original.
    fn place(&self, index: usize) -> (u32, u32) {
        let own = || u32::try_from(index).unwrap_or(u32::MAX);
        match &self.at {
            Some(at) => at.get(index).copied().unwrap_or_default(),
            None => (own(), own().saturating_add(1)),
        }
    }

    /// The view with its escapes decoded once: JSON and other backslashes, percent, HTML entities;
    /// none if it has none.
    pub(super) fn unescaped(&self) -> Option<View<'static>> {
        let text = &*self.bytes;
        memchr::memchr3(b'\\', b'%', b'&', text).or_else(|| memchr::memchr(b'=', text))?;
        let mut made = Making::new(text.len());
        let (mut i, mut changed) = (0, false);
        while i < text.len() {
            let Some((decoded, length)) = escape(&text[i..]) else {
                made.push(text[i], self.place(i));
                i += 1;
                continue;
            };
            let place = (self.place(i).0, self.place(i + length - 1).1);
            decoded.encode(&mut [0; 4]).iter().for_each(|byte| made.push(*byte, place));
            (i, changed) = (i + length, true);
        }
        changed.then(|| made.view())
    }

    /// The view without white space and without characters of no width; none if it has none.
    pub(super) fn compacted(&self) -> Option<View<'static>> {
        let text = &*self.bytes;
        let mut made = Making::new(text.len());
        let mut i = 0;
        while i < text.len() {
            match blank(&text[i..]) {
                0 => {
                    made.push(text[i], self.place(i));
                    i += 1;
                }
                length => i += length,
            }
        }
        (made.bytes.len() < text.len()).then(|| made.view())
    }

    /// What every run of base64 letters says, read from each of its first four letters on; either
    /// alphabet. None where nothing is long enough.
    pub(super) fn decoded(&self) -> Vec<View<'static>> {
        self.packed((6, 4), SHORTEST_RUN, sextet)
    }

    /// What every run of hexadecimal digits says, from its first and from its second on.
    pub(super) fn hex_decoded(&self) -> Vec<View<'static>> {
        self.packed((4, 2), SHORTEST_HEX, nibble)
    }

    /// What every run of base32 letters (RFC 4648, either alphabet, any case) says, from each of its
    /// first eight letters on.
    pub(super) fn base32_decoded(&self) -> Vec<View<'static>> {
        let plain = self.packed((5, 8), SHORTEST_BASE32, |letter| match letter {
            b'A'..=b'Z' | b'a'..=b'z' => Some(letter.to_ascii_uppercase() - b'A'),
            b'2'..=b'7' => Some(letter - b'2' + 26),
            _ => None,
        });
        let by_hex = self.packed((5, 8), SHORTEST_BASE32, |letter| match letter {
            b'0'..=b'9' => Some(letter - b'0'),
            b'A'..=b'V' | b'a'..=b'v' => Some(letter.to_ascii_uppercase() - b'A' + 10),
            _ => None,
        });
        plain.into_iter().chain(by_hex).collect()
    }

    /// What runs of at least `shortest` letters say of so many bits each, from each of the first letters
    /// on.
    fn packed(
        &self,
        (width, starts): (u32, usize),
        shortest: usize,
        value: impl Fn(u8) -> Option<u8>,
    ) -> Vec<View<'static>> {
        let runs = runs_of(&self.bytes, shortest, |b| value(b).is_some());
        if runs.is_empty() {
            return vec![];
        }
        let from = |first: usize| {
            let mut made = Making::new(runs.iter().map(Range::len).sum());
            for run in &runs {
                let (mut bits, mut held) = (0_u32, 0);
                for i in (run.start + first).min(run.end)..run.end {
                    bits = bits << width | u32::from(value(self.bytes[i]).unwrap_or_default());
                    held += width;
                    if held >= 8 {
                        held -= 8;
                        // A byte begins in a letter before the one that completes it.
                        let place = (self.place(i.saturating_sub(1)).0, self.place(i).1);
                        made.push((bits >> held) as u8, place);
                    }
                }
                // Nothing goes on from one run into the next.
                made.push(0, self.place(run.end - 1));
            }
            made.view()
        };
        (0..starts).map(from).collect()
    }
}

/// A view that is being made.
struct Making {
    bytes: Vec<u8>,
    at: Vec<(u32, u32)>,
}

impl Making {
    fn new(length: usize) -> Self {
        Self { bytes: Vec::with_capacity(length), at: Vec::with_capacity(length) }
    }

    fn push(&mut self, byte: u8, place: (u32, u32)) {
        self.bytes.push(byte);
        self.at.push(place);
    }

    fn view(self) -> View<'static> {
        View { bytes: Cow::Owned(self.bytes), at: Some(self.at) }
    }
}

/// What an escape stands for.
enum Decoded {
    Byte(u8),
    Char(char),
}

impl Decoded {
    fn encode<'b>(&self, room: &'b mut [u8; 4]) -> &'b [u8] {
        match self {
            Self::Byte(byte) => {
                room[0] = *byte;
                &room[..1]
            }
            Self::Char(c) => c.encode_utf8(room).as_bytes(),
        }
    }
}

/// The escape a text begins with, and its length.
fn escape(text: &[u8]) -> Option<(Decoded, usize)> {
    match text {
        // Of a URL, and quoted-printable (RFC 2045).
        [b'%' | b'=', a, b, ..] => Some((Decoded::Byte(nibble(*a)? << 4 | nibble(*b)?), 3)),
        [b'&', rest @ ..] => entity(rest).map(|(c, length)| (Decoded::Char(c), length + 1)),
        [b'\\', rest @ ..] => backslash(rest).map(|(d, length)| (d, length + 1)),
        _ => None,
    }
}

/// What stands behind a backslash: JSON's escapes, and those of the languages beside it.
fn backslash(text: &[u8]) -> Option<(Decoded, usize)> {
    let hex = |digits: &[u8]| {
        let value = digits.iter().try_fold(0_u32, |v, d| Some(v << 4 | u32::from(nibble(*d)?)))?;
        Some(char::from_u32(value).unwrap_or(char::REPLACEMENT_CHARACTER))
    };
    match text {
        [b'u', b'{', rest @ ..] => {
            let end = rest.iter().take(7).position(|b| *b == b'}')?;
            Some((Decoded::Char(hex(&rest[..end])?), end + 3))
        }
        [b'u', rest @ ..] => Some((Decoded::Char(hex(rest.get(..4)?)?), 5)),
        [b'U', rest @ ..] => Some((Decoded::Char(hex(rest.get(..8)?)?), 9)),
        [b'x', a, b, ..] => Some((Decoded::Byte(nibble(*a)? << 4 | nibble(*b)?), 3)),
        [a @ b'0'..=b'3', b @ b'0'..=b'7', c @ b'0'..=b'7', ..] => {
            let value = (a - b'0') << 6 | (b - b'0') << 3 | (c - b'0');
            Some((Decoded::Byte(value), 3))
        }
        [b'n' | b'r' | b't' | b'b' | b'f', ..] => Some((Decoded::Byte(b' '), 1)),
        [mark, ..] if mark.is_ascii_punctuation() => Some((Decoded::Byte(*mark), 1)),
        _ => None,
    }
}

/// Entities of HTML that stand for what a key may hold; source: the HTML standard, section 13.5.
const ENTITIES: [(&str, char); 44] = [
    ("AMP", '&'),
    ("GT", '>'),
    ("Hat", '^'),
    ("LT", '<'),
    ("NewLine", ' '),
    ("QUOT", '"'),
    ("Tab", ' '),
    ("UnderBar", '_'),
    ("VerticalLine", '|'),
    ("amp", '&'),
    ("apos", '\''),
    ("ast", '*'),
    ("bsol", '\\'),
    ("colon", ':'),
    ("comma", ','),
    ("commat", '@'),
    ("dash", '-'),
    ("dollar", '$'),
    ("equals", '='),
    ("excl", '!'),
    ("grave", '`'),
    ("gt", '>'),
    ("hyphen", '-'),
    ("lbrace", '{'),
    ("lbrack", '['),
    ("lcub", '{'),
    ("lowbar", '_'),
    ("lpar", '('),
    ("lsqb", '['),
    ("lt", '<'),
    ("midast", '*'),
    ("nbsp", ' '),
    ("num", '#'),
    ("percnt", '%'),
    ("period", '.'),
    ("plus", '+'),
    ("quest", '?'),
    ("quot", '"'),
    ("rbrack", ']'),
    ("rcub", '}'),
    ("rpar", ')'),
    ("rsqb", ']'),
    ("semi", ';'),
    ("sol", '/'),
];

/// The entity that stands behind an ampersand, and its length; a number needs no semicolon.
fn entity(text: &[u8]) -> Option<(char, usize)> {
    if let [b'#', rest @ ..] = text {
        let (radix, begin) = if matches!(rest, [b'x' | b'X', ..]) { (16, 2) } else { (10, 1) };
        let digits = text.get(begin..)?;
        let digit = |b: &&u8| char::from(**b).is_digit(radix);
        // Zeros before a number say nothing; no more than these are read.
        let zeros = digits.iter().take(64).take_while(|b| **b == b'0').count();
        let length = zeros + digits[zeros..].iter().take(9).take_while(digit).count();
        let number = std::str::from_utf8(&digits[..length]).ok()?;
        let value = char::from_u32(u32::from_str_radix(number, radix).ok()?)?;
        let closed = usize::from(digits.get(length) == Some(&b';'));
        return Some((value, begin + length + closed));
    }
    let end = text.iter().take(13).position(|b| *b == b';')?;
    let name = std::str::from_utf8(&text[..end]).ok()?;
    let found = ENTITIES.binary_search_by_key(&name, |(n, _)| *n).ok()?;
    Some((ENTITIES[found].1, end + 1))
}

fn nibble(digit: u8) -> Option<u8> {
    char::from(digit).to_digit(16).and_then(|d| u8::try_from(d).ok())
}

/// The length of the white space, or character of no width, that a text begins with.
fn blank(text: &[u8]) -> usize {
    match text {
        [0..=b' ', ..] => 1,
        // A soft hyphen.
        [0xc2, 0xad, ..] => 2,
        // U+200B to U+200D, U+2060 and U+FEFF.
        [0xe2, 0x80, 0x8b..=0x8d, ..] | [0xe2, 0x81, 0xa0, ..] | [0xef, 0xbb, 0xbf, ..] => 3,
        _ => 0,
    }
}

/// The value of a base64 letter of either alphabet.
fn sextet(letter: u8) -> Option<u8> {
    match letter {
        b'A'..=b'Z' => Some(letter - b'A'),
        b'a'..=b'z' => Some(letter - b'a' + 26),
        b'0'..=b'9' => Some(letter - b'0' + 52),
        b'+' | b'-' => Some(62),
        b'/' | b'_' => Some(63),
        _ => None,
    }
}

/// Runs of such letters, neither too short nor too long to be worth decoding.
fn runs_of(text: &[u8], shortest: usize, is_letter: impl Fn(u8) -> bool) -> Vec<Range<usize>> {
    let mut found = vec![];
    let mut begin = 0;
    for i in 0..=text.len() {
        if text.get(i).is_none_or(|b| !is_letter(*b)) {
            if (shortest..=LONGEST_RUN).contains(&(i - begin)) {
                found.push(begin..i);
            }
            begin = i + 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(view: &View<'_>) -> String {
        String::from_utf8_lossy(&view.bytes).into_owned()
    }

    #[test]
    fn every_escape_is_read_and_its_place_is_known() {
        let text = r"a\/b\u002Fc%2fd&#47;e&#x2F;f&sol;g\x2fh\057i";
        let view = View::of(text.as_bytes()).unescaped().unwrap();
        assert_eq!(read(&view), "a/b/c/d/e/f/g/h/i");
        assert_eq!(&text[view.origin(3..4)], r"\u002F");
        assert_eq!(&text[view.origin(9..10)], "&#x2F;");
        assert!(View::of(b"100% & more").unescaped().is_none());
    }

    #[test]
    fn white_space_goes_and_base64_is_read_at_any_place() {
        let view = View::of("a b\r\n\tc\u{200b}d".as_bytes()).compacted().unwrap();
        assert_eq!(read(&view), "abcd");
        let text = b"xx aGVsbG8gd29ybGQgYWdhaW4= xx";
        let views = View::of(text).decoded();
        assert!(views.iter().any(|v| read(v).contains("hello world again")));
        assert!(View::of(b"short words only, no long one").decoded().is_empty());
    }

    #[test]
    fn zeros_before_the_number_of_an_entity_and_quoted_printable_are_read() {
        let text = "&#x0000000006b;&#00000000000107;=6B=6b";
        assert_eq!(read(&View::of(text.as_bytes()).unescaped().unwrap()), "kkkk");
    }

    #[test]
    fn the_names_of_entities_stand_in_order() {
        assert!(ENTITIES.is_sorted_by_key(|(name, _)| *name));
    }
}
