//! Which part each face belongs to, from the prompts and the shape alone.
//!
//! The surface is cut into pieces: its connected components, and smooth patches where one component
//! holds several prompts. Pieces are linked by contact and by seams, each link with the evidence
//! that both sides are one part. Seeded merging then spreads the prompts' labels along the best
//! links; what the words say about a part's size holds back a button that would swallow a cabinet.

mod assign;
mod candidates;
mod contact;
mod cues;
mod evidence;
mod flood;
mod islands;
mod lexicon;
mod looks;
mod merge;
mod patches;
mod pieces;
mod placed;
mod reach;
mod repeats;
mod seeds;
mod spatial;
mod twins;
mod units;

use object::weld::Weld;
use object::{Condition, Mesh};

use crate::articulate::Note;
use lexicon::SizePrior;

/// A part for each face, and what was noticed on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    /// For each face, the index of its part in the condition's tree.
    pub part_of_face: Vec<u16>,
    /// Losses and doubts, in order of part.
    pub notes: Vec<Note>,
}

/// Labels every face with a part of the condition's tree.
///
/// A face that a prompt point lies on gets that prompt's part. A part without a point is placed
/// where its shape repeats that of a prompted part with the same words, or else where something
/// fits its words, and a note says so; a part that nothing fits stays empty, with a
/// note. A base without a point gets what nobody else claims.
pub fn label_faces(mesh: &Mesh, condition: &Condition, weld: &Weld) -> Labels {
    let (component, bodies) = contact::bodies(mesh, weld);
    let thing_of = |face: usize| (component[face], bodies[component[face] as usize].area);
    let (mut seeds, mut notes) = seeds::seeds(mesh, condition, thing_of);
    let (repeated, doubts) = repeats::place(condition, &component, &bodies, &seeds);
    seeds.extend(repeated);
    notes.extend(doubts);
    placed::add(mesh, weld, condition, (&component, &bodies), (&mut seeds, &mut notes));
    let root = condition.tree.root() as u16;
    let cut = pieces::cut(mesh, weld, &component, &seeds, root);
    let diagonal = mesh.bounds().diagonal();
    let touches = contact::touches(&bodies, &cut.of_face, diagonal);
    let mut links = evidence::of_contacts(&touches, &cut.pieces, diagonal);
    links.extend(evidence::of_seams(&cut.seams, &cut.pieces, diagonal));
    let priors = size_priors(condition);
    let far = reach::far(&cut.pieces, &links, priors.len());
    let groups = merge::label(&cut.pieces, &links, &priors, far);
    let mut part_of_face = islands::settle(mesh, &cut.of_face, &groups, (&priors, root));
    twins::even_out(&mut part_of_face, condition, &component, &bodies, &seeds);
    let place = |n: &Note| condition.tree.parts().iter().position(|p| p.name == n.part);
    notes.sort_by_key(place);
    Labels { part_of_face, notes }
}

fn size_priors(condition: &Condition) -> Vec<SizePrior> {
    let root = condition.tree.root();
    (0..condition.tree.len()).map(|p| SizePrior::of(condition.text(p), p == root)).collect()
}

#[cfg(test)]
mod tests;
