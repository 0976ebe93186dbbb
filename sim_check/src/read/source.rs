//! The text of a model and where in it each element stands, so that a number can be changed and
//! everything else stays: comments, order, indentation, line ends.
//!
//! ```
//! use sim_check::read::source::Source;
//! let text = "<robot name='r'>\n  <!-- kept --><link  name = 'a'/>\n</robot>\n";
//! let source = Source::of(text).unwrap();
//! let link = source.named("link", "a").unwrap();
//! let renamed = source.set(link, "name", "b");
//! assert_eq!(source.with(&[renamed]).unwrap(), text.replace("'a'", "'b'"));
//! ```

use std::ops::Range;

use roxmltree::{Document, ParsingOptions};

use crate::read::caps::{self, MAX_NODES};
use crate::read::draft::Faults;
use crate::read::{load, parse, xacro};

/// A text with the places of its elements.
#[derive(Clone, Debug)]
pub struct Source {
    /// The whole file.
    whole: String,
    /// Where in it the XML begins.
    begin: usize,
    /// Where in the XML declarations were put in for reading, and how many bytes.
    put_in: (usize, usize),
    /// As it is read.
    text: String,
    elements: Vec<Element>,
}

/// An element and where it stands in the text as it is read.
#[derive(Clone, Debug)]
struct Element {
    tag: String,
    /// Whether it is of the model's own language.
    is_own: bool,
    attributes: Vec<Attribute>,
    children: Vec<usize>,
    parent: Option<usize>,
    span: Range<usize>,
    /// End of its name in its first tag.
    named: usize,
    line: u32,
}

#[derive(Clone, Debug)]
struct Attribute {
    name: String,
    value: String,
    /// With its name and its quotes.
    span: Range<usize>,
    /// What stands between the quotes.
    told: Range<usize>,
}

/// An element of a [`Source`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct At(usize);

/// A change of the text: what stands in a span of the file gives way to something else.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// Bytes of the file.
    pub span: Range<usize>,
    /// What stands there instead.
    pub text: String,
}

impl Source {
    /// The places of a text; `None` where it is not XML that is read here.
    pub fn of(whole: &str) -> Option<Self> {
        let text = load::begun(whole);
        let begin = whole.len() - text.len();
        let declared = parse::declared(text, &mut Faults::default());
        let (read, put_in) = match declared {
            Some((read, at)) => {
                let more = read.len() - text.len();
                (read, (at, more))
            }
            None => (text.to_owned(), (0, 0)),
        };
        if caps::broken(&read).is_some() {
            return None;
        }
        let elements = elements(&read)?;
        Some(Self { whole: whole.to_owned(), begin, put_in, text: read, elements })
    }

    /// The whole text.
    pub fn whole(&self) -> &str {
        &self.whole
    }

    /// The root element.
    pub fn root(&self) -> At {
        At(0)
    }

    /// Whether macros or other files bring a part of the model.
    pub fn is_put_together(&self) -> bool {
        xacro::is_wanted(&self.text) || self.text.contains("<include")
    }

    fn element(&self, at: At) -> &Element {
        &self.elements[at.0]
    }

    /// The name of an element.
    pub fn tag(&self, at: At) -> &str {
        &self.element(at).tag
    }

    /// The line of an element, from 1.
    pub fn line(&self, at: At) -> u32 {
        self.element(at).line
    }

    /// The value of an attribute.
    pub fn get(&self, at: At, name: &str) -> Option<&str> {
        self.attribute(at, name).map(|a| a.value.as_str())
    }

    fn attribute(&self, at: At, name: &str) -> Option<&Attribute> {
        self.element(at).attributes.iter().find(|a| a.name == name)
    }

    /// The elements of a name in an element, of the model's own language.
    pub fn children(&self, at: At, tag: &str) -> Vec<At> {
        let is_one = |&c: &usize| self.elements[c].is_own && self.elements[c].tag == tag;
        self.element(at).children.iter().copied().filter(is_one).map(At).collect()
    }

    /// All elements in an element, of whatever name.
    pub fn all_children(&self, at: At) -> Vec<At> {
        self.element(at).children.iter().copied().map(At).collect()
    }

    /// The only element of a name in an element.
    pub fn child(&self, at: At, tag: &str) -> Option<At> {
        match self.children(at, tag)[..] {
            [one] => Some(one),
            _ => None,
        }
    }

    /// The first element in an element, of whatever name.
    pub fn first_child(&self, at: At) -> Option<At> {
        self.element(at).children.first().copied().map(At)
    }

    /// The element that an element stands in.
    pub fn parent(&self, at: At) -> Option<At> {
        self.element(at).parent.map(At)
    }

    /// The only element of a name and with this `name` that macros do not make: in a URDF just below
    /// the root, in MJCF anywhere but in what is copied.
    pub fn named(&self, tag: &str, name: &str) -> Option<At> {
        let mut all = self.plain(tag).filter(|&at| self.get(at, "name") == Some(name));
        let first = all.next();
        if all.next().is_some() { None } else { first }
    }

    /// The only element of a name that begins on a line.
    pub fn on_line(&self, tag: &str, line: u32) -> Option<At> {
        let mut all = self.plain(tag).filter(|&at| self.line(at) == line);
        let first = all.next();
        if all.next().is_some() { None } else { first }
    }

    fn plain(&self, tag: &str) -> impl Iterator<Item = At> {
        let is_urdf = self.elements[0].tag == "robot";
        let stands = move |at: At| {
            let mut above = std::iter::successors(self.parent(at), |&a| self.parent(a));
            match is_urdf {
                true => self.parent(at) == Some(self.root()),
                false => above.all(|a| !matches!(self.tag(a), "replicate" | "default")),
            }
        };
        let all = (0..self.elements.len()).map(At);
        all.filter(move |&at| self.element(at).is_own && self.tag(at) == tag && stands(at))
    }

    /// Whether a change would put something else in the place of a macro or a substitution.
    pub fn takes_macro(&self, edit: &Edit) -> bool {
        let told = self.whole.get(edit.span.clone()).unwrap_or_default();
        ["${", "$(", "xacro:"].iter().any(|mark| told.contains(mark))
    }

    /// The text of an element.
    pub fn written(&self, at: At) -> &str {
        &self.text[self.element(at).span.clone()]
    }

    /// Where something of the text as it is read stands in the file.
    fn in_file(&self, at: usize) -> usize {
        let (put_in, more) = self.put_in;
        self.begin + if at > put_in { at.saturating_sub(more).max(put_in) } else { at }
    }

    fn edit(&self, span: Range<usize>, text: String) -> Edit {
        Edit { span: self.in_file(span.start)..self.in_file(span.end), text }
    }

    /// Another value of an attribute, put in where there is none.
    pub fn set(&self, at: At, name: &str, value: &str) -> Edit {
        let quoted = value.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        if let Some(attribute) = self.attribute(at, name) {
            return self.edit(attribute.told.clone(), quoted.replace('\'', "&apos;"));
        }
        let element = self.element(at);
        let end = element.attributes.iter().map(|a| a.span.end).max().unwrap_or(element.named);
        self.edit(end..end, format!(" {name}=\"{quoted}\""))
    }

    /// An attribute taken out, with the blanks before it.
    pub fn unset(&self, at: At, name: &str) -> Option<Edit> {
        let span = self.attribute(at, name)?.span.clone();
        let before = self.text[..span.start].trim_end().len();
        Some(self.edit(before..span.end, String::new()))
    }

    /// An element and what stands in it, written anew.
    pub fn replace(&self, at: At, text: String) -> Edit {
        self.edit(self.element(at).span.clone(), text)
    }

    /// An element taken out, with its line where it stands alone there.
    pub fn remove(&self, at: At) -> Edit {
        let Range { start, end } = self.element(at).span.clone();
        let indent = self.text[..start].trim_end_matches([' ', '\t']).len();
        let after = &self.text[end..];
        let rest = after.len() - after.trim_start_matches([' ', '\t']).len();
        let line_end = ["\r\n", "\n"].iter().find(|e| after[rest..].starts_with(**e));
        match line_end {
            Some(line_end) if indent == 0 || self.text[..indent].ends_with('\n') => {
                self.edit(indent..end + rest + line_end.len(), String::new())
            }
            _ => self.edit(start..end, String::new()),
        }
    }

    /// What stands before an element on its line, where that is blanks alone.
    pub fn indent(&self, at: At) -> Option<&str> {
        let start = self.element(at).span.start;
        let line = self.text[..start].rfind('\n').map(|n| n + 1)?;
        let before = &self.text[line..start];
        before.trim().is_empty().then_some(before)
    }

    /// The line end of the file.
    pub fn line_end(&self) -> &str {
        if self.text.contains("\r\n") { "\r\n" } else { "\n" }
    }

    /// Elements put in as the first of an element, indented as its children are; each `\n` of the
    /// text begins a line, each `\t` after it is one step further in.
    pub fn insert_first(&self, at: At, text: &str) -> Edit {
        self.insert(at, self.first_child(at), text, true)
    }

    /// The same after everything in an element.
    pub fn insert_last(&self, at: At, text: &str) -> Edit {
        let last = self.element(at).children.last().copied().map(At);
        self.insert(at, last, text, false)
    }

    /// The same after one of its children.
    pub fn insert_after(&self, at: At, child: At, text: &str) -> Edit {
        self.insert(at, Some(child), text, false)
    }

    fn insert(&self, at: At, child: Option<At>, text: &str, before: bool) -> Edit {
        let (own, inner) = (self.indent(at), child.and_then(|c| self.indent(c)));
        let step = match (own, inner) {
            (Some(own), Some(inner)) if inner.len() > own.len() => inner[own.len()..].to_owned(),
            (Some(own), _) if own.contains('\t') => "\t".to_owned(),
            _ => "  ".to_owned(),
        };
        let indent = inner.map(str::to_owned).or(own.map(|own| format!("{own}{step}")));
        let on_lines = |text: &str| match &indent {
            Some(indent) => {
                let lines = text.split('\n').map(|l| l.replace('\t', &step));
                lines.collect::<Vec<_>>().join(&format!("{}{indent}", self.line_end()))
            }
            None => text.replace(['\n', '\t'], ""),
        };
        let told = on_lines(text);
        let between = match &indent {
            Some(indent) if inner.is_some() || child.is_none() => {
                format!("{}{indent}", self.line_end())
            }
            _ => String::new(),
        };
        let span = self.element(at).span.clone();
        match child {
            Some(child) if before => {
                let start = self.element(child).span.start;
                self.edit(start..start, format!("{told}{between}"))
            }
            Some(child) => {
                let end = self.element(child).span.end;
                self.edit(end..end, format!("{between}{told}"))
            }
            None => {
                let tag = &self.element(at).tag;
                let close = own.map_or(String::new(), |own| format!("{}{own}", self.line_end()));
                let written = &self.text[span.clone()];
                let inside = format!("{between}{told}{close}");
                if let Some(open) = written.strip_suffix("/>") {
                    let start = span.start + open.trim_end().len();
                    self.edit(start..span.end, format!(">{inside}</{tag}>"))
                } else {
                    let end = span.start + written.rfind("</").unwrap_or(written.len());
                    let start = span.start + written[..end - span.start].trim_end().len();
                    self.edit(start..end, inside)
                }
            }
        }
    }

    /// The file with these changes; `None` where two of them touch.
    pub fn with(&self, edits: &[Edit]) -> Option<String> {
        let mut sorted: Vec<&Edit> = edits.iter().collect();
        sorted.sort_by_key(|e| (e.span.start, e.span.end));
        let (mut out, mut from) = (String::with_capacity(self.whole.len()), 0);
        for edit in sorted {
            out.push_str(self.whole.get(from..edit.span.start)?);
            out.push_str(&edit.text);
            from = edit.span.end;
        }
        out.push_str(self.whole.get(from..)?);
        Some(out)
    }
}

fn elements(text: &str) -> Option<Vec<Element>> {
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).ok()?;
    let newlines: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).collect();
    let mut all: Vec<Element> = Vec::new();
    let mut known = std::collections::BTreeMap::new();
    for node in document.descendants().filter(roxmltree::Node::is_element) {
        let parent = node.parent_element().and_then(|p| known.get(&p.id().get()).copied());
        let span = node.range();
        let tag = node.tag_name().name().to_owned();
        let name = text[span.start + 1..].find(|c: char| c.is_whitespace() || "/>".contains(c))?;
        let attribute = |a: roxmltree::Attribute| Attribute {
            name: a.name().to_owned(),
            value: a.value().to_owned(),
            span: a.range(),
            told: a.range_value(),
        };
        let is_own = !text[span.start + 1..span.start + 1 + name].contains(':');
        let element = Element {
            is_own,
            attributes: node.attributes().map(attribute).collect(),
            children: Vec::new(),
            parent,
            named: span.start + 1 + name,
            line: newlines.partition_point(|&n| n < span.start) as u32 + 1,
            span,
            tag,
        };
        if let Some(parent) = parent {
            let index = all.len();
            all[parent].children.push(index);
        }
        known.insert(node.id().get(), all.len());
        all.push(element);
    }
    (!all.is_empty()).then_some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARM: &str = "\u{feff}<?xml version=\"1.0\"?>\r\n<robot name=\"r\">\r\n\t<!-- a -->\r\n\t<link name=\"a\">\r\n\t\t<visual/>\r\n\t</link>\r\n\t<gz:plugin/>\r\n\t<link name='b'/>\r\n</robot>";

    fn edited(of: impl Fn(&Source) -> Vec<Edit>) -> String {
        let source = Source::of(ARM).unwrap();
        source.with(&of(&source)).unwrap()
    }

    #[test]
    fn a_text_without_changes_is_the_same_whatever_was_declared_for_it() {
        assert_eq!(edited(|_| vec![]), ARM);
        let set = edited(|s| vec![s.set(s.named("link", "b").unwrap(), "name", "c")]);
        assert_eq!(set, ARM.replace("'b'", "'c'"));
        let more = edited(|s| vec![s.set(s.root(), "version", "1.1")]);
        assert_eq!(more, ARM.replace("\"r\">", "\"r\" version=\"1.1\">"));
    }

    #[test]
    fn what_is_put_in_is_indented_as_its_neighbours_are() {
        let first =
            edited(|s| vec![s.insert_first(s.named("link", "a").unwrap(), "<m>\n\t<n/>\n</m>")]);
        let due = "\t\t<m>\r\n\t\t\t<n/>\r\n\t\t</m>\r\n\t\t<visual/>";
        assert_eq!(first, ARM.replace("\t\t<visual/>", due));
        let last = edited(|s| vec![s.insert_last(s.named("link", "a").unwrap(), "<m/>")]);
        assert_eq!(last, ARM.replace("<visual/>", "<visual/>\r\n\t\t<m/>"));
        let only = edited(|s| vec![s.insert_first(s.named("link", "b").unwrap(), "<m/>")]);
        assert_eq!(only, ARM.replace("'b'/>", "'b'>\r\n\t\t<m/>\r\n\t</link>"));
        let source = Source::of("<robot><link name='a'><x/></link></robot>").unwrap();
        let at = source.named("link", "a").unwrap();
        let put = source.with(&[source.insert_first(at, "<m>\n\t<n/>\n</m>")]).unwrap();
        assert_eq!(put, "<robot><link name='a'><m><n/></m><x/></link></robot>");
    }

    #[test]
    fn what_is_taken_out_takes_its_line_along() {
        let without = edited(|s| vec![s.remove(s.named("link", "b").unwrap())]);
        assert_eq!(without, ARM.replace("\t<link name='b'/>\r\n", ""));
        let unset =
            edited(|s| s.unset(s.named("link", "b").unwrap(), "name").into_iter().collect());
        assert_eq!(unset, ARM.replace(" name='b'", ""));
    }

    #[test]
    fn changes_that_touch_are_refused_and_elements_of_macros_are_not_found() {
        let source = Source::of(ARM).unwrap();
        let link = source.named("link", "a").unwrap();
        assert_eq!(source.with(&[source.remove(link), source.set(link, "name", "x")]), None);
        let text =
            "<robot xmlns:xacro='u'><xacro:macro name='m'><link name='a'/></xacro:macro></robot>";
        let made = Source::of(text).unwrap();
        assert!(made.named("link", "a").is_none() && made.is_put_together());
        let told = Source::of("<robot name='r'><link name='a'><mass value='${m}'/></link></robot>");
        let (told, mass) = told
            .map(|s| (s.clone(), s.child(s.named("link", "a").unwrap(), "mass").unwrap()))
            .unwrap();
        assert!(told.takes_macro(&told.set(mass, "value", "1")));
        assert!(!told.takes_macro(&told.set(mass, "unit", "kg")));
    }
}
