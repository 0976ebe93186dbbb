//! What an XML file may have at most, counted in one pass before it is parsed: the parser compares
//! each attribute of an element with all others of it, and copies the namespaces in scope.

use crate::read::error::Reason;

/// Most attributes of one element. MJCF's richest have fewer than 60; a guess with room.
const MAX_ATTRIBUTES: usize = 256;
/// Most namespaces declared in one file; a guess with room.
const MAX_NAMESPACES: usize = 64;
/// Deepest nesting of elements: room for a chain of a thousand bodies, each in a frame.
const MAX_DEPTH: usize = 1100;

/// Refuses what breaks a cap or declares a document type. What is no XML is left to the parser.
///
/// # Errors
/// [`Reason::Doctype`] or [`Reason::TooMuch`].
pub(crate) fn scan(text: &str) -> Result<(), Reason> {
    let bytes = text.as_bytes();
    let line = |at: usize| bytes[..at].iter().filter(|b| **b == b'\n').count() as u32 + 1;
    let cap = |at: usize, rule, most, found| {
        if found > most {
            return Err(Reason::TooMuch { line: line(at), rule, most, found });
        }
        Ok(())
    };
    let (mut at, mut depth, mut spaces) = (0, 0_usize, 0);
    while let Some(start) = find(bytes, at, b"<") {
        let rest = &bytes[start..];
        at = if rest.starts_with(b"<!--") {
            after(bytes, start, b"-->")
        } else if rest.starts_with(b"<![CDATA[") {
            after(bytes, start, b"]]>")
        } else if rest.starts_with(b"<?") {
            after(bytes, start, b"?>")
        } else if rest.starts_with(b"<!") {
            return Err(Reason::Doctype { line: line(start) });
        } else if rest.starts_with(b"</") {
            depth = depth.saturating_sub(1);
            after(bytes, start, b">")
        } else {
            let tag = Tag::read(bytes, start);
            cap(start, "an element has at most this many attributes:", MAX_ATTRIBUTES, tag.equals)?;
            let inside = &text.as_bytes()[start..tag.end];
            spaces += inside.windows(5).filter(|w| w == b"xmlns").count();
            cap(start, "a file declares at most this many namespaces:", MAX_NAMESPACES, spaces)?;
            depth += usize::from(!tag.closed);
            cap(start, "elements nest at most this deep:", MAX_DEPTH, depth)?;
            tag.end
        };
    }
    Ok(())
}

fn find(bytes: &[u8], from: usize, word: &[u8]) -> Option<usize> {
    let rest = bytes.get(from..)?;
    rest.windows(word.len()).position(|w| w == word).map(|at| from + at)
}

fn after(bytes: &[u8], from: usize, word: &[u8]) -> usize {
    find(bytes, from, word).map_or(bytes.len(), |at| at + word.len())
}

/// A start tag: where it ends, its equals signs outside of quotes, and whether it closes itself.
struct Tag {
    end: usize,
    equals: usize,
    closed: bool,
}

impl Tag {
    fn read(bytes: &[u8], start: usize) -> Self {
        let (mut quote, mut equals) = (None, 0);
        for (i, b) in bytes.iter().enumerate().skip(start + 1) {
            match (quote, *b) {
                (Some(open), b) if open == b => quote = None,
                (Some(_), _) => {}
                (None, b'"' | b'\'') => quote = Some(*b),
                (None, b'=') => equals += 1,
                (None, b'>') => {
                    return Self { end: i + 1, equals, closed: bytes[i - 1] == b'/' };
                }
                _ => {}
            }
        }
        Self { end: bytes.len(), equals, closed: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entity_bomb_is_refused_before_it_is_parsed() {
        let bomb = "<?xml version='1.0'?>\n<!DOCTYPE x [<!ENTITY a 'aa'>]><robot>&a;</robot>";
        assert!(matches!(scan(bomb), Err(Reason::Doctype { line: 2 })));
    }

    #[test]
    fn caps_are_named_with_their_line() {
        let many: String = (0..300).map(|i| format!(" a{i}='1'")).collect();
        let e = scan(&format!("<robot>\n<x{many}/></robot>")).unwrap_err().to_string();
        assert!(e.starts_with("line 2: an element has at most"), "{e}");
        assert!(scan(&"<a>".repeat(2000)).unwrap_err().to_string().contains("nest at most"));
        let spaces: String = (0..70).map(|i| format!("<a xmlns:b{i}='c'/>")).collect();
        assert!(scan(&spaces).unwrap_err().to_string().contains("namespaces"));
    }

    #[test]
    fn comments_quotes_and_unfinished_text_are_passed_over() {
        for text in ["<!-- <!DOCTYPE --><a b='>'/>", "<a", "<", "<a b='", "<![CDATA[<!x]]>", "</a>"]
        {
            assert!(scan(text).is_ok(), "{text}");
        }
    }
}
