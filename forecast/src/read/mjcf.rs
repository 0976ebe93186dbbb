//! An MJCF model as the rules see it: its elements, with the defaults that reach them.

use crate::read::tree::{Element, Tree};

/// An MJCF model.
#[derive(Clone, Debug, Default)]
pub struct Mjcf {
    tree: Tree,
}

impl Mjcf {
    pub(crate) fn new(tree: Tree) -> Self {
        Self { tree }
    }

    /// All elements, in the order of the file.
    pub(crate) fn elements(&self) -> impl Iterator<Item = &Element> {
        self.tree.elements.iter()
    }

    /// The children of an element.
    pub(crate) fn children<'m>(&'m self, of: &'m Element) -> impl Iterator<Item = &'m Element> {
        self.tree.children(of)
    }

    /// What `<compiler>` says; the last one that says it counts.
    pub(crate) fn compiler(&self, attribute: &str) -> Option<&str> {
        let compilers = self.elements().filter(|e| e.tag == "compiler");
        compilers.filter_map(|e| e.get(attribute)).last()
    }

    /// Whether another file is included or attached: then much may be said there.
    pub(crate) fn is_part(&self) -> bool {
        self.elements().any(|e| matches!(e.tag.as_str(), "include" | "attach" | "replicate"))
    }

    /// The elements of these tags that stand in the world's bodies, not in defaults.
    pub(crate) fn placed<'m>(&'m self, tag: &'m str) -> impl Iterator<Item = &'m Element> {
        self.elements().filter(move |e| e.tag == tag && !self.is_default(e))
    }

    fn is_default(&self, element: &Element) -> bool {
        element.parent.and_then(|p| self.tree.elements.get(p)).is_some_and(|p| p.tag == "default")
    }

    /// Whether any default says this of a tag: then what an element does not say is not known here.
    pub(crate) fn is_defaulted(&self, tag: &str, attributes: &[&str]) -> bool {
        let mut defaults = self.elements().filter(|e| e.tag == tag && self.is_default(e));
        defaults.any(|e| attributes.iter().any(|a| e.get(a).is_some()))
    }
}
