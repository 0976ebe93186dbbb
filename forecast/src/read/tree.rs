//! XML text → elements with their lines, owned and in one list: nothing here recurses.

use roxmltree::{Document, ParsingOptions};

use crate::read::error::Reason;
use crate::read::scan::scan;

/// Most XML nodes of a file; a guess with room.
const MAX_NODES: u32 = 1_000_000;
/// Longest value of an attribute that is kept, bytes: vertices of MJCF's meshes may be long.
const MAX_VALUE: usize = 1 << 20;

/// An element.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub(crate) tag: String,
    pub(crate) line: u32,
    pub(crate) attributes: Vec<(String, String)>,
    pub(crate) parent: Option<usize>,
    pub(crate) children: Vec<usize>,
}

/// A file's elements, parents before their children, in the order of the file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    pub(crate) elements: Vec<Element>,
}

impl Tree {
    /// Reads XML.
    ///
    /// # Errors
    /// [`Reason`] when it is none or breaks a cap.
    pub(crate) fn read(text: &str) -> Result<Self, Reason> {
        scan(text)?;
        let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
        let document = Document::parse_with_options(text, options)?;
        let ends: Vec<usize> =
            text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i).collect();
        let mut tree = Self::default();
        let mut places = std::collections::BTreeMap::new();
        for node in document.descendants().filter(roxmltree::Node::is_element) {
            let at = tree.elements.len();
            places.insert(node.id().get_usize(), at);
            let parent =
                node.parent_element().and_then(|p| places.get(&p.id().get_usize()).copied());
            if let Some(parent) = parent.and_then(|p| tree.elements.get_mut(p)) {
                parent.children.push(at);
            }
            let start = node.range().start;
            let kept = node.attributes().filter(|a| a.value().len() <= MAX_VALUE);
            tree.elements.push(Element {
                tag: node.tag_name().name().to_string(),
                line: ends.partition_point(|&n| n < start) as u32 + 1,
                attributes: kept.map(|a| (a.name().to_string(), a.value().to_string())).collect(),
                parent,
                children: Vec::new(),
            });
        }
        Ok(tree)
    }

    /// The root; `None` of an empty tree.
    pub(crate) fn root(&self) -> Option<&Element> {
        self.elements.first()
    }

    /// The children of an element.
    pub(crate) fn children<'t>(
        &'t self,
        of: &'t Element,
    ) -> impl Iterator<Item = &'t Element> + Clone {
        of.children.iter().filter_map(|i| self.elements.get(*i))
    }

    /// The children of that tag.
    pub(crate) fn tagged<'t>(
        &'t self,
        of: &'t Element,
        tag: &'t str,
    ) -> impl Iterator<Item = &'t Element> {
        self.children(of).filter(move |e| e.tag == tag)
    }

    /// The first child of that tag.
    pub(crate) fn first<'t>(&'t self, of: &'t Element, tag: &'t str) -> Option<&'t Element> {
        self.tagged(of, tag).next()
    }
}

impl Element {
    /// What an attribute says.
    pub(crate) fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    /// Its name; empty if it has none.
    pub(crate) fn name(&self) -> String {
        self.get("name").unwrap_or_default().to_string()
    }
}
