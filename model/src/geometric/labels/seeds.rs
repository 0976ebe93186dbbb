//! From prompt points to the faces they lie on.

use std::collections::BTreeMap;

use object::weld::nearest_faces;
use object::{Condition, Mesh};

use crate::articulate::Note;

/// A point lies on every face that is farther from it than the nearest by no more than this share
/// of the diagonal.
const LEVEL: f64 = 2e-5;

/// A face that is known to belong to a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seed {
    /// The face.
    pub face: u32,
    /// Its part.
    pub part: u16,
}

/// The face each prompt point lies on, one seed per face: where two points fall on one face, the
/// first part keeps it and the second gets a note. Where surfaces lie on one another, a point on
/// both speaks of the smaller thing, the base's of the larger; `size_of` is that of a face's thing.
pub(super) fn seeds(
    mesh: &Mesh,
    condition: &Condition,
    size_of: impl Fn(usize) -> f64,
) -> (Vec<Seed>, Vec<Note>) {
    let (mut seeds, mut notes) = (Vec::new(), Vec::new());
    let mut taken: BTreeMap<usize, usize> = BTreeMap::new();
    let name = |p: usize| condition.tree.parts()[p].name.clone();
    let slack = LEVEL * mesh.bounds().diagonal();
    for (part, prompt) in condition.prompts.iter().enumerate() {
        let Some(point) = prompt.point else { continue };
        let sign = if part == condition.tree.root() { -1.0 } else { 1.0 };
        let under: Vec<usize> = nearest_faces(mesh, point, slack);
        let best = under.iter().copied().min_by(|&a, &b| {
            let rank = |f: usize| (taken.contains_key(&f), sign * size_of(f));
            rank(a).0.cmp(&rank(b).0).then(rank(a).1.total_cmp(&rank(b).1))
        });
        let Some(face) = best else { continue };
        if let Some(&first) = taken.get(&face) {
            let message = format!(
                "its point lies on the same face as that of `{}`, which keeps it",
                name(first)
            );
            notes.push(Note { part: name(part), message, loss: false });
            continue;
        }
        taken.insert(face, part);
        seeds.push(Seed { face: face as u32, part: part as u16 });
    }
    (seeds, notes)
}
