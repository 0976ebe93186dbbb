//! Which part each face belongs to, from prompts, words and shape.
//!
//! - The surface is cut into segments: its connected components, and smooth patches where one
//!   component holds several prompts.
//! - Segments are linked by contact and by seams. Each link has the evidence that both sides are of
//!   one part.
//! - Seeded merging spreads the prompts' labels along the best links. A usual size, known from the
//!   words, keeps a button from swallowing a cabinet.
//! - On a fused mesh components tell nothing, so [`grow::fused_unary`] first scores each segment
//!   for each part.
//! - Fitted models may then decide about each segment, from merging and all that is measured
//!   ([`classify`]). A fused mesh is cut in several ways for them, and another ensemble answers for
//!   each cut. Class probabilities are averaged where cuts overlap.
//! - At last labels are cleaned up ([`refine`]); on a fused mesh, parts of one kind get one size.

pub mod classify;
mod corrections;
pub mod grow;
pub mod oversegment;
pub mod prompts;
pub mod refine;
pub mod sheets;

use crate::classic::lexicon::sizes;
use crate::classic::segment::grow::{distance, evidence, fused_unary, islands, merge};
use crate::classic::segment::oversegment::{contact, segments};
use crate::classic::segment::prompts::{placed, repeats, roles, seeds};
use crate::classic::segment::refine::{copies, fusion};
use std::collections::BTreeMap;

use object::weld::Weld;
use object::{Condition, Mesh};
use rayon::prelude::*;

use crate::articulate::Note;
use crate::classic::learned::pack::PackError;
use crate::classic::lexicon::sizes::SizePrior;
use crate::classic::segment::classify::{Asked, Known, Layout, Probabilities};
use crate::classic::segment::grow::fused_unary::FusedSurface;
use crate::classic::segment::grow::merge::{Group, Habits, Link};
use crate::classic::segment::oversegment::contact::{Body, Touch};
use crate::classic::segment::oversegment::patches::Cutting;
use crate::classic::segment::oversegment::segments::Cut;
use crate::classic::segment::prompts::seeds::Seed;
use crate::classic::segment::refine::connectivity;
use crate::classic::segment::refine::fusion::Told;
use crate::classic::segment::refine::surface::Surface;
pub use crate::classic::segment::sheets::{
    Contact, ContactSheet, RolePart, RoleSheet, contact_sheet, role_sheet,
};

/// How clusters grow among components.
const AMONG_COMPONENTS: Habits = Habits { patience: 0.3, nearness: 0.7, size: 1.0 };
/// How clusters grow on a fused mesh: what speaks for a part counts for more, and holds sizes already.
const ON_FUSED: Habits = Habits { patience: 0.0, nearness: 2.0, size: 0.5 };
/// An object is a fused mesh if more than this share of its surface lies in components with several
/// prompts, as in what a generator delivers. Components with the base's prompt alone do not count.
/// Below this share, the other components still tell much.
const FUSED: f64 = 0.95;

/// A part for each face, and what was noticed on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    /// For each face, the index of its part in the condition's tree.
    pub part_of_face: Vec<u16>,
    /// Losses and doubts, in order of part.
    pub notes: Vec<Note>,
}

/// Who decides which part a segment belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Evidence between segments, nearness and sizes: seeded merging.
    Merging,
    /// The fitted models of [`crate::classic::segment::classify`], which start from what merging says.
    Fitted,
    /// One of their first folds alone, by number, counted on from the first after the last: what comes
    /// after labels is fitted to what it says of objects that it was not grown on.
    OutOfFold(usize),
}

/// Refuses packs that this program cannot read.
///
/// # Errors
/// [`PackError`].
pub(crate) fn check() -> Result<(), PackError> {
    classify::check()?;
    roles::check()?;
    evidence::check()?;
    sizes::check()?;
    fused_unary::check()
}

/// The names and the digests of the packs that labels follow from.
pub(crate) fn digests() -> Vec<(&'static str, String)> {
    let single = [roles::digest_of_pack(), evidence::digest_of_pack(), sizes::digest_of_pack()];
    let single = single.into_iter().chain([fused_unary::digest_of_pack()]);
    classify::digests_of_packs().into_iter().chain(single).collect()
}

/// Labels every face with a part of the condition's tree.
///
/// A face that a prompt point lies on gets that prompt's part, and what was painted is as it was painted;
/// a point that is not of a part belongs to the likeliest other one. A part without a point is placed
/// where its shape repeats that of a prompted part with the same words, or else where something
/// fits its words. A note says so. A part that nothing fits stays empty, with a note too. A base
/// without a point gets what nobody else claims.
pub fn label_faces(mesh: &Mesh, condition: &Condition, weld: &Weld, way: Way) -> Labels {
    labellings(mesh, condition, weld, (way, &[])).0
}

/// Labels in one way, and what other ways make of the same segments: the part of each face, way by way.
pub fn labellings(
    mesh: &Mesh,
    condition: &Condition,
    weld: &Weld,
    (way, others): (Way, &[Way]),
) -> (Labels, Vec<Vec<u16>>) {
    let mut start = Start::of(mesh, condition, weld);
    let barred = corrections::barred(mesh, condition);
    if !barred.is_empty() {
        let instead = corrections::instead(&start, (mesh, condition), &barred, way);
        start = start.with((mesh, weld), condition, instead);
    }
    let place = |n: &Note| condition.tree.parts().iter().position(|p| p.name == n.part);
    start.notes.sort_by_key(place);
    let is_merged = way == Way::Merging && others.iter().all(|o| *o == Way::Merging);
    let layout = (!is_merged).then(|| start.layout(&start.view, mesh, condition));
    let found = |&way: &Way| {
        let mut part_of_face = match (way, &layout) {
            (Way::Merging, _) | (_, None) => start.merged(mesh, condition),
            (Way::Fitted, Some(layout)) if start.is_fused(condition.tree.root() as u16) => {
                start.asked_of_all((mesh, weld), condition, layout.clone())
            }
            (Way::Fitted, Some(layout)) => {
                start.asked(layout.clone(), condition, Asked::Ensemble(0))
            }
            (Way::OutOfFold(fold), Some(layout)) => {
                start.asked(layout.clone(), condition, Asked::Fold(fold))
            }
        };
        let Start { component, bodies, seeds, .. } = &start;
        copies::even_out(&mut part_of_face, condition, component, bodies, seeds);
        corrections::enforce(
            &mut part_of_face,
            condition,
            (&start.view.cut.of_face, seeds),
            &barred,
        );
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
    /// How much of the surface is one fused mesh over several parts, 0 to 1 ([`crate::classic::segment::oversegment::segments::fused`]).
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
        let fused = segments::fused(mesh, &component, (&seeds, root));
        let priors = size_priors(condition);
        Self { component, bodies, seeds, notes, priors, view, fused }
    }

    /// The same with more seeds; whether it is a fused mesh stays as it was found without them.
    fn with(self, (mesh, weld): (&Mesh, &Weld), condition: &Condition, more: Vec<Seed>) -> Self {
        let Self { component, bodies, mut seeds, notes, priors, fused, .. } = self;
        seeds.extend(more);
        let root = condition.tree.root() as u16;
        let view = View::of((mesh, weld), (&component, &bodies), (&seeds, root), Cutting::USUAL);
        Self { component, bodies, seeds, notes, priors, view, fused }
    }

    /// Whether most of the surface is one fused mesh over several parts, the base with a prompt among them.
    fn is_fused(&self, root: u16) -> bool {
        self.fused > FUSED && self.seeds.iter().any(|s| s.part == root)
    }

    fn fused_surface<'a>(
        &'a self,
        view: &'a View,
        mesh: &'a Mesh,
        condition: &'a Condition,
    ) -> FusedSurface<'a> {
        let (View { cut, links, .. }, Self { seeds, priors, .. }) = (view, self);
        FusedSurface { mesh, condition, cut, links, seeds, priors }
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
        let growth = if self.is_fused(root) {
            (fused_unary::against(&self.fused_surface(view, mesh, condition)), ON_FUSED)
        } else {
            (distance::far(&cut.segments, links, priors.len()), AMONG_COMPONENTS)
        };
        merge::label(&cut.segments, links, priors, growth)
    }

    /// Labels by some of the fitted models.
    fn asked(&self, mut layout: Layout, condition: &Condition, asked: Asked) -> Vec<u16> {
        let is_fused = self.is_fused(condition.tree.root() as u16);
        let probabilities = classify::estimated(&mut layout, is_fused, asked);
        let part_of_segment = connectivity::gathered(&layout, &probabilities, is_fused);
        self.view.cut.of_face.iter().map(|&segment| part_of_segment[segment as usize]).collect()
    }

    /// Labels of a fused mesh by the fitted models: of every way to cut it, of which `layout` is the usual one,
    /// another ensemble is asked.
    fn asked_of_all(
        &self,
        (mesh, weld): (&Mesh, &Weld),
        condition: &Condition,
        mut layout: Layout,
    ) -> Vec<u16> {
        let others = self.asked_of_others((mesh, weld), condition);
        let usual = classify::estimated(&mut layout, true, Asked::Ensemble(0));
        let all = std::iter::once((&self.view.cut.of_face, &usual));
        let all = all.chain(others.iter().map(|(of_face, probabilities)| (of_face, probabilities)));
        let told: Vec<Told> =
            all.map(|(of_face, probabilities)| Told { of_face, probabilities }).collect();
        fusion::labels(&Surface { mesh, condition, seeds: &self.seeds }, weld, &told)
    }

    /// The segment of each face and what is believed of each segment, for every other way to cut a fused mesh.
    fn asked_of_others(
        &self,
        (mesh, weld): (&Mesh, &Weld),
        condition: &Condition,
    ) -> Vec<(Vec<u32>, Probabilities)> {
        let (bodies, seeds) = ((&*self.component, &*self.bodies), &*self.seeds);
        let root = condition.tree.root() as u16;
        let other = |(i, &cutting): (usize, &Cutting)| {
            let view = View::of((mesh, weld), bodies, (seeds, root), cutting);
            let mut layout = self.layout(&view, mesh, condition);
            (view.cut.of_face, classify::estimated(&mut layout, true, Asked::Ensemble(i + 1)))
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
        let cut = segments::cut((mesh, weld), component, (seeds, root), cutting);
        let diagonal = mesh.bounds().diagonal();
        let touches = contact::touches(bodies, &cut.of_face, diagonal);
        let mut links = evidence::of_contacts(&touches, &cut.segments, diagonal);
        links.extend(evidence::of_seams(&cut.seams, &cut.segments, diagonal));
        Self { cut, links, touches }
    }
}

/// What is known of the segments of a fused mesh before labels spread: what weights are fitted on.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// The segment of each face.
    pub segment_of_face: Vec<u32>,
    /// For each segment, its share of the surface, 0 to 1.
    pub share: Vec<f64>,
    /// For each segment and part, what is known of the two; nothing of a part without a prompt.
    pub features: Vec<Vec<Option<fused_unary::Features>>>,
}

/// The sheet of an object; nothing where it is no fused mesh.
pub fn sheet(mesh: &Mesh, condition: &Condition, weld: &Weld) -> Option<Sheet> {
    let start = Start::of(mesh, condition, weld);
    let features = fused_unary::features(&start.fused_surface(&start.view, mesh, condition));
    let share = start.view.cut.segments.iter().map(|p| p.share).collect();
    let is_fused = start.is_fused(condition.tree.root() as u16);
    is_fused.then_some(Sheet { segment_of_face: start.view.cut.of_face, share, features })
}

/// The segment of each face, and the layout of all segments.
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
pub(crate) mod golden;
#[cfg(test)]
mod tests;
