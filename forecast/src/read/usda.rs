//! As much of USD's text format as the rules need: prims, their schemas, their attributes.

use std::collections::BTreeMap;

use crate::read::error::Reason;

/// Most prims of a stage that are looked at; a guess with room.
const MAX_PRIMS: usize = 200_000;
/// Deepest nesting of prims; a guess with room.
const MAX_DEPTH: usize = 512;
/// Most characters of a value that are kept: rules look at flags and numbers, never at points.
const KEPT: usize = 200;

/// A prim.
#[derive(Clone, Debug, Default)]
pub struct Prim {
    /// Its type, such as `PhysicsRevoluteJoint`; empty if it has none.
    pub kind: String,
    /// Its name.
    pub name: String,
    /// Its line.
    pub line: u32,
    /// Applied schemas.
    pub schemas: Vec<String>,
    /// Its attributes with the start of their values, as text.
    pub attributes: BTreeMap<String, String>,
    /// The prim that it stands in.
    pub parent: Option<usize>,
}

/// A stage's root layer; what it refers to is not read.
#[derive(Clone, Debug, Default)]
pub struct Stage {
    /// Its prims, parents before their children.
    pub prims: Vec<Prim>,
}

impl Prim {
    /// Whether a schema is applied.
    pub fn has(&self, schema: &str) -> bool {
        self.schemas.iter().any(|s| s == schema)
    }
}

impl Stage {
    /// Reads USD text.
    ///
    /// # Errors
    /// [`Reason::Usda`] with the line where it is broken.
    pub(crate) fn read(text: &str) -> Result<Self, Reason> {
        let mut reader = Reader {
            words: Words { text: text.as_bytes(), at: 0, line: 1 },
            stage: Self::default(),
        };
        reader.run()?;
        Ok(reader.stage)
    }
}

/// A token: a word, a string, or a bracket.
#[derive(Clone, Debug, PartialEq)]
enum Token {
    Word(String),
    Text(String),
    Mark(u8),
}

struct Words<'t> {
    text: &'t [u8],
    at: usize,
    line: u32,
}

impl Words<'_> {
    fn broken(&self, what: &'static str) -> Reason {
        Reason::Usda { line: self.line, what }
    }

    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn step(&mut self) {
        self.line += u32::from(self.peek() == Some(b'\n'));
        self.at += 1;
    }

    /// The next token; `None` at the end.
    fn next(&mut self) -> Result<Option<Token>, Reason> {
        loop {
            match self.peek() {
                None => return Ok(None),
                Some(b'#') => {
                    while self.peek().is_some_and(|b| b != b'\n') {
                        self.at += 1;
                    }
                }
                Some(b) if b.is_ascii_whitespace() || b == b',' || b == b';' => self.step(),
                Some(quote @ (b'"' | b'\'' | b'@' | b'<')) => return self.string(quote).map(Some),
                Some(mark @ (b'(' | b')' | b'[' | b']' | b'{' | b'}' | b'=')) => {
                    self.at += 1;
                    return Ok(Some(Token::Mark(mark)));
                }
                Some(_) => return Ok(Some(self.word())),
            }
        }
    }

    fn word(&mut self) -> Token {
        let start = self.at;
        let ends = |b: u8| b.is_ascii_whitespace() || b",;()[]{}=\"'@<#".contains(&b);
        while self.peek().is_some_and(|b| !ends(b)) {
            self.at += 1;
        }
        if self.at == start {
            self.at += 1; // an angle that opens nothing
        }
        Token::Word(String::from_utf8_lossy(&self.text[start..self.at]).into_owned())
    }

    fn string(&mut self, quote: u8) -> Result<Token, Reason> {
        let close = if quote == b'<' { b'>' } else { quote };
        let triple = [close; 3];
        let is_long = quote != b'<' && self.text[self.at..].starts_with(&triple);
        let marks = if is_long { 3 } else { 1 };
        self.at += marks;
        let start = self.at;
        while let Some(b) = self.peek() {
            if self.text[self.at..].starts_with(&triple[..marks]) {
                let text = &self.text[start..self.at];
                self.at += marks;
                return Ok(Token::Text(String::from_utf8_lossy(text).into_owned()));
            }
            if b == b'\\' && quote != b'@' {
                self.step();
            }
            self.step();
        }
        Err(self.broken("a string does not end"))
    }
}

struct Reader<'t> {
    words: Words<'t>,
    stage: Stage,
}

impl Reader<'_> {
    fn run(&mut self) -> Result<(), Reason> {
        let mut open: Vec<Option<usize>> = Vec::new();
        let mut name: Option<String> = None;
        while let Some(token) = self.words.next()? {
            match token {
                Token::Word(word) if matches!(word.as_str(), "def" | "over" | "class") => {
                    let inside = open.iter().rev().find_map(|o| *o);
                    open.push(Some(self.prim(inside)?));
                    name = None;
                    if open.len() > MAX_DEPTH {
                        return Err(self.words.broken("prims nest too deep"));
                    }
                }
                Token::Mark(b'{') => open.push(None),
                Token::Mark(b'}') => {
                    open.pop().ok_or_else(|| self.words.broken("a brace closes nothing"))?;
                }
                // What stands in a variant's braces is said of the prim around it.
                Token::Mark(b'=') if name.as_deref() == Some("variantSet") => name = None,
                Token::Mark(b'=') => {
                    let (value, key) = (self.value()?, name.take());
                    let inside = open.iter().rev().find_map(|o| *o);
                    let prim = inside.and_then(|i| self.stage.prims.get_mut(i));
                    if let (Some(prim), Some(key)) = (prim, key) {
                        prim.attributes.insert(key, value);
                    }
                }
                Token::Mark(b'(') => {
                    self.skip(b'(', b')')?;
                }
                Token::Word(word) => name = Some(word),
                _ => {}
            }
        }
        if open.is_empty() { Ok(()) } else { Err(self.words.broken("a brace is not closed")) }
    }

    /// Reads from `def` to the brace that opens its body.
    fn prim(&mut self, parent: Option<usize>) -> Result<usize, Reason> {
        let mut prim = Prim { line: self.words.line, parent, ..Prim::default() };
        loop {
            match self.words.next()? {
                Some(Token::Word(word)) => prim.kind = word,
                Some(Token::Text(text)) => prim.name = text,
                Some(Token::Mark(b'(')) => prim.schemas.extend(self.metadata()?),
                Some(Token::Mark(b'{')) => break,
                _ => return Err(self.words.broken("a prim has no body")),
            }
        }
        if self.stage.prims.len() >= MAX_PRIMS {
            return Err(self.words.broken("a stage has too many prims"));
        }
        self.stage.prims.push(prim);
        Ok(self.stage.prims.len() - 1)
    }

    /// The schemas that a prim's metadata applies.
    fn metadata(&mut self) -> Result<Vec<String>, Reason> {
        let (mut schemas, mut depth, mut applies) = (Vec::new(), 1, false);
        while depth > 0 {
            match self.words.next()? {
                None => return Err(self.words.broken("a parenthesis is not closed")),
                Some(Token::Word(word)) if depth == 1 => applies = word == "apiSchemas",
                Some(Token::Text(text)) if applies => schemas.push(text),
                Some(Token::Mark(b'(' | b'[' | b'{')) => depth += 1,
                Some(Token::Mark(b')' | b']' | b'}')) => depth -= 1,
                _ => {}
            }
        }
        Ok(schemas)
    }

    /// The start of a value; brackets are passed over to their ends.
    fn value(&mut self) -> Result<String, Reason> {
        match self.words.next()? {
            Some(Token::Word(text) | Token::Text(text)) => Ok(text.chars().take(KEPT).collect()),
            Some(Token::Mark(open @ (b'(' | b'[' | b'{'))) => {
                let close = match open {
                    b'(' => b')',
                    b'[' => b']',
                    _ => b'}',
                };
                self.skip(open, close)
            }
            _ => Err(self.words.broken("an attribute has no value")),
        }
    }

    /// Passes over a bracket to its end; gives back the start of what stood in it.
    fn skip(&mut self, open: u8, close: u8) -> Result<String, Reason> {
        let (mut depth, mut said) = (1, String::new());
        loop {
            match self.words.next()? {
                None => return Err(self.words.broken("a bracket is not closed")),
                Some(Token::Mark(mark)) if mark == open => depth += 1,
                Some(Token::Mark(mark)) if mark == close => {
                    depth -= 1;
                    if depth == 0 {
                        return Ok(said.trim_end().to_string());
                    }
                }
                Some(Token::Word(word) | Token::Text(word)) if said.len() < KEPT => {
                    said += &word.chars().take(KEPT).collect::<String>();
                    said.push(' ');
                }
                Some(_) => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "#usda 1.0\n(\n    upAxis = \"Z\"\n)\ndef Xform \"W\" (\n    prepend apiSchemas = [\"A\", \"B\"]\n    kind = \"x\"\n)\n{\n    # a remark {\n    float a:b = 1.5 (\n        doc = \"x)\"\n    )\n    point3f[] points = [(0, 1, 2), (3, 4, 5)]\n    rel to = </W/c>\n    variantSet \"v\" = {\n        \"one\" {\n            def Cube \"c\"\n            {\n                token t = \"}\"\n            }\n        }\n    }\n}\n";

    #[test]
    fn prims_schemas_and_attributes_are_read_with_their_lines() {
        let stage = Stage::read(TEXT).unwrap();
        let names: Vec<_> = stage.prims.iter().map(|p| (p.name.as_str(), p.line)).collect();
        assert_eq!(names[0], ("W", 5));
        let root = &stage.prims[0];
        assert_eq!(
            (root.kind.as_str(), &root.schemas[..]),
            ("Xform", &["A".to_string(), "B".to_string()][..])
        );
        assert_eq!(root.attributes["a:b"], "1.5");
        assert_eq!(root.attributes["points"], "0 1 2 3 4 5");
        assert_eq!(root.attributes["to"], "/W/c");
        let inner = &stage.prims[1];
        assert_eq!(
            (inner.name.as_str(), inner.parent, inner.attributes["t"].as_str()),
            ("c", Some(0), "}")
        );
    }

    #[test]
    fn broken_text_is_an_error_with_its_line_and_never_a_panic() {
        for (text, line) in
            [("#usda 1.0\ndef X \"a\" {", 2), ("#usda\n}", 2), ("#usda\na = \"b", 2)]
        {
            match Stage::read(text) {
                Err(Reason::Usda { line: found, .. }) => assert_eq!(found, line, "{text}"),
                other => panic!("{text}: {other:?}"),
            }
        }
        for cut in 0..TEXT.len() {
            let _ = Stage::read(&TEXT[..cut]);
        }
        assert!(Stage::read(&format!("#usda{}", "\ndef A \"a\" {".repeat(2000))).is_err());
    }
}
