//! What is known of a surface before labels spread over it.

use std::collections::BTreeMap;

use object::weld::Weld;
use object::{Condition, Mesh};
use rayon::prelude::*;

use crate::articulate::Note;
use crate::classic::lexicon::sizes::SizePrior;
use crate::classic::segment::classify::{self, Asked, Known, Layout, Probabilities};
use crate::classic::segment::grow::fused_unary::{self, FusedSurface};
use crate::classic::segment::grow::merge::{self, Group, Habits, Link};
use crate::classic::segment::grow::{distance, evidence, islands};
use crate::classic::segment::oversegment::contact::{self, Body, Touch};
use crate::classic::segment::oversegment::patches::Cutting;
use crate::classic::segment::oversegment::segments::{self, Cut};
use crate::classic::segment::prompts::seeds::{self, Seed};
use crate::classic::segment::prompts::{placed, repeats};
use crate::classic::segment::refine::connectivity;
use crate::classic::segment::refine::fusion::{self, Told};
use crate::classic::segment::refine::surface::Surface;
/// How clusters grow among components.
const AMONG_COMPONENTS: Habits = Habits { patience: 0.3, nearness: 0.7, size: 1.0 };
/// How clusters grow on a fused mesh: what speaks for a part counts for more, and holds sizes already.
const ON_FUSED: Habits = Habits { patience: 0.0, nearness: 2.0, size: 0.5 };
/// An object is a fused mesh if more than this share of its surface lies in components with several
/// prompts, as in what a generator delivers. Components with the base's prompt alone do not count.
/// Below this share, the other components still tell much.
const FUSED: f64 = 0.95;

/// What is known before labels spread.
pub(super) struct Start {
    pub(super) component: Vec<u32>,
    pub(super) bodies: Vec<Body>,
    pub(super) seeds: Vec<Seed>,
    pub(super) notes: Vec<Note>,
    pub(super) priors: Vec<SizePrior>,
    /// The surface as it usually is cut.
    pub(super) view: View,
    /// How much of the surface is one fused mesh over several parts, 0 to 1 ([`crate::classic::segment::oversegment::segments::fused`]).
    pub(super) fused: f64,
}

/// The surface cut in one way.
pub(super) struct View {
    pub(super) cut: Cut,
    pub(super) links: Vec<Link>,
    pub(super) touches: BTreeMap<(u32, u32), Touch>,
}

impl Start {
    pub(super) fn of(mesh: &Mesh, condition: &Condition, weld: &Weld) -> Self {
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
    pub(super) fn with(
        self,
        (mesh, weld): (&Mesh, &Weld),
        condition: &Condition,
        more: Vec<Seed>,
    ) -> Self {
        let Self { component, bodies, mut seeds, notes, priors, fused, .. } = self;
        seeds.extend(more);
        let root = condition.tree.root() as u16;
        let view = View::of((mesh, weld), (&component, &bodies), (&seeds, root), Cutting::USUAL);
        Self { component, bodies, seeds, notes, priors, view, fused }
    }

    /// Whether most of the surface is one fused mesh over several parts, the base with a prompt among them.
    pub(super) fn is_fused(&self, root: u16) -> bool {
        self.fused > FUSED && self.seeds.iter().any(|s| s.part == root)
    }

    pub(super) fn fused_surface<'a>(
        &'a self,
        view: &'a View,
        mesh: &'a Mesh,
        condition: &'a Condition,
    ) -> FusedSurface<'a> {
        let (View { cut, links, .. }, Self { seeds, priors, .. }) = (view, self);
        FusedSurface { mesh, condition, cut, links, seeds, priors }
    }

    /// Labels by merging.
    pub(super) fn merged(&self, mesh: &Mesh, condition: &Condition) -> Vec<u16> {
        let groups = self.groups(&self.view, mesh, condition);
        let root = condition.tree.root() as u16;
        islands::settle(mesh, &self.view.cut.of_face, &groups, (&self.priors, root))
    }

    pub(super) fn groups(&self, view: &View, mesh: &Mesh, condition: &Condition) -> Vec<Group> {
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
    pub(super) fn asked(
        &self,
        mut layout: Layout,
        condition: &Condition,
        asked: Asked,
    ) -> Vec<u16> {
        let is_fused = self.is_fused(condition.tree.root() as u16);
        let probabilities = classify::estimated(&mut layout, is_fused, asked);
        let part_of_segment = connectivity::gathered(&layout, &probabilities, is_fused);
        self.view.cut.of_face.iter().map(|&segment| part_of_segment[segment as usize]).collect()
    }

    /// Labels of a fused mesh by the fitted models: of every way to cut it, of which `layout` is the usual one,
    /// another ensemble is asked.
    pub(super) fn asked_of_all(
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
    pub(super) fn asked_of_others(
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

    pub(super) fn layout(&self, view: &View, mesh: &Mesh, condition: &Condition) -> Layout {
        let (View { cut, links, touches }, Self { seeds, priors, .. }) = (view, self);
        let merged: Vec<_> = self.groups(view, mesh, condition).iter().map(|g| g.label).collect();
        Layout::of(&Known { mesh, condition, cut, links, touches, seeds, merged: &merged, priors })
    }
}

impl View {
    pub(super) fn of(
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

fn size_priors(condition: &Condition) -> Vec<SizePrior> {
    let root = condition.tree.root();
    (0..condition.tree.len()).map(|p| SizePrior::of(condition.text(p), p == root)).collect()
}
