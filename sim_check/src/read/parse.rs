//! Text → draft: a URDF by one door, an MJCF model by the other.

use roxmltree::{Document, ParsingOptions};

use crate::read::draft::Draft;
use crate::read::meshes::Shelf;
use crate::read::xml::Reader;
use crate::read::{caps, mjcf};
use crate::robot::Format;

/// Most XML nodes a URDF may have.
pub const MAX_NODES: u32 = 1_000_000;
/// Reads the text of a URDF or an MJCF model; meshes come from the shelf.
pub(crate) fn read(text: &str, shelf: &mut Shelf) -> Draft {
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let mut draft = Draft::default();
    if let Some(rule) = caps::broken(text) {
        draft.faults.text.push(rule);
        return draft;
    }
    let document = match Document::parse_with_options(text, options) {
        Ok(document) => document,
        Err(e) => {
            draft.faults.text.push(format!("not XML: {e}"));
            return draft;
        }
    };
    let mut reader = Reader::new(text, shelf);
    let root = document.root_element();
    match root.tag_name().name() {
        "robot" => reader.robot(root, &mut draft),
        "mujoco" => {
            draft.format = Format::Mjcf;
            mjcf::model(&mut reader, root, &mut draft);
        }
        found => {
            reader.fault(
                root,
                format!("the root element must be `robot` or `mujoco`, found `{found}`"),
            );
        }
    }
    draft.faults = reader.faults;
    draft
}
