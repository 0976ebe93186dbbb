//! Elements of XML as a tree of our own, for models that stand in several files: read, put
//! together, and written as one text in which every element keeps its line.

use std::fmt::Write as _;
use std::sync::Arc;

use roxmltree::{Document, Node, ParsingOptions};

use crate::read::caps::{self, MAX_NODES};

/// Most bytes of the text that several files become together (16 MiB).
const MAX_TEXT: usize = 16 << 20;

/// Whose an element is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Space {
    /// The model's own.
    Own,
    /// xacro's.
    Xacro,
    /// Somebody else's: no model needs it.
    Other,
}

/// An element; text between elements is no part of any model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Element {
    pub space: Space,
    pub name: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Arc<Element>>,
    /// Its line in the model's first file; what other files bring stands where they are named.
    pub line: u32,
}

impl Element {
    /// The element with nothing in it, as one of the model's own.
    pub(crate) fn bare(&self) -> Self {
        Self {
            space: Space::Own,
            name: self.name.clone(),
            attributes: Vec::new(),
            children: Vec::new(),
            line: self.line,
        }
    }

    /// The value of an attribute.
    pub(crate) fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }
}

/// The root element of a text; all of it stands on `line` where one is given.
pub(crate) fn read(text: &str, line: Option<u32>) -> Result<Arc<Element>, String> {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if let Some(rule) = caps::broken(text) {
        return Err(rule);
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options);
    let document = document.map_err(|e| format!("not XML: {e}"))?;
    let newlines: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).collect();
    let at = |node: Node| {
        line.unwrap_or(newlines.partition_point(|&n| n < node.range().start) as u32 + 1)
    };
    Ok(element(document.root_element(), &at))
}

fn element(node: Node, line: &dyn Fn(Node) -> u32) -> Arc<Element> {
    let space = match node.tag_name().namespace() {
        Some(space) if space.contains("xacro") => Space::Xacro,
        Some(_) if is_prefixed(node) => Space::Other,
        _ => Space::Own,
    };
    let plain = node.attributes().filter(|a| a.namespace().is_none());
    Arc::new(Element {
        space,
        name: node.tag_name().name().to_owned(),
        attributes: plain.map(|a| (a.name().to_owned(), a.value().to_owned())).collect(),
        children: node
            .children()
            .filter(Node::is_element)
            .filter(|n| !is_prefixed(*n) || element_is_read(*n))
            .map(|n| element(n, line))
            .collect(),
        line: line(node),
    })
}

fn element_is_read(node: Node) -> bool {
    node.tag_name().namespace().is_some_and(|space| space.contains("xacro"))
}

/// Whether its name has a prefix, so that it is not of the model's own language.
fn is_prefixed(node: Node) -> bool {
    let space = node.tag_name().namespace();
    space.is_some() && space != node.default_namespace()
}

/// The text of an element, each on its own line or, where an earlier one went past that, after it;
/// `None` where it would be too long.
pub(crate) fn write(root: &Element) -> Option<String> {
    let mut out = Text { text: String::new(), line: 1 };
    out.element(root)?;
    Some(out.text)
}

struct Text {
    text: String,
    line: u32,
}

impl Text {
    fn element(&mut self, element: &Element) -> Option<()> {
        while self.line < element.line {
            self.text.push('\n');
            self.line += 1;
        }
        self.text.extend(["<", &element.name]);
        for (name, value) in &element.attributes {
            let _ = write!(self.text, " {name}=\"");
            for c in value.chars() {
                match c {
                    '&' => self.text.push_str("&amp;"),
                    '<' => self.text.push_str("&lt;"),
                    '"' => self.text.push_str("&quot;"),
                    '\n' | '\t' | '\r' => self.text.push(' '),
                    c => self.text.push(c),
                }
            }
            self.text.push('"');
        }
        if self.text.len() > MAX_TEXT {
            return None;
        }
        if element.children.is_empty() {
            self.text.push_str("/>");
            return Some(());
        }
        self.text.push('>');
        for child in element.children.iter().filter(|c| c.space == Space::Own) {
            self.element(child)?;
        }
        self.text.extend(["</", &element.name, ">"]);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_keep_their_lines_and_their_values() {
        let text = "<robot name='a&amp;b'>\n\n<link name='&lt;&quot;'/><g:x xmlns:g='u'/>\n<joint><a/></joint></robot>";
        let read = read(text, None).unwrap();
        let written = write(&read).unwrap();
        let expected =
            "<robot name=\"a&amp;b\">\n\n<link name=\"&lt;&quot;\"/>\n<joint><a/></joint></robot>";
        assert_eq!(written, expected);
        assert_eq!(super::read(&written, None).unwrap(), read);
    }

    #[test]
    fn what_another_file_brings_stands_on_the_line_that_names_it() {
        let read = read("<a>\n<b/>\n</a>", Some(7)).unwrap();
        assert_eq!((read.line, read.children[0].line), (7, 7));
    }
}
