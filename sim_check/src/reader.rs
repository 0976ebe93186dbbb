//! XML read with every broken rule listed: lines, children, numbers.

use glamx::DVec3;
use roxmltree::Node;

use crate::meshes::Shelf;
use crate::parse::{Faults, MAX_LENGTH};

/// Most characters of an attribute that a finding repeats.
const SHOWN: usize = 80;

/// A document being read: where its lines end, its package's meshes, and what is wrong so far.
pub(crate) struct Reader<'a> {
    newlines: Vec<usize>,
    pub(crate) shelf: &'a mut Shelf,
    pub(crate) faults: Faults,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(text: &str, shelf: &'a mut Shelf) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
        Self { newlines: ends.map(|(i, _)| i).collect(), shelf, faults: Faults::default() }
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

    /// The only child of that name; a second one is a fault.
    pub(crate) fn only<'d>(&mut self, node: Node<'d, 'd>, tag: &str) -> Option<Node<'d, 'd>> {
        let mut of_tag = node.children().filter(|n| n.has_tag_name(tag));
        let first = of_tag.next();
        if let Some(second) = of_tag.next() {
            self.fault(second, "stands here a second time");
        }
        first
    }

    pub(crate) fn required<'d>(&mut self, node: Node<'d, 'd>, tag: &str) -> Option<Node<'d, 'd>> {
        let found = self.only(node, tag);
        if found.is_none() {
            self.fault(node, format!("has no `{tag}`"));
        }
        found
    }

    pub(crate) fn vector(&mut self, node: Node, attribute: &str, default: Option<DVec3>) -> DVec3 {
        let Some(text) = node.attribute(attribute) else {
            if default.is_none() {
                self.fault(node, format!("has no `{attribute}`"));
            }
            return default.unwrap_or(DVec3::ZERO);
        };
        let words: Vec<_> = text.split_whitespace().collect();
        if words.len() != 3 {
            let found = words.len();
            self.fault(
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
                self.fault(node, format!("has no `{attribute}`"));
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
            self.fault(node, format!("{attribute}: {value} is beyond {MAX_LENGTH:e}"));
        }
        value
    }

    pub(crate) fn parse(&mut self, node: Node, attribute: &str, text: &str) -> Option<f64> {
        match text.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Some(value),
            Ok(_) => {
                self.fault(node, format!("{attribute}=\"{}\" is not finite", shown(text)));
                None
            }
            Err(_) => {
                let hint = if text.contains(',') { " (a comma is no decimal point)" } else { "" };
                let text = shown(text);
                self.fault(node, format!("{attribute}=\"{text}\" is not a number{hint}"));
                None
            }
        }
    }
}

/// The start of what an attribute says: one may say megabytes.
fn shown(text: &str) -> String {
    let mut start: String = text.chars().take(SHOWN).collect();
    if text.chars().nth(SHOWN).is_some() {
        start.push('…');
    }
    start
}
