//! A `<robot>` element → links and joints: `urdf-rs` reads the numbers, our own pass says what is wrong
//! and where.
//!
//! The pass goes first, over a document whose bytes, depth and attributes are counted. Where it finds
//! a fault in text, references or types, there is no robot to read. Else `urdf-rs` gets a copy of
//! what the file says without what it stumbles over, and nothing else of the stranger's text.

mod copy;
mod paint;
mod pass;
mod typed;

use roxmltree::Node;

use crate::read::draft::Draft;
use crate::read::xml::Reader;

impl Reader<'_> {
    /// Reads a `<robot>` element.
    pub(crate) fn robot<'d>(&mut self, root: Node<'d, 'd>, draft: &mut Draft) {
        self.outline(root, draft);
        let faults = [&self.faults.text, &self.faults.references, &self.faults.types];
        if faults.iter().any(|found| !found.is_empty()) {
            return;
        }
        let read = urdf_rs::read_from_string(&copy::of(root)).map_err(|e| e.to_string());
        if let Err(why) = read.and_then(|robot| typed::fill(draft, &robot)) {
            self.fault(root, format!("urdf-rs does not read it: {why}"));
        }
    }
}

#[cfg(test)]
mod tests;
