//! xacro expanded: properties, arguments, macros with blocks and defaults, conditions, includes and
//! arithmetic. Nothing of Python is run; what is not known here is said and left as it stands.
//!
//! `$(find NAME)` becomes an address of that package, `$(env NAME)` has a value only for names that
//! the caller gives.

mod expand;
mod formula;
mod macros;
mod substitute;
#[cfg(test)]
mod tests;
pub(crate) mod value;

use std::sync::Arc;

use crate::read::element::Element;
use crate::read::meshes::Shelf;

/// A model without macros, and what was wrong on the way.
pub(crate) struct Expanded {
    pub root: Arc<Element>,
    /// What breaks one element, each with its line.
    pub faults: Vec<String>,
    /// Files that could not be had, each with its line.
    pub files: Vec<String>,
}

/// Whether a text may hold macros or substitutions.
pub(crate) fn is_wanted(text: &str) -> bool {
    text.contains("xacro") || text.contains("${") || text.contains("$(")
}

/// Expands a model.
pub(crate) fn expand(root: &Arc<Element>, shelf: &mut Shelf) -> Expanded {
    let mut machine = expand::Machine::new(shelf);
    let expanded = machine.root(root);
    Expanded { root: Arc::new(expanded), faults: machine.faults, files: machine.files }
}
