//! Words from outside as they may be shown: no control characters, no line breaks, no marks that
//! turn the direction of writing.

use std::borrow::Cow;
use std::fmt::Write as _;

/// A name, a reason or an id as one inert line: what could steer a terminal, forge a line or turn
/// the direction of writing stands there as an escape such as `\u{1b}`.
///
/// Everything else is returned as it came, without a copy.
pub fn shown(text: &str) -> Cow<'_, str> {
    escaped(text, acts, |c, out| out.extend(c.escape_unicode()))
}

/// The beginning of a text that may be of any length: at most so many characters, and then `…`.
pub fn brief(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
        None => Cow::Borrowed(text),
    }
}

/// A text of ours with words from outside in it, as it may be printed: its line feeds and tabs stay,
/// everything else is as in [`shown`]. Words that may hold line feeds go through [`shown`] before.
pub fn lines(text: &str) -> Cow<'_, str> {
    let acts = |c| acts(c) && !matches!(c, '\n' | '\t');
    escaped(text, acts, |c, out| out.extend(c.escape_unicode()))
}

/// JSON as it may be printed: what acts stands in its strings as `\u` and four digits, which reads
/// as the same. Between its strings JSON has nothing that acts but line feeds, which stay.
pub fn json(text: &str) -> Cow<'_, str> {
    let acts = |c| acts(c) && !matches!(c, '\n' | '\t' | '\r');
    escaped(text, acts, |c, out| {
        // Writing to a string cannot fail; nothing that acts needs a surrogate pair.
        let _ = write!(out, "\\u{:04x}", u32::from(c));
    })
}

/// Text as it may stand in XML and HTML, between tags and inside quotes: `&`, `<`, `>` and `"` stand
/// there as entities. What acts on a terminal is not its business: see [`shown`].
pub fn markup(text: &str) -> Cow<'_, str> {
    let marks = |c| matches!(c, '&' | '<' | '>' | '"');
    escaped(text, marks, |c, out| {
        out.push_str(match c {
            '&' => "&amp;",
            '<' => "&lt;",
            '>' => "&gt;",
            _ => "&quot;",
        });
    })
}

fn escaped<'t>(
    text: &'t str,
    acts: impl Fn(char) -> bool,
    escape: impl Fn(char, &mut String),
) -> Cow<'t, str> {
    if !text.contains(&acts) {
        return Cow::Borrowed(text);
    }
    let mut inert = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if acts(c) { escape(c, &mut inert) } else { inert.push(c) }
    }
    Cow::Owned(inert)
}

/// Whether a character does something to where it is shown: the C0 and C1 control characters, the
/// line and paragraph separators, and the marks and isolates of UAX #9.
pub fn acts(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_steer_a_terminal_become_escapes() {
        assert_eq!(shown("a\nb\u{1b}[2J"), "a\\u{a}b\\u{1b}[2J");
        assert_eq!(shown("x\u{202e}fdru.\u{2066}\u{9b}"), "x\\u{202e}fdru.\\u{2066}\\u{9b}");
        assert!(matches!(shown("Kühlschrank 冷蔵庫"), Cow::Borrowed(_)));
    }

    #[test]
    fn of_a_long_text_the_beginning_is_told() {
        assert_eq!(brief("冷蔵庫の扉", 3), "冷蔵庫…");
        assert!(matches!(brief("冷蔵庫", 3), Cow::Borrowed("冷蔵庫")));
    }

    #[test]
    fn a_text_of_ours_keeps_its_lines_and_nothing_else_that_acts() {
        assert_eq!(lines("a\tb\nc\r\u{1b}c\u{85}"), "a\tb\nc\\u{d}\\u{1b}c\\u{85}");
        assert!(matches!(lines("one\n\ttwo\n"), Cow::Borrowed(_)));
    }

    #[test]
    fn markup_is_said_and_not_done() {
        assert_eq!(markup("<a b=\"1 & 2\">'"), "&lt;a b=&quot;1 &amp; 2&quot;&gt;'");
        assert!(matches!(markup("Kühlschrank\n"), Cow::Borrowed(_)));
    }

    #[test]
    fn json_reads_the_same() {
        let text = "{\n  \"a\u{9b}\u{202e}\": \"\u{2028}b\"\n}\n";
        assert_eq!(json(text), "{\n  \"a\\u009b\\u202e\": \"\\u2028b\"\n}\n");
        assert!(matches!(json("{\"a\": \"\\u001b\"}\n"), Cow::Borrowed(_)));
    }
}
