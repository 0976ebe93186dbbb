//! Elements of COLLADA: children by name, numbers, and what is wrong with them.

use object::mesh::MeshError;
use roxmltree::Node;

/// Why bytes are not a COLLADA surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DaeError {
    /// No text, no XML, or XML beyond a cap.
    #[error("{0}")]
    Text(String),
    /// An element that breaks a rule, or is of a kind that is not read.
    #[error("`{element}`: {rule}")]
    Element {
        /// Its name.
        element: String,
        /// The rule, and what was found.
        rule: String,
    },
    /// Triangles that are not a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl DaeError {
    pub(super) fn at(node: Node, rule: impl Into<String>) -> Self {
        Self::Element { element: node.tag_name().name().to_owned(), rule: rule.into() }
    }
}

/// The first child element of that name, whatever its namespace.
pub(super) fn child<'d>(node: Node<'d, 'd>, name: &str) -> Option<Node<'d, 'd>> {
    children(node).find(|n| n.tag_name().name() == name)
}

pub(super) fn children<'d>(node: Node<'d, 'd>) -> impl Iterator<Item = Node<'d, 'd>> {
    node.children().filter(Node::is_element)
}

/// The numbers of an element's text.
pub(super) fn numbers(node: Node) -> Result<Vec<f64>, DaeError> {
    let parse = |word: &str| word.parse::<f64>().ok().filter(|v| v.is_finite());
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    let found: Option<Vec<f64>> = words.map(parse).collect();
    found.ok_or_else(|| DaeError::at(node, "expected finite numbers"))
}
