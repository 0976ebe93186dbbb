//! Words from outside as they may be shown: no control characters, no line breaks, no marks that
//! turn the direction of writing.

use std::borrow::Cow;

/// A name, a reason or an id as one inert line: what could steer a terminal, forge a line or turn
/// the direction of writing stands there as an escape such as `\u{1b}`.
///
/// Everything else is returned as it came, without a copy.
pub fn shown(text: &str) -> Cow<'_, str> {
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut inert = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if acts(c) {
            inert.extend(c.escape_unicode());
        } else {
            inert.push(c);
        }
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
}
