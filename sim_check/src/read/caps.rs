//! What an XML file may have at most, counted in one pass before it is parsed: the parser compares
//! each attribute of an element with all others of it, and copies the namespaces in scope.
//!
//! Entities need no cap: the parser takes no document type, so nothing can be declared.

/// Most attributes of one element. The richest elements of URDF have 6, those of MJCF's schema
/// fewer than 60; a guess with room.
pub const MAX_ATTRIBUTES: usize = 256;
/// Most namespaces declared in one file. What xacro leaves behind is about a dozen; a guess with
/// room.
pub const MAX_NAMESPACES: usize = 64;
/// Deepest nesting of elements: room for a chain of [`crate::read::draft::MAX_LINKS`] bodies, each in a
/// frame, as MJCF nests them.
pub const MAX_DEPTH: usize = 1100;
/// Longest name, bytes: findings repeat names. Real ones have fewer than 100; a guess with room.
pub const MAX_NAME: usize = 1024;

/// Most XML nodes a model may have.
pub const MAX_NODES: u32 = 1_000_000;

/// A count and where it was reached first, in bytes from the start.
#[derive(Clone, Copy, Default)]
struct Most {
    count: usize,
    at: usize,
}

impl Most {
    fn note(&mut self, count: usize, at: usize) {
        if count > self.count {
            *self = Self { count, at };
        }
    }
}

/// What a file has most of.
#[derive(Default)]
struct Census {
    attributes: Most,
    namespaces: Most,
    depth: Most,
    name: Most,
}

/// The first cap a text breaks: the line, the rule, what was found. What is no XML is left for the
/// parser to refuse; it reads no further than this does.
pub(crate) fn broken(text: &str) -> Option<String> {
    let census = Scan { text: text.as_bytes(), at: 0, depth: 0, census: Census::default() }.done();
    let rules = [
        (census.attributes, MAX_ATTRIBUTES, "an element has at most", "attributes"),
        (census.namespaces, MAX_NAMESPACES, "a file declares at most", "namespaces"),
        (census.depth, MAX_DEPTH, "elements nest at most", "deep"),
        (census.name, MAX_NAME, "a name has at most", "bytes"),
    ];
    let (most, cap, rule, what) = rules.into_iter().find(|(most, cap, ..)| most.count > *cap)?;
    let line = text.as_bytes().iter().take(most.at).filter(|b| **b == b'\n').count() + 1;
    Some(format!("line {line}: {rule} {cap} {what}, found {}", most.count))
}

struct Scan<'t> {
    text: &'t [u8],
    at: usize,
    depth: usize,
    census: Census,
}

impl Scan<'_> {
    /// Counts to the end, or to where this is no XML.
    fn done(mut self) -> Census {
        while self.skip_to(b"<", 0).is_some() {
            if self.markup().is_none() {
                break;
            }
        }
        self.census
    }

    /// What starts with the angle bracket here; `None` if it does not end.
    fn markup(&mut self) -> Option<()> {
        let rest = &self.text[self.at..];
        match rest {
            [b'<', b'!', b'-', b'-', ..] => self.skip_to(b"-->", 4),
            _ if rest.starts_with(b"<![CDATA[") => self.skip_to(b"]]>", 9),
            [b'<', b'?', ..] => self.skip_to(b"?>", 2),
            [b'<', b'!', ..] => None,
            [b'<', b'/', ..] => {
                self.depth = self.depth.saturating_sub(1);
                self.skip_to(b">", 2)
            }
            _ => self.tag(),
        }
    }

    /// Goes on to some bytes, looking from so many bytes ahead.
    fn skip_to(&mut self, end: &[u8], ahead: usize) -> Option<()> {
        let from = self.at + ahead;
        let found = self.text.get(from..)?.windows(end.len()).position(|w| w == end)?;
        self.at = from + found;
        Some(())
    }

    /// An opening tag: its attributes, and one more level unless it is closed at once.
    fn tag(&mut self) -> Option<()> {
        let start = self.at;
        self.at += 1;
        self.word()?;
        let mut attributes = 0;
        loop {
            self.blanks();
            match self.text.get(self.at)? {
                b'>' => {
                    self.depth += 1;
                    self.census.depth.note(self.depth, start);
                    return Some(());
                }
                b'/' => return Some(()),
                _ => {
                    attributes += 1;
                    self.census.attributes.note(attributes, start);
                    self.attribute()?;
                }
            }
        }
    }

    fn attribute(&mut self) -> Option<()> {
        let start = self.at;
        let name = self.word()?;
        self.blanks();
        let name = &self.text[start..name];
        if self.text.get(self.at)? != &b'=' {
            return None;
        }
        self.at += 1;
        self.blanks();
        let quote = [*self.text.get(self.at).filter(|q| matches!(q, b'"' | b'\''))?];
        let value = self.at + 1;
        self.skip_to(&quote, 1)?;
        if name == b"name" {
            self.census.name.note(self.at - value, start);
        }
        if name == b"xmlns" || name.starts_with(b"xmlns:") {
            self.census.namespaces.note(self.census.namespaces.count + 1, start);
        }
        self.at += 1;
        Some(())
    }

    /// The end of the word that starts here; `None` if there is none.
    fn word(&mut self) -> Option<usize> {
        let ends =
            |b: &u8| b.is_ascii_whitespace() || matches!(b, b'=' | b'>' | b'/' | b'"' | b'\'');
        let length = self.text.get(self.at..)?.iter().position(ends)?;
        self.at += length;
        (length > 0).then_some(self.at)
    }

    fn blanks(&mut self) {
        while self.text.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_exact_at_every_cap() {
        let attributes = |n: usize| {
            let all: String = (0..n).map(|i| format!(" a{i} = '{i}>'")).collect();
            format!("<robot\n><link{all}/></robot>")
        };
        assert_eq!(broken(&attributes(MAX_ATTRIBUTES)), None);
        let found = "line 2: an element has at most 256 attributes, found 257";
        assert_eq!(broken(&attributes(MAX_ATTRIBUTES + 1)).as_deref(), Some(found));
        let nested = |n: usize| "<a>".repeat(n) + &"</a>".repeat(n);
        assert_eq!(broken(&nested(MAX_DEPTH)), None);
        assert!(broken(&nested(MAX_DEPTH + 1)).is_some_and(|e| e.ends_with("found 1101")));
        let spaces =
            |n: usize| (0..n).map(|i| format!("<a xmlns:n{i}=\"u\"/>")).collect::<String>();
        assert_eq!(broken(&spaces(MAX_NAMESPACES)), None);
        assert!(broken(&spaces(MAX_NAMESPACES + 1)).is_some());
        let named = |n: usize| format!("<a name='{}'/>", "x".repeat(n));
        assert_eq!(broken(&named(MAX_NAME)), None);
        assert!(broken(&named(MAX_NAME + 1)).is_some_and(|e| e.contains("a name has at most")));
    }

    #[test]
    fn what_is_no_tag_is_not_counted() {
        let bomb: String = (0..1000).map(|i| format!(" a{i}=''")).collect();
        for text in [
            format!("<r><!-- <link{bomb}/> --></r>"),
            format!("<r><![CDATA[<link{bomb}/>]]></r>"),
            format!("<?xml{bomb}?><r/>"),
            format!("<r>{bomb}</r>"),
            format!("<r a=\"{}\"/>", bomb.replace('<', "")),
        ] {
            assert_eq!(broken(&text), None, "{text:.60}");
        }
    }

    #[test]
    fn text_that_breaks_off_anywhere_is_left_for_the_parser() {
        let text = "<?xml v='1'?><!-- c --><r a = \"1\" xmlns:x='u'><![CDATA[x]]><b/></r>";
        assert!((0..text.len()).all(|end| broken(&text[..end]).is_none()));
        for odd in ["<", "<>", "< a", "<a b>", "<a b=c>", "<a =''>", "<!DOCTYPE r []><r/>", "</a>"]
        {
            assert_eq!(broken(odd), None, "{odd}");
        }
    }
}
