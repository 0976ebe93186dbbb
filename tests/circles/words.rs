//! Rust source as words: comments, texts and whatever is compiled for tests alone are left out.

/// A word or a sign, and the line it stands on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    pub text: String,
    pub line: usize,
}

/// Words that begin an item; what follows `#[cfg(test)]` and begins otherwise is a field or an arm.
const ITEMS: [&str; 15] = [
    "pub", "fn", "mod", "use", "impl", "struct", "enum", "union", "const", "static", "trait",
    "type", "async", "unsafe", "extern",
];

/// The words of a source file that the library itself is made of.
pub fn of_code(source: &str) -> Vec<Word> {
    without_tests(&words(source))
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Every word and sign of a source, without comments and texts; `::` is one sign.
fn words(source: &str) -> Vec<Word> {
    let (mut reader, mut words) = (Reader { rest: source, line: 1 }, Vec::new());
    while let Some(c) = reader.rest.chars().next() {
        let line = reader.line;
        if reader.skips(c) {
            continue;
        }
        let length = match c {
            _ if is_word(c) => reader.rest.find(|c| !is_word(c)).unwrap_or(reader.rest.len()),
            ':' if reader.rest.starts_with("::") => 2,
            _ => c.len_utf8(),
        };
        let text = reader.take(length).to_string();
        words.push(Word { text, line });
    }
    words
}

struct Reader<'a> {
    rest: &'a str,
    line: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, length: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(length);
        self.line += taken.matches('\n').count();
        self.rest = rest;
        taken
    }

    /// Steps over blank space, a comment, a text or a character; whether there was one.
    fn skips(&mut self, c: char) -> bool {
        let length = if c.is_whitespace() {
            c.len_utf8()
        } else if self.rest.starts_with("//") {
            self.rest.find('\n').unwrap_or(self.rest.len())
        } else if self.rest.starts_with("/*") {
            comment(self.rest)
        } else if let Some(length) = text(self.rest) {
            length
        } else if c == '\'' {
            character(self.rest)
        } else {
            return false;
        };
        self.take(length);
        true
    }
}

/// Length of a comment, others inside it included.
fn comment(rest: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < rest.len() {
        match rest.get(at..at + 2) {
            Some("/*") => (depth, at) = (depth + 1, at + 2),
            Some("*/") => (depth, at) = (depth - 1, at + 2),
            _ => at += rest[at..].chars().next().map_or(1, char::len_utf8),
        }
        if depth == 0 {
            break;
        }
    }
    at
}

/// Length of a text, raw or not; `None` where none begins.
fn text(rest: &str) -> Option<usize> {
    let quote = rest.find('"')?;
    let prefix = &rest[..quote];
    let kind = prefix.trim_end_matches('#');
    let hashes = prefix.len() - kind.len();
    if !["", "b", "c", "r", "br", "cr"].contains(&kind) || (hashes > 0 && !kind.ends_with('r')) {
        return None;
    }
    let body = quote + 1;
    if kind.ends_with('r') {
        let end = format!("\"{}", "#".repeat(hashes));
        return rest[body..].find(&end).map(|at| body + at + end.len());
    }
    let mut escaped = false;
    for (at, c) in rest[body..].char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return Some(body + at + 1),
            _ => {}
        }
    }
    Some(rest.len())
}

/// Length of a character, or of the sign that begins a lifetime.
fn character(rest: &str) -> usize {
    let mut chars = rest.char_indices().skip(1);
    match chars.next() {
        Some((_, '\\')) => {
            let after = chars.nth(1).map_or(rest.len(), |(at, _)| at);
            rest[after..].find('\'').map_or(rest.len(), |at| after + at + 1)
        }
        Some(_) => chars.next().filter(|&(_, c)| c == '\'').map_or(1, |(at, _)| at + 1),
        None => 1,
    }
}

/// Without items, fields and modules that only tests see.
fn without_tests(words: &[Word]) -> Vec<Word> {
    let (mut kept, mut at) = (Vec::new(), 0);
    while at < words.len() {
        let end = attribute(words, at);
        if end > at && for_tests(&words[at..end]) {
            at = item(words, end);
        } else {
            kept.push(words[at].clone());
            at += 1;
        }
    }
    kept
}

fn is(words: &[Word], at: usize, text: &str) -> bool {
    words.get(at).is_some_and(|w| w.text == text)
}

/// Where the attribute that begins here ends; `at` where none does.
fn attribute(words: &[Word], at: usize) -> usize {
    if is(words, at, "#") && is(words, at + 1, "[") { closed(words, at + 1) } else { at }
}

/// Behind the bracket that closes the one opened here.
pub fn closed(words: &[Word], from: usize) -> usize {
    let mut depth = 0;
    for (at, word) in words.iter().enumerate().skip(from) {
        match word.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    words.len()
}

fn for_tests(attribute: &[Word]) -> bool {
    let said: String = attribute.iter().map(|w| w.text.as_str()).collect();
    said == "#[test]" || said == "#[cfg(test)]" || said.starts_with("#[cfg(all(test,")
}

/// Behind the item, field or arm that begins here, other attributes first.
fn item(words: &[Word], mut at: usize) -> usize {
    loop {
        let end = attribute(words, at);
        if end == at {
            break;
        }
        at = end;
    }
    let Some(first) = words.get(at) else { return at };
    let imports = first.text == "use" || (first.text == "pub" && is(words, at + 1, "use"));
    let whole = ITEMS.contains(&first.text.as_str());
    while at < words.len() {
        match words[at].text.as_str() {
            ";" => return at + 1,
            "," if !whole => return at + 1,
            "}" => return at,
            "{" if whole && !imports => return closed(words, at),
            "(" | "[" | "{" => at = closed(words, at),
            _ => at += 1,
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(source: &str) -> String {
        of_code(source).iter().map(|w| w.text.as_str()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn texts_comments_and_characters_are_no_code() {
        let source =
            "a /* b /* c */ d */ \"e \\\" f\" r#\"g \" h\"# 'i' '\\'' '\\u{41}' &'j k // l\nm";
        assert_eq!(said(source), "a & j k m");
        assert_eq!(of_code(source).last().unwrap().line, 2);
        assert_eq!(said("let r = br\"x\"; b"), "let r = ; b");
    }

    #[test]
    fn what_only_tests_see_is_left_out() {
        assert_eq!(said("#[cfg(test)] mod tests { a { b } } c"), "c");
        assert_eq!(said("#[cfg(test)] use a::{b, c}; d"), "d");
        assert_eq!(said("#[cfg(test)] #[allow(x)] pub fn a<B, C>(d: E) -> F { g } h"), "h");
        assert_eq!(said("S { #[cfg(test)] a: [B; 2], c: D }"), "S { c : D }");
        assert_eq!(said("#[cfg(unix)] mod a;"), "# [ cfg ( unix ) ] mod a ;");
    }
}
