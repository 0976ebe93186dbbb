//! XML read with every broken rule listed: lines, children, numbers.

use std::collections::BTreeMap;

use glamx::DVec3;
use object::kinematics::is_safe_name;
use roxmltree::Node;

use crate::read::draft::{Faults, MAX_LENGTH, NameFault};
use crate::read::meshes::Shelf;

/// Most characters of an attribute that a finding repeats.
const SHOWN: usize = 80;

/// A document being read: where its lines end, its package's meshes, and what is wrong so far.
pub(crate) struct Reader<'a> {
    newlines: Vec<usize>,
    pub(crate) shelf: &'a mut Shelf,
    pub(crate) faults: Faults,
    /// Whether a broken number costs its element alone and not the file.
    pub(crate) spares: bool,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(text: &str, shelf: &'a mut Shelf) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
        Self {
            newlines: ends.map(|(i, _)| i).collect(),
            shelf,
            faults: Faults::default(),
            spares: false,
        }
    }
}

impl Reader<'_> {
    pub(crate) fn line(&self, node: Node) -> u32 {
        let start = node.range().start;
        self.newlines.partition_point(|&n| n < start) as u32 + 1
    }

    pub(crate) fn at(&self, node: Node) -> String {
        format!("line {}: `{}`", self.line(node), node.tag_name().name())
    }

    pub(crate) fn fault(&mut self, node: Node, what: impl std::fmt::Display) {
        let text = format!("{}: {what}", self.at(node));
        self.faults.text.push(text);
    }

    /// A broken number or a missing part of one element.
    pub(crate) fn flaw(&mut self, node: Node, what: impl std::fmt::Display) {
        let text = format!("{}: {what}", self.at(node));
        if self.spares {
            self.faults.numbers.push(text);
        } else {
            self.faults.text.push(text);
        }
    }

    pub(crate) fn check_names<'n>(
        &mut self,
        what: &str,
        names: impl Iterator<Item = (&'n str, u32)>,
        blanks: bool,
    ) {
        let names = names.map(|(name, line)| (name.to_owned(), line));
        judge_names(&mut self.faults, what, names, "", blanks);
    }

    /// The only child of that name; a second one is a fault.
    pub(crate) fn only<'d>(&mut self, node: Node<'d, 'd>, tag: &str) -> Option<Node<'d, 'd>> {
        let mut of_tag = node.children().filter(|n| n.has_tag_name(tag));
        let first = of_tag.next();
        if let Some(second) = of_tag.next() {
            self.flaw(second, "stands here a second time");
        }
        first
    }

    pub(crate) fn required<'d>(&mut self, node: Node<'d, 'd>, tag: &str) -> Option<Node<'d, 'd>> {
        let found = self.only(node, tag);
        if found.is_none() {
            self.flaw(node, format!("has no `{tag}`"));
        }
        found
    }

    pub(crate) fn vector(&mut self, node: Node, attribute: &str, default: Option<DVec3>) -> DVec3 {
        let Some(text) = node.attribute(attribute) else {
            if default.is_none() {
                self.flaw(node, format!("has no `{attribute}`"));
            }
            return default.unwrap_or(DVec3::ZERO);
        };
        let words: Vec<_> = text.split_whitespace().collect();
        if words.len() != 3 {
            let found = words.len();
            self.flaw(
                node,
                format!("{attribute}=\"{}\" must be three numbers, found {found}", shown(text)),
            );
            return DVec3::ZERO;
        }
        let mut vector = DVec3::ZERO;
        for (i, word) in words.into_iter().enumerate() {
            vector[i] = self.parse_length(node, attribute, word);
        }
        vector
    }

    pub(crate) fn number(&mut self, node: Node, attribute: &str) -> f64 {
        self.optional(node, attribute).unwrap_or_else(|| {
            if !node.has_attribute(attribute) {
                self.flaw(node, format!("has no `{attribute}`"));
            }
            0.0
        })
    }

    pub(crate) fn length(&mut self, node: Node, attribute: &str) -> f64 {
        match node.attribute(attribute) {
            Some(text) => self.parse_length(node, attribute, text),
            None => self.number(node, attribute),
        }
    }

    pub(crate) fn optional(&mut self, node: Node, attribute: &str) -> Option<f64> {
        let text = node.attribute(attribute)?;
        self.parse(node, attribute, text)
    }

    pub(crate) fn parse_length(&mut self, node: Node, attribute: &str, text: &str) -> f64 {
        let value = self.parse(node, attribute, text).unwrap_or(0.0);
        if value.abs() > MAX_LENGTH {
            self.flaw(node, format!("{attribute}: {value} is beyond {MAX_LENGTH:e}"));
        }
        value
    }

    pub(crate) fn parse(&mut self, node: Node, attribute: &str, text: &str) -> Option<f64> {
        match text.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Some(value),
            Ok(_) => {
                self.flaw(node, format!("{attribute}=\"{}\" is not finite", shown(text)));
                None
            }
            Err(_) => {
                let hint = if text.contains(',') { " (a comma is no decimal point)" } else { "" };
                let text = shown(text);
                self.flaw(node, format!("{attribute}=\"{text}\" is not a number{hint}"));
                None
            }
        }
    }
}

/// Lists names that programs change or refuse, and those that two have. Only what stands behind the last
/// `within` of a name is its own; `blanks`: whether the format has names with blanks.
pub(crate) fn judge_names(
    faults: &mut Faults,
    what: &str,
    names: impl Iterator<Item = (String, u32)>,
    within: &str,
    blanks: bool,
) {
    let mut seen = BTreeMap::new();
    for (name, line) in names {
        let own = match within.is_empty() {
            true => &name,
            false => name.rsplit(within).next().unwrap_or(&name),
        };
        if !is_safe_name(own) {
            let rule = "must match [A-Za-z_][A-Za-z0-9_]*";
            let words = format!("line {line}: {what} name `{name}` {rule}");
            let who = "in USD, so in Isaac Sim and Newton, which rename it";
            let words = if own.is_empty() { words } else { format!("{words} {who}") };
            // Blanks part names wherever several stand in one attribute or on one line; MJCF has no
            // such place, and MuJoCo reads them.
            let is_blank = |c: char| c.is_whitespace() && !(blanks && c == ' ');
            let is_broken = |c: char| is_blank(c) || c.is_control();
            let is_odd = !own.is_empty() && own.trim() == own && !own.contains(is_broken);
            faults.names.push(NameFault { words, is_odd });
        }
        if let Some(first) = seen.insert(name.clone(), line) {
            let text = format!("lines {first} and {line}: two {what}s are called `{name}`");
            faults.references.push(text.clone());
            faults.names.push(NameFault { words: text, is_odd: false });
        }
    }
}

/// The start of what an attribute says: one may say megabytes.
pub(crate) fn shown(text: &str) -> String {
    let mut start: String = text.chars().take(SHOWN).collect();
    if text.chars().nth(SHOWN).is_some() {
        start.push('…');
    }
    start
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::meshes::Outside;
    use roxmltree::Document;

    /// What is read of an element, and the faults found on the way.
    fn read<T>(text: &str, of: impl Fn(&mut Reader, Node) -> T) -> (T, Vec<String>) {
        let document = Document::parse(text).unwrap();
        let mut shelf = Shelf::new(".".as_ref(), Outside::default());
        let mut reader = Reader::new(text, &mut shelf);
        let made = of(&mut reader, document.root_element());
        (made, reader.faults.text)
    }

    #[test]
    fn three_numbers_are_a_vector_and_anything_else_a_fault() {
        let vector = |text: &str| read(text, |r, n| r.vector(n, "xyz", None));
        assert_eq!(vector("<o xyz=' 1 -2e0  3.5'/>"), (DVec3::new(1.0, -2.0, 3.5), vec![]));
        let (zero, faults) = vector("\n<o xyz='1 2'/>");
        assert_eq!(zero, DVec3::ZERO);
        assert_eq!(faults, ["line 2: `o`: xyz=\"1 2\" must be three numbers, found 2"]);
        assert_eq!(vector("<o/>").1, ["line 1: `o`: has no `xyz`"]);
        assert_eq!(vector("<o xyz='0 0 2e6'/>").1, ["line 1: `o`: xyz: 2000000 is beyond 1e6"]);
    }

    #[test]
    fn a_fault_repeats_no_more_than_the_start_of_a_value() {
        let long = "9,".repeat(500);
        let (none, faults) = read(&format!("<o mass='{long}'/>"), |r, n| r.optional(n, "mass"));
        assert_eq!(none, None);
        assert!(faults[0].len() < 200 && faults[0].ends_with("(a comma is no decimal point)"));
    }

    #[test]
    fn a_second_child_where_one_may_stand_is_a_fault() {
        let (line, faults) = read("<o>\n<a/>\n<a/></o>", |r, n| r.only(n, "a").map(|a| r.line(a)));
        assert_eq!(line, Some(2));
        assert_eq!(faults, ["line 3: `a`: stands here a second time"]);
    }
}
