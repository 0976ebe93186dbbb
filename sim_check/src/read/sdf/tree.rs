//! An SDFormat file as a tree of elements, with everything it includes put in its place.

use std::collections::BTreeMap;
use std::sync::Arc;

use roxmltree::{Document, ParsingOptions};

use crate::read::caps::{self, MAX_NODES};
use crate::read::draft::Faults;
use crate::read::meshes::Shelf;
use crate::read::xml::shown;

/// Deepest nesting of models, those of other files included; a guess with room.
pub(super) const DEEPEST: usize = 32;
/// Most files of one model; as for MJCF.
const MOST: usize = 256;
/// The word by which an included model that becomes a part of the one around it is known.
pub(super) const MERGED: &str = "merge";

/// The file an element comes from.
#[derive(Debug, Default)]
pub(super) struct File {
    /// What its own addresses are told from, with its slash.
    pub folder: String,
    /// Minor version of the format it is written in.
    pub minor: u32,
}

/// An element.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub tag: String,
    pub attributes: Vec<(String, String)>,
    /// What it says between its tags.
    pub text: String,
    pub children: Vec<Element>,
    /// Its line in the first file; what other files bring stands where they are named.
    pub line: u32,
    pub file: Arc<File>,
}

impl Element {
    /// The value of an attribute that is not empty.
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(n, _)| n == name);
        found.map(|(_, value)| value.trim()).filter(|value| !value.is_empty())
    }

    /// The first element of a name in it.
    pub(super) fn child(&self, tag: &str) -> Option<&Element> {
        self.children.iter().find(|c| c.tag == tag)
    }

    /// All elements of a name in it.
    pub(super) fn all<'a>(&'a self, tag: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |c| c.tag == tag)
    }

    /// What an element in it says, if it says anything.
    pub(super) fn said(&self, tag: &str) -> Option<&str> {
        self.child(tag).map(|c| c.text.as_str()).filter(|text| !text.is_empty())
    }

    /// Whether an element in it says yes.
    pub(super) fn is_so(&self, tag: &str) -> bool {
        self.said(tag).is_some_and(is_true)
    }

    pub(super) fn name(&self) -> &str {
        self.get("name").unwrap_or_default()
    }

    /// Where it is, for a finding.
    pub(super) fn at(&self) -> String {
        format!("line {}: `{}`", self.line, self.tag)
    }
}

/// Whether a word means yes.
pub(super) fn is_true(word: &str) -> bool {
    word == "1" || word.eq_ignore_ascii_case("true")
}

/// The elements of a text whose root is `sdf`; all on `line` where one is given.
fn parsed(text: &str, folder: &str, line: Option<u32>) -> Result<Element, String> {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if let Some(rule) = caps::broken(text) {
        return Err(rule);
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options);
    let document = document.map_err(|e| format!("not XML: {e}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "sdf" {
        return Err(format!("its root is `{}`, not `sdf`", root.tag_name().name()));
    }
    Ok(of_document(root, text, folder, line))
}

/// The elements of a document.
pub(super) fn of_document(
    root: roxmltree::Node,
    text: &str,
    folder: &str,
    line: Option<u32>,
) -> Element {
    let version = root.attribute("version").unwrap_or_default();
    let minor = version.trim().strip_prefix("1.").and_then(|minor| minor.parse().ok());
    let file = Arc::new(File { folder: folder.to_owned(), minor: minor.unwrap_or(NEWEST) });
    let newlines: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).collect();
    element(root, &file, &|start| {
        line.unwrap_or(newlines.partition_point(|&n| n < start) as u32 + 1)
    })
}

/// The version of what says none.
const NEWEST: u32 = 12;

fn element(node: roxmltree::Node, file: &Arc<File>, line: &dyn Fn(usize) -> u32) -> Element {
    let name = node.tag_name();
    let prefix = name.namespace().filter(|space| node.default_namespace() != Some(space));
    let tag = match prefix.and_then(|space| node.lookup_prefix(space)) {
        Some(prefix) => format!("{prefix}:{}", name.name()),
        None => name.name().to_owned(),
    };
    let plain = node.attributes().filter(|a| a.namespace().is_none());
    let texts = node.children().filter(|n| n.is_text()).filter_map(|n| n.text());
    Element {
        tag,
        attributes: plain.map(|a| (a.name().to_owned(), a.value().to_owned())).collect(),
        text: texts.collect::<String>().trim().to_owned(),
        children: node
            .children()
            .filter(|n| n.is_element())
            .map(|n| element(n, file, line))
            .collect(),
        line: line(node.range().start),
        file: file.clone(),
    }
}

/// Puts what an element includes in the place of its `include` elements.
pub(super) struct Includes<'w> {
    pub shelf: &'w mut Shelf,
    pub faults: &'w mut Faults,
    /// What could not be included, with its line.
    pub missing: Vec<String>,
    files: usize,
    elements: usize,
    read: BTreeMap<String, Arc<Element>>,
}

impl<'w> Includes<'w> {
    pub(super) fn new(shelf: &'w mut Shelf, faults: &'w mut Faults) -> Self {
        let (missing, read) = (Vec::new(), BTreeMap::new());
        Self { shelf, faults, missing, files: 0, elements: 0, read }
    }

    /// Includes what an element and those in it ask for.
    pub(super) fn take(&mut self, of: &mut Element, depth: usize) {
        for child in &mut of.children {
            match child.tag.as_str() {
                "include" => {
                    if let Some(model) = self.model(child, depth) {
                        *child = model;
                    }
                }
                "world" | "model" if depth < DEEPEST => self.take(child, depth + 1),
                _ => {}
            }
        }
    }

    fn model(&mut self, of: &Element, depth: usize) -> Option<Element> {
        let uri = of.said("uri").unwrap_or_default().to_owned();
        let (line, folder) = (of.line, of.file.folder.clone());
        let found = self.file(&uri, &folder, line, depth);
        match found {
            Ok(model) => Some(placed(model, of)),
            Err(why) => {
                let words = format!("line {line}: include of `{}`: {why}", shown(&uri));
                self.missing.push(words.clone());
                self.faults.files.push(words);
                None
            }
        }
    }

    fn file(
        &mut self,
        uri: &str,
        folder: &str,
        line: u32,
        depth: usize,
    ) -> Result<Element, String> {
        self.files += 1;
        if depth >= DEEPEST || self.files > MOST {
            return Err(format!("models nest at most {DEEPEST} deep, in {MOST} files in all"));
        }
        let (name, text) = self.text(&beside(folder, uri))?;
        let root = match self.read.get(&name) {
            Some(known) => (**known).clone(),
            None => {
                let folder = name.rfind('/').map_or("", |end| &name[..=end]);
                let root = parsed(&text, folder, Some(line))?;
                self.read.insert(name, Arc::new(root.clone()));
                root
            }
        };
        let mut model = root.children.into_iter().find(|c| c.tag == "model");
        let model = model.as_mut().ok_or("it has no `model`")?;
        self.elements = self.elements.saturating_add(count(model));
        if self.elements > MAX_NODES as usize {
            return Err(format!("all files together hold at most {MAX_NODES} elements"));
        }
        relined(model, line);
        self.take(model, depth + 1);
        Ok(model.clone())
    }

    /// The name and text of the file that an address leads to: itself, or what its `model.config` names.
    fn text(&mut self, address: &str) -> Result<(String, String), String> {
        let last = address.rsplit('/').next().unwrap_or_default();
        if last.contains('.') && last != "." && last != ".." {
            return Ok((address.to_owned(), self.shelf.text(address)?));
        }
        let folder = format!("{}/", address.trim_end_matches('/'));
        let config = self.shelf.text(&format!("{folder}model.config"))?;
        let name = named(&config).ok_or("its model.config names no `sdf`")?;
        let name = format!("{folder}{name}");
        let text = self.shelf.text(&name)?;
        Ok((name, text))
    }
}

/// An address told from a folder, unless it says where it leads itself.
pub(super) fn beside(folder: &str, address: &str) -> String {
    match address.contains("://") || address.starts_with('/') {
        true => address.to_owned(),
        false => format!("{folder}{address}"),
    }
}

/// The newest `sdf` that a `model.config` names.
fn named(config: &str) -> Option<String> {
    let text = config.trim_start_matches('\u{feff}').trim_start();
    if caps::broken(text).is_some() {
        return None;
    }
    let document = Document::parse(text).ok()?;
    let all = document.root_element().children().filter(|n| n.has_tag_name("sdf"));
    let version = |n: &roxmltree::Node| {
        let words = n.attribute("version").unwrap_or_default().trim().split('.');
        words.map(|w| w.parse().unwrap_or(0)).collect::<Vec<u32>>()
    };
    all.max_by_key(version)?.text().map(|t| t.trim().to_owned())
}

fn count(of: &Element) -> usize {
    1 + of.children.iter().map(count).sum::<usize>()
}

fn relined(of: &mut Element, line: u32) {
    of.line = line;
    of.children.iter_mut().for_each(|c| relined(c, line));
}

/// A model as its `include` has it: name, place and whether it moves.
fn placed(mut model: Element, include: &Element) -> Element {
    for (tag, attribute) in [("name", "name"), ("placement_frame", "placement_frame")] {
        if let Some(value) = include.said(tag) {
            model.attributes.retain(|(n, _)| n != attribute);
            model.attributes.push((attribute.to_owned(), value.to_owned()));
        }
    }
    for tag in ["pose", "static"] {
        if let Some(told) = include.child(tag) {
            model.children.retain(|c| c.tag != tag);
            model.children.push(told.clone());
        }
    }
    if include.get(MERGED).is_some_and(is_true) {
        model.attributes.push((MERGED.into(), "true".into()));
    }
    model.line = include.line;
    model
}
