//! Which part each face belongs to, from the prompts and the shape alone.
//!
//! The surface is cut into pieces: its connected components, and smooth patches where one component
//! holds several prompts. Pieces are linked by contact and by seams, each link with the evidence
//! that both sides are one part. Seeded merging then spreads the prompts' labels along the best
//! links; what the words say about a part's size holds back a button that would swallow a cabinet.
//! On a skin, where components tell nothing, more is asked of each piece and part (see [`appeal`]).
//! Fitted models may then say what becomes of each piece, from what merging says and all that is
//! measured (see [`belonging`]).

pub mod appeal;
mod assign;
pub mod belonging;
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

use std::collections::BTreeMap;

use object::weld::Weld;
use object::{Condition, Mesh};
use rayon::prelude::*;

use crate::articulate::Note;
use appeal::Skin;
use belonging::{Known, Layout, strays};
use contact::{Body, Touch};
use lexicon::SizePrior;
use merge::{Group, Habits, Link};
use pieces::Cut;
use seeds::Seed;

/// How clusters grow among components.
const AMONG_COMPONENTS: Habits = Habits { patience: 0.3, nearness: 0.7, size: 1.0 };
/// How clusters grow on a skin: what speaks for a part counts for more, and holds sizes already.
const ON_SKINS: Habits = Habits { patience: 0.0, nearness: 2.0, size: 0.5 };
/// An object is a skin if this share of its surface is in components with several prompts, as of what
/// a generator delivers; of anything less, the other components still tell much.
const SKIN: f64 = 0.95;

/// A part for each face, and what was noticed on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    /// For each face, the index of its part in the condition's tree.
    pub part_of_face: Vec<u16>,
    /// Losses and doubts, in order of part.
    pub notes: Vec<Note>,
}

/// Who decides which part a piece belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Evidence between pieces, nearness and sizes: seeded merging.
    Merging,
    /// The fitted models of [`belonging`], which start from what merging says.
    Fitted,
    /// One voice of them alone, by number, counted on from the first after the last: what comes after
    /// labels is fitted to what it says of objects that it was not grown on.
    Blind(usize),
}

/// Labels every face with a part of the condition's tree.
///
/// A face that a prompt point lies on gets that prompt's part. A part without a point is placed
/// where its shape repeats that of a prompted part with the same words, or else where something
/// fits its words, and a note says so; a part that nothing fits stays empty, with a
/// note. A base without a point gets what nobody else claims.
pub fn label_faces(mesh: &Mesh, condition: &Condition, weld: &Weld, way: Way) -> Labels {
    labellings(mesh, condition, weld, (way, &[])).0
}

/// Labels in one way, and what other ways make of the same pieces: the part of each face, way by way.
pub fn labellings(
    mesh: &Mesh,
    condition: &Condition,
    weld: &Weld,
    (way, others): (Way, &[Way]),
) -> (Labels, Vec<Vec<u16>>) {
    let mut start = Start::of(mesh, condition, weld);
    let place = |n: &Note| condition.tree.parts().iter().position(|p| p.name == n.part);
    start.notes.sort_by_key(place);
    let is_merged = way == Way::Merging && others.iter().all(|o| *o == Way::Merging);
    let layout = (!is_merged).then(|| start.layout(mesh, condition));
    let found = |&way: &Way| {
        let mut part_of_face = match (way, &layout) {
            (Way::Merging, _) | (_, None) => start.merged(mesh, condition),
            (Way::Fitted, Some(layout)) => start.asked(layout.clone(), condition, None),
            (Way::Blind(voice), Some(layout)) => {
                start.asked(layout.clone(), condition, Some(voice))
            }
        };
        let Start { component, bodies, seeds, .. } = &start;
        twins::even_out(&mut part_of_face, condition, component, bodies, seeds);
        part_of_face
    };
    let (part_of_face, others) = (found(&way), others.par_iter().map(found).collect());
    (Labels { part_of_face, notes: start.notes }, others)
}

/// What is known before labels spread.
struct Start {
    component: Vec<u32>,
    bodies: Vec<Body>,
    seeds: Vec<Seed>,
    notes: Vec<Note>,
    cut: Cut,
    links: Vec<Link>,
    touches: BTreeMap<(u32, u32), Touch>,
    priors: Vec<SizePrior>,
}

impl Start {
    fn of(mesh: &Mesh, condition: &Condition, weld: &Weld) -> Self {
        let (component, bodies) = contact::bodies(mesh, weld);
        let thing_of = |face: usize| (component[face], bodies[component[face] as usize].area);
        let (mut seeds, mut notes) = seeds::seeds(mesh, condition, thing_of);
        let (repeated, doubts) = repeats::place(condition, &component, &bodies, &seeds);
        seeds.extend(repeated);
        notes.extend(doubts);
        placed::add(mesh, weld, condition, (&component, &bodies), (&mut seeds, &mut notes));
        let cut = pieces::cut(mesh, weld, &component, &seeds, condition.tree.root() as u16);
        let diagonal = mesh.bounds().diagonal();
        let touches = contact::touches(&bodies, &cut.of_face, diagonal);
        let mut links = evidence::of_contacts(&touches, &cut.pieces, diagonal);
        links.extend(evidence::of_seams(&cut.seams, &cut.pieces, diagonal));
        let priors = size_priors(condition);
        Self { component, bodies, seeds, notes, cut, links, touches, priors }
    }

    /// Whether most of the surface is one skin over several parts, the base with a prompt among them.
    fn is_skin(&self, root: u16) -> bool {
        self.cut.fused > SKIN && self.seeds.iter().any(|s| s.part == root)
    }

    fn skin<'a>(&'a self, mesh: &'a Mesh, condition: &'a Condition) -> Skin<'a> {
        let Self { cut, links, seeds, priors, .. } = self;
        Skin { mesh, condition, cut, links, seeds, priors }
    }

    /// Labels by merging.
    fn merged(&self, mesh: &Mesh, condition: &Condition) -> Vec<u16> {
        let groups = self.groups(mesh, condition);
        let root = condition.tree.root() as u16;
        islands::settle(mesh, &self.cut.of_face, &groups, (&self.priors, root))
    }

    fn groups(&self, mesh: &Mesh, condition: &Condition) -> Vec<Group> {
        let root = condition.tree.root() as u16;
        let Self { cut, links, priors, .. } = self;
        let growth = if self.is_skin(root) {
            (appeal::against(&self.skin(mesh, condition)), ON_SKINS)
        } else {
            (reach::far(&cut.pieces, links, priors.len()), AMONG_COMPONENTS)
        };
        merge::label(&cut.pieces, links, priors, growth)
    }

    /// Labels by the fitted models, or by one voice of them.
    fn asked(&self, mut layout: Layout, condition: &Condition, voice: Option<usize>) -> Vec<u16> {
        let is_skin = self.is_skin(condition.tree.root() as u16);
        let beliefs = belonging::believed(&mut layout, is_skin, voice);
        let part_of_piece = strays::gathered(&layout, &beliefs, is_skin);
        self.cut.of_face.iter().map(|&piece| part_of_piece[piece as usize]).collect()
    }

    fn layout(&self, mesh: &Mesh, condition: &Condition) -> Layout {
        let Self { cut, links, touches, seeds, priors, .. } = self;
        let merged: Vec<_> = self.groups(mesh, condition).iter().map(|g| g.label).collect();
        Layout::of(&Known { mesh, condition, cut, links, touches, seeds, merged: &merged, priors })
    }
}

/// What is known of the pieces of a skin before labels spread: what weights are fitted on.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// The piece of each face.
    pub piece_of_face: Vec<u32>,
    /// For each piece, its share of the surface, 0 to 1.
    pub share: Vec<f64>,
    /// For each piece and part, what is known of the two; nothing of a part without a prompt.
    pub numbers: Vec<Vec<Option<appeal::Numbers>>>,
}

/// The sheet of an object; nothing where it is no skin.
pub fn sheet(mesh: &Mesh, condition: &Condition, weld: &Weld) -> Option<Sheet> {
    let start = Start::of(mesh, condition, weld);
    let numbers = appeal::numbers(&start.skin(mesh, condition));
    let share = start.cut.pieces.iter().map(|p| p.share).collect();
    let is_skin = start.is_skin(condition.tree.root() as u16);
    is_skin.then_some(Sheet { piece_of_face: start.cut.of_face, share, numbers })
}

/// The piece of each face, and the layout of all pieces.
pub fn layout(mesh: &Mesh, condition: &Condition, weld: &Weld) -> (Vec<u32>, Layout) {
    let start = Start::of(mesh, condition, weld);
    let layout = start.layout(mesh, condition);
    (start.cut.of_face, layout)
}

fn size_priors(condition: &Condition) -> Vec<SizePrior> {
    let root = condition.tree.root();
    (0..condition.tree.len()).map(|p| SizePrior::of(condition.text(p), p == root)).collect()
}

#[cfg(test)]
mod tests;
