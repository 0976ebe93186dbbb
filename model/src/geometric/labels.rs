//! Which part each face belongs to, from the prompts and the shape alone.
//!
//! The surface is cut into pieces: its connected components, and smooth patches where one component
//! holds several prompts. Pieces are linked by contact and by seams, each link with the evidence
//! that both sides are one part. Seeded merging then spreads the prompts' labels along the best
//! links; what the words say about a part's size holds back a button that would swallow a cabinet.
//! On a skin, where components tell nothing, more is asked of each piece and part (see [`appeal`]).
//! Fitted models may then say what becomes of each piece, from what merging says and all that is
//! measured (see [`belonging`]); skins are then cut in several ways, another panel is asked about each,
//! and what is believed is averaged where cuts overlap; parts of one kind are then of one size.

pub mod appeal;
mod assign;
pub mod belonging;
mod candidates;
mod contact;
mod cues;
pub mod evidence;
mod fellows;
mod flood;
mod islands;
pub mod lexicon;
pub mod looks;
mod merge;
mod overlay;
mod patches;
mod pieces;
mod placed;
mod reach;
mod repeats;
mod seeds;
mod sheets;
mod spatial;
mod twins;
mod units;

use std::collections::BTreeMap;

use object::weld::Weld;
use object::{Condition, Mesh};
use rayon::prelude::*;

use super::pack::PackError;
use crate::articulate::Note;
use appeal::Skin;
use belonging::{Asked, Beliefs, Known, Layout, strays};
use contact::{Body, Touch};
use lexicon::SizePrior;
use merge::{Group, Habits, Link};
use overlay::{Surface, Told};
use patches::Cutting;
use pieces::Cut;
use seeds::Seed;
pub use sheets::{Contact, ContactSheet, RolePart, RoleSheet, contact_sheet, role_sheet};

/// How clusters grow among components.
const AMONG_COMPONENTS: Habits = Habits { patience: 0.3, nearness: 0.7, size: 1.0 };
/// How clusters grow on a skin: what speaks for a part counts for more, and holds sizes already.
const ON_SKINS: Habits = Habits { patience: 0.0, nearness: 2.0, size: 0.5 };
/// An object is a skin if this share of its surface is in components with several prompts, as of what
/// a generator delivers, what is the base's alone left out; of anything less, the other components still
/// tell much.
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
    /// One of their first voices alone, by number, counted on from the first after the last: what comes
    /// after labels is fitted to what it says of objects that it was not grown on.
    Blind(usize),
}

/// Refuses packs that this program cannot read.
///
/// # Errors
/// [`PackError`].
pub(super) fn check() -> Result<(), PackError> {
    belonging::check()?;
    looks::check()?;
    evidence::check()?;
    lexicon::check()?;
    appeal::check()
}

/// The names and the digests of the packs that labels follow from.
pub(super) fn digests() -> Vec<(&'static str, String)> {
    let single = [looks::digest_of_pack(), evidence::digest_of_pack(), lexicon::digest_of_pack()];
    let single = single.into_iter().chain([appeal::digest_of_pack()]);
    belonging::digests_of_packs().into_iter().chain(single).collect()
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
    let layout = (!is_merged).then(|| start.layout(&start.view, mesh, condition));
    let found = |&way: &Way| {
        let mut part_of_face = match (way, &layout) {
            (Way::Merging, _) | (_, None) => start.merged(mesh, condition),
            (Way::Fitted, Some(layout)) if start.is_skin(condition.tree.root() as u16) => {
                start.asked_of_all((mesh, weld), condition, layout.clone())
            }
            (Way::Fitted, Some(layout)) => start.asked(layout.clone(), condition, Asked::Panel(0)),
            (Way::Blind(voice), Some(layout)) => {
                start.asked(layout.clone(), condition, Asked::Voice(voice))
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
    priors: Vec<SizePrior>,
    /// The surface as it usually is cut.
    view: View,
    /// How much of the surface is one skin over several parts, 0 to 1 ([`pieces::fused`]).
    fused: f64,
}

/// The surface cut in one way.
struct View {
    cut: Cut,
    links: Vec<Link>,
    touches: BTreeMap<(u32, u32), Touch>,
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
        let root = condition.tree.root() as u16;
        let view = View::of((mesh, weld), (&component, &bodies), (&seeds, root), Cutting::USUAL);
        let fused = pieces::fused(mesh, &component, (&seeds, root));
        let priors = size_priors(condition);
        Self { component, bodies, seeds, notes, priors, view, fused }
    }

    /// Whether most of the surface is one skin over several parts, the base with a prompt among them.
    fn is_skin(&self, root: u16) -> bool {
        self.fused > SKIN && self.seeds.iter().any(|s| s.part == root)
    }

    fn skin<'a>(&'a self, view: &'a View, mesh: &'a Mesh, condition: &'a Condition) -> Skin<'a> {
        let (View { cut, links, .. }, Self { seeds, priors, .. }) = (view, self);
        Skin { mesh, condition, cut, links, seeds, priors }
    }

    /// Labels by merging.
    fn merged(&self, mesh: &Mesh, condition: &Condition) -> Vec<u16> {
        let groups = self.groups(&self.view, mesh, condition);
        let root = condition.tree.root() as u16;
        islands::settle(mesh, &self.view.cut.of_face, &groups, (&self.priors, root))
    }

    fn groups(&self, view: &View, mesh: &Mesh, condition: &Condition) -> Vec<Group> {
        let root = condition.tree.root() as u16;
        let (View { cut, links, .. }, Self { priors, .. }) = (view, self);
        let growth = if self.is_skin(root) {
            (appeal::against(&self.skin(view, mesh, condition)), ON_SKINS)
        } else {
            (reach::far(&cut.pieces, links, priors.len()), AMONG_COMPONENTS)
        };
        merge::label(&cut.pieces, links, priors, growth)
    }

    /// Labels by some of the fitted models.
    fn asked(&self, mut layout: Layout, condition: &Condition, asked: Asked) -> Vec<u16> {
        let is_skin = self.is_skin(condition.tree.root() as u16);
        let beliefs = belonging::believed(&mut layout, is_skin, asked);
        let part_of_piece = strays::gathered(&layout, &beliefs, is_skin);
        self.view.cut.of_face.iter().map(|&piece| part_of_piece[piece as usize]).collect()
    }

    /// Labels of a skin by the fitted models: of every way to cut it, of which `layout` is the usual one,
    /// another panel is asked.
    fn asked_of_all(
        &self,
        (mesh, weld): (&Mesh, &Weld),
        condition: &Condition,
        mut layout: Layout,
    ) -> Vec<u16> {
        let others = self.asked_of_others((mesh, weld), condition);
        let usual = belonging::believed(&mut layout, true, Asked::Panel(0));
        let all = std::iter::once((&self.view.cut.of_face, &usual));
        let all = all.chain(others.iter().map(|(of_face, beliefs)| (of_face, beliefs)));
        let told: Vec<Told> = all.map(|(of_face, beliefs)| Told { of_face, beliefs }).collect();
        overlay::labels(&Surface { mesh, condition, seeds: &self.seeds }, weld, &told)
    }

    /// The segment of each face and what is believed of each segment, for every other way to cut a skin.
    fn asked_of_others(
        &self,
        (mesh, weld): (&Mesh, &Weld),
        condition: &Condition,
    ) -> Vec<(Vec<u32>, Beliefs)> {
        let (bodies, seeds) = ((&*self.component, &*self.bodies), &*self.seeds);
        let root = condition.tree.root() as u16;
        let other = |(i, &cutting): (usize, &Cutting)| {
            let view = View::of((mesh, weld), bodies, (seeds, root), cutting);
            let mut layout = self.layout(&view, mesh, condition);
            (view.cut.of_face, belonging::believed(&mut layout, true, Asked::Panel(i + 1)))
        };
        Cutting::OTHERS.par_iter().enumerate().map(other).collect()
    }

    fn layout(&self, view: &View, mesh: &Mesh, condition: &Condition) -> Layout {
        let (View { cut, links, touches }, Self { seeds, priors, .. }) = (view, self);
        let merged: Vec<_> = self.groups(view, mesh, condition).iter().map(|g| g.label).collect();
        Layout::of(&Known { mesh, condition, cut, links, touches, seeds, merged: &merged, priors })
    }
}

impl View {
    fn of(
        (mesh, weld): (&Mesh, &Weld),
        (component, bodies): (&[u32], &[Body]),
        (seeds, root): (&[Seed], u16),
        cutting: Cutting,
    ) -> Self {
        let cut = pieces::cut((mesh, weld), component, (seeds, root), cutting);
        let diagonal = mesh.bounds().diagonal();
        let touches = contact::touches(bodies, &cut.of_face, diagonal);
        let mut links = evidence::of_contacts(&touches, &cut.pieces, diagonal);
        links.extend(evidence::of_seams(&cut.seams, &cut.pieces, diagonal));
        Self { cut, links, touches }
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
    let numbers = appeal::numbers(&start.skin(&start.view, mesh, condition));
    let share = start.view.cut.pieces.iter().map(|p| p.share).collect();
    let is_skin = start.is_skin(condition.tree.root() as u16);
    is_skin.then_some(Sheet { piece_of_face: start.view.cut.of_face, share, numbers })
}

/// The piece of each face, and the layout of all pieces.
pub fn layout(mesh: &Mesh, condition: &Condition, weld: &Weld) -> (Vec<u32>, Layout) {
    let start = Start::of(mesh, condition, weld);
    let layout = start.layout(&start.view, mesh, condition);
    (start.view.cut.of_face, layout)
}

fn size_priors(condition: &Condition) -> Vec<SizePrior> {
    let root = condition.tree.root();
    (0..condition.tree.len()).map(|p| SizePrior::of(condition.text(p), p == root)).collect()
}

#[cfg(test)]
pub(super) mod golden;
#[cfg(test)]
mod tests;
