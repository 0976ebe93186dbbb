//! From prompt points to the faces they lie on.

use std::collections::BTreeMap;

use object::condition::Prompt;
use object::weld::{nearest_face, nearest_faces};
use object::{Condition, DVec3, Mesh};

use crate::articulate::Note;

/// A point lies on every face that is farther from it than the nearest by no more than this share
/// of the diagonal.
const LEVEL: f64 = 2e-5;

/// A face that is known to belong to a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Seed {
    /// The face.
    pub face: u32,
    /// Its part.
    pub part: u16,
}

/// The face each prompt point lies on, one seed per face: where two points fall on one face, the
/// first part keeps it and the second gets a note. Where several points fall on one thing, a point
/// that lies on another as well, which nobody else speaks of, means that one, and the smallest of
/// several; but the base's means what the others lie on. Further points of a part, and one amid the faces that
/// were painted as its own, come after all first ones. `thing_of` gives the number of a face's thing and its
/// size.
pub(crate) fn seeds(
    mesh: &Mesh,
    condition: &Condition,
    thing_of: impl Fn(usize) -> (u32, f64),
) -> (Vec<Seed>, Vec<Note>) {
    let slack = LEVEL * mesh.bounds().diagonal();
    let spots: Vec<Spot> = (0..condition.prompts.len())
        .filter_map(|part| {
            let point = condition.prompts[part].point?;
            let faces = nearest_faces(mesh, point, slack);
            let size = |f: &usize| thing_of(*f).1;
            let nearest = if part == condition.tree.root() {
                faces.iter().copied().max_by(|a, b| size(a).total_cmp(&size(b)))?
            } else {
                nearest_face(mesh, point).0
            };
            Some(Spot { part, nearest, faces })
        })
        .collect();
    let mut spoken: BTreeMap<u32, usize> = BTreeMap::new();
    spots.iter().for_each(|s| *spoken.entry(thing_of(s.nearest).0).or_default() += 1);
    let (mut seeds, mut notes) = (Vec::new(), Vec::new());
    let mut taken: BTreeMap<usize, usize> = BTreeMap::new();
    let name = |p: usize| condition.tree.parts()[p].name.clone();
    for spot in &spots {
        let part = spot.part;
        let is_base = part == condition.tree.root();
        let face = if is_base { spot.nearest } else { spot.meant(&thing_of, &spoken) };
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
    for (part, prompt) in condition.prompts.iter().enumerate() {
        let also = prompt.also.iter().map(|&point| nearest_face(mesh, point).0);
        for face in also.chain(amid(mesh, prompt)) {
            match taken.insert(face, part) {
                None => seeds.push(Seed { face: face as u32, part: part as u16 }),
                Some(first) => {
                    taken.insert(face, first);
                    let message = format!(
                        "one of its points lies on the same face as one of `{}`, which keeps it",
                        name(first)
                    );
                    let note = Note { part: name(part), message, loss: false };
                    notes.extend((first != part).then_some(note));
                }
            }
        }
    }
    (seeds, notes)
}

/// The face amid those that were painted as a part's: the one whose centre is nearest to that of all.
fn amid(mesh: &Mesh, prompt: &Prompt) -> Option<usize> {
    let faces = || prompt.faces.iter().map(|face| face as usize);
    let area: f64 = faces().map(|face| mesh.area(face)).sum();
    let sum: DVec3 = faces().map(|face| mesh.centroid(face) * mesh.area(face)).sum();
    let centre = sum / area.max(f64::MIN_POSITIVE);
    let off = |face: &usize| mesh.centroid(*face).distance_squared(centre);
    faces().min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// Where a prompt points.
struct Spot {
    part: usize,
    /// The nearest face; for the base, of those there the one of the largest thing.
    nearest: usize,
    /// All faces there.
    faces: Vec<usize>,
}

impl Spot {
    /// The face that is meant; `spoken` counts the prompts nearest each thing.
    fn meant(
        &self,
        thing_of: impl Fn(usize) -> (u32, f64),
        spoken: &BTreeMap<u32, usize>,
    ) -> usize {
        if spoken.get(&thing_of(self.nearest).0).is_none_or(|&prompts| prompts < 2) {
            return self.nearest;
        }
        let free = self.faces.iter().copied().filter(|&f| !spoken.contains_key(&thing_of(f).0));
        let size = |f: usize| thing_of(f).1;
        free.min_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(self.nearest)
    }
}
