//! From prompt points to the faces they lie on.

use std::collections::BTreeMap;

use object::weld::nearest_face;
use object::{Condition, Mesh};

use crate::articulate::Note;

/// A face that is known to belong to a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seed {
    /// The face.
    pub face: u32,
    /// Its part.
    pub part: u16,
}

/// The face nearest each prompt point, one seed per face: where two points fall on one face, the
/// first part keeps it and the second gets a note.
pub(super) fn seeds(mesh: &Mesh, condition: &Condition) -> (Vec<Seed>, Vec<Note>) {
    let (mut seeds, mut notes) = (Vec::new(), Vec::new());
    let mut taken: BTreeMap<u32, usize> = BTreeMap::new();
    let name = |p: usize| condition.tree.parts()[p].name.clone();
    for (part, prompt) in condition.prompts.iter().enumerate() {
        let Some(point) = prompt.point else { continue };
        let face = nearest_face(mesh, point).0 as u32;
        if let Some(&first) = taken.get(&face) {
            let message = format!(
                "its point lies on the same face as that of `{}`, which keeps it",
                name(first)
            );
            notes.push(Note { part: name(part), message, loss: false });
            continue;
        }
        taken.insert(face, part);
        seeds.push(Seed { face, part: part as u16 });
    }
    (seeds, notes)
}
