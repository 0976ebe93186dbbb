//! Text → draft: URDF, MJCF and SDFormat, each by its own door. What stands in several files, or is
//! made by macros, is put together first.

use roxmltree::{Document, ParsingOptions};

use crate::read::caps::MAX_NODES;
use crate::read::draft::{Draft, Faults};
use crate::read::meshes::Shelf;
use crate::read::xml::Reader;
use crate::read::{caps, element, include, mjcf, sdf, xacro};
use crate::robot::Format;

/// Reads the text of a URDF, a xacro, an MJCF or an SDFormat model; other files come from the shelf.
pub(crate) fn read(text: &str, shelf: &mut Shelf) -> Draft {
    let mut faults = Faults::default();
    let declared = declared(text, &mut faults).map(|(text, _)| text);
    let text = declared.as_deref().unwrap_or(text);
    let whole = together(text, shelf, &mut faults);
    let mut draft = of_one(whole.as_deref().unwrap_or(text), shelf);
    draft.faults.text.extend(faults.text);
    draft.faults.numbers.extend(faults.numbers);
    draft.faults.files.extend(faults.files);
    draft.faults.flags.extend(faults.flags);
    draft
}

/// The text with prefixes declared that it uses and declares nowhere, and where that was put in: most
/// programs pass them over.
pub(crate) fn declared(text: &str, faults: &mut Faults) -> Option<(String, usize)> {
    let mut made: Option<(String, usize)> = None;
    for _ in 0..MOST_PREFIXES {
        let now = made.as_ref().map_or(text, |(made, _)| made);
        if caps::broken(now).is_some() {
            return None;
        }
        let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
        let Err(roxmltree::Error::UnknownNamespace(prefix, at)) =
            Document::parse_with_options(now, options)
        else {
            return made;
        };
        faults.flags.push(format!("line {}: the prefix `{prefix}` is declared nowhere", at.row));
        let root =
            ["<robot", "<mujoco", "<sdf"].into_iter().find_map(|r| Some(now.find(r)? + r.len()))?;
        let with = format!("{} xmlns:{prefix}=\"urn:{prefix}\"{}", &now[..root], &now[root..]);
        made = Some((with, root));
    }
    made
}

/// Most prefixes that are declared for a file.
const MOST_PREFIXES: usize = 8;

/// The text of a model that is told in several files or by macros; `None` where it is not, or cannot
/// be put together.
fn together(text: &str, shelf: &mut Shelf, faults: &mut Faults) -> Option<String> {
    if !xacro::is_wanted(text) && !text.contains("<include") {
        return None;
    }
    let root = element::read(text, None).ok()?;
    let root = match root.name.as_str() {
        "robot" if xacro::is_wanted(text) => {
            let made = xacro::expand(&root, shelf);
            faults.numbers.extend(made.faults);
            faults.files.extend(made.files);
            made.root
        }
        "mujoco" if text.contains("<include") => include::together(&root, shelf, faults),
        _ => return None,
    };
    let whole = element::write(&root);
    if whole.is_none() {
        faults.text.push("its files are too long together".into());
    }
    whole
}

fn of_one(text: &str, shelf: &mut Shelf) -> Draft {
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
    let root = document.root_element();
    if root.tag_name().name() == "sdf" {
        sdf::model(root, text, shelf, &mut draft);
        return draft;
    }
    let mut reader = Reader::new(text, shelf);
    match root.tag_name().name() {
        "robot" => reader.robot(root, &mut draft),
        "mujoco" => {
            draft.format = Format::Mjcf;
            mjcf::model(&mut reader, root, &mut draft);
        }
        found => {
            let due = "the root element must be `robot`, `mujoco` or `sdf`";
            reader.fault(root, format!("{due}, found `{found}`"));
        }
    }
    draft.faults = reader.faults;
    draft
}
