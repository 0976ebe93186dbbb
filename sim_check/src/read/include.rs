//! An MJCF model that stands in several files: what `<include>` names is put in its place.

use std::sync::Arc;

use crate::read::draft::Faults;
use crate::read::element::{self, Element};
use crate::read::meshes::Shelf;
use crate::read::xml::shown;

/// Deepest nesting of files, and most files of one model.
const DEEPEST: usize = 16;
const MOST: usize = 256;

/// The model with everything it includes; files that could not be had are listed.
pub(crate) fn together(
    root: &Arc<Element>,
    shelf: &mut Shelf,
    faults: &mut Faults,
) -> Arc<Element> {
    let mut files = 0;
    let mut work = Work { shelf, faults, files: &mut files };
    Arc::new(work.element(root, "", 0))
}

/// An attribute of our own on a mesh that an included file names: the folder of that file.
pub(crate) const INCLUDED_FROM: &str = "kinfold-included-from";

struct Work<'w> {
    shelf: &'w mut Shelf,
    faults: &'w mut Faults,
    files: &'w mut usize,
}

impl Work<'_> {
    /// `folder`: that of the file the element stands in, with its slash.
    fn element(&mut self, of: &Element, folder: &str, depth: usize) -> Element {
        let mut made = Element { children: Vec::new(), ..of.clone() };
        made.attributes.retain(|(name, _)| name != INCLUDED_FROM);
        if depth > 0 && of.name == "mesh" && of.get("file").is_some() {
            made.attributes.push((INCLUDED_FROM.to_owned(), folder.to_owned()));
        }
        for child in &of.children {
            if child.name == "include" {
                made.children.extend(self.file(child, folder, depth));
            } else {
                made.children.push(Arc::new(self.element(child, folder, depth)));
            }
        }
        made
    }

    fn file(&mut self, of: &Element, folder: &str, depth: usize) -> Vec<Arc<Element>> {
        let name = of.get("file").unwrap_or_default().trim().to_owned();
        *self.files += 1;
        if depth >= DEEPEST || *self.files > MOST {
            let rule = format!("files nest at most {DEEPEST} deep, {MOST} in all");
            self.faults.text.push(format!("line {}: `include`: {rule}", of.line));
            return Vec::new();
        }
        // Named from the model's own folder; some name them from the folder of the file they stand in.
        let beside = format!("{folder}{name}");
        let text = self.shelf.text(&name).map(|text| (text, &name)).or_else(|why| {
            let found = self.shelf.text(&beside).map(|text| (text, &beside));
            found.map_err(|_| why)
        });
        let read = text.and_then(|(text, name)| {
            let folder = name.rfind('/').map_or("", |end| &name[..=end]).to_owned();
            element::read(&text, Some(of.line)).map(|root| (root, folder))
        });
        match read {
            Ok((root, folder)) => self.element(&root, &folder, depth + 1).children,
            Err(why) => {
                let line = of.line;
                self.faults
                    .files
                    .push(format!("line {line}: include of `{}`: {why}", shown(&name)));
                // What is not there may be anything: the rest is judged without it, and unknown.
                vec![Arc::new(of.clone())]
            }
        }
    }
}
