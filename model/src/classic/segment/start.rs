//! What is known of a surface before labels spread over it.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use object::Condition;
use rayon::prelude::*;

use crate::articulate::Note;
use crate::classic::lexicon::sizes::SizePrior;
use crate::classic::segment::classify::{self, Asked, Known, Layout, Probabilities};
use crate::classic::segment::confidence::Confidence;
use crate::classic::segment::grow::fused_unary::{self, FusedSurface};
use crate::classic::segment::grow::merge::{self, Group, Habits, Link};
use crate::classic::segment::grow::{distance, evidence, islands};
use crate::classic::segment::oversegment::contact::{self, Touch};
use crate::classic::segment::oversegment::patches::Cutting;
use crate::classic::segment::oversegment::segments::{self, Cut};
use crate::classic::segment::prompts::seeds::{self, Seed};
use crate::classic::segment::prompts::{placed, repeats};
use crate::classic::segment::refine::connectivity;
use crate::classic::segment::refine::fusion::{self, Told};
use crate::classic::segment::refine::surface::Surface;
use crate::classic::segment::skin::Skin;

/// How clusters grow among components.
const AMONG_COMPONENTS: Habits = Habits { patience: 0.3, nearness: 0.7, size: 1.0 };
/// How clusters grow on a fused mesh: what speaks for a part counts for more, and holds sizes already.
const ON_FUSED: Habits = Habits { patience: 0.0, nearness: 2.0, size: 0.5 };
/// An object is a fused mesh if more than this share of its surface lies in components with several
/// prompts, as in what a generator delivers. Components with the base's prompt alone do not count.
/// Below this share, the other components still tell much.
const FUSED: f64 = 0.95;

/// What is known before labels spread.
pub(super) struct Start<'a> {
    pub(super) skin: &'a Skin,
    pub(super) seeds: Vec<Seed>,
    pub(super) notes: Vec<Note>,
    pub(super) priors: Vec<SizePrior>,
    /// The surface as it usually is cut.
    pub(super) view: View,
    /// Its layout, once it was asked for.
    usual: OnceLock<Layout>,
    /// How much of the surface is one fused mesh over several parts, 0 to 1 ([`crate::classic::segment::oversegment::segments::fused`]).
    pub(super) fused: f64,
}

/// The surface cut in one way.
pub(super) struct View {
    pub(super) cut: Cut,
    pub(super) links: Vec<Link>,
    pub(super) touches: BTreeMap<(u32, u32), Touch>,
}

impl<'a> Start<'a> {
    pub(super) fn of(skin: &'a Skin, condition: &Condition) -> Self {
        let Skin { mesh, component, bodies, .. } = skin;
        let thing_of = |face: usize| (component[face], skin.body_of(face).area);
        let (mut seeds, mut notes) = seeds::seeds(mesh, condition, thing_of);
        let (repeated, doubts) = repeats::place(condition, component, bodies, &seeds);
        seeds.extend(repeated);
        notes.extend(doubts);
        placed::add(|| skin.placeable(), condition, (&mut seeds, &mut notes));
        let root = condition.tree.root() as u16;
        let view = View::of(skin, (&seeds, root), Cutting::USUAL);
        let fused = segments::fused(skin, (&seeds, root));
        let priors = size_priors(condition);
        Self { skin, seeds, notes, priors, view, usual: OnceLock::new(), fused }
    }

    /// The same with more seeds; whether it is a fused mesh stays as it was found without them.
    pub(super) fn with(self, condition: &Condition, more: Vec<Seed>) -> Self {
        let Self { skin, mut seeds, notes, priors, fused, .. } = self;
        seeds.extend(more);
        let root = condition.tree.root() as u16;
        let view = View::of(skin, (&seeds, root), Cutting::USUAL);
        Self { skin, seeds, notes, priors, view, usual: OnceLock::new(), fused }
    }

    /// Whether most of the surface is one fused mesh over several parts, the base with a prompt among them.
    pub(super) fn is_fused(&self, root: u16) -> bool {
        self.fused > FUSED && self.seeds.iter().any(|s| s.part == root)
    }

    pub(super) fn fused_surface<'b>(
        &'b self,
        view: &'b View,
        condition: &'b Condition,
    ) -> FusedSurface<'b> {
        let (View { cut, links, .. }, Self { skin, seeds, priors, .. }) = (view, self);
        FusedSurface { mesh: &skin.mesh, condition, cut, links, seeds, priors }
    }

    /// Labels by merging.
    pub(super) fn merged(&self, condition: &Condition) -> Vec<u16> {
        let groups = self.groups(&self.view, condition);
        let root = condition.tree.root() as u16;
        islands::settle(&self.skin.mesh, &self.view.cut.of_face, &groups, (&self.priors, root))
    }

    pub(super) fn groups(&self, view: &View, condition: &Condition) -> Vec<Group> {
        let root = condition.tree.root() as u16;
        let (View { cut, links, .. }, Self { priors, .. }) = (view, self);
        let growth = if self.is_fused(root) {
            (fused_unary::against(&self.fused_surface(view, condition)), ON_FUSED)
        } else {
            (distance::far(&cut.segments, links, priors.len()), AMONG_COMPONENTS)
        };
        merge::label(&cut.segments, links, priors, growth)
    }

    /// Labels by some of the fitted models.
    pub(super) fn asked(&self, condition: &Condition, asked: Asked) -> (Vec<u16>, Confidence) {
        let mut layout = self.usual_layout(condition);
        let is_fused = self.is_fused(condition.tree.root() as u16);
        let probabilities = classify::estimated(&mut layout, is_fused, asked);
        let part_of_segment = connectivity::gathered(&layout, &probabilities, is_fused);
        let of_face = &self.view.cut.of_face;
        let labels = of_face.iter().map(|&segment| part_of_segment[segment as usize]).collect();
        (labels, Confidence { region_of_face: of_face.clone(), rows: probabilities })
    }

    /// Labels of a fused mesh by the fitted models, and what is believed of its faces and of the segments of the
    /// usual cut: of every way to cut it another ensemble is asked.
    pub(super) fn asked_of_all(
        &self,
        condition: &Condition,
    ) -> (Vec<u16>, Confidence, Probabilities) {
        let mut layout = self.usual_layout(condition);
        let others = self.asked_of_others(condition);
        let usual = classify::estimated(&mut layout, true, Asked::Ensemble(0));
        let all = std::iter::once((&self.view.cut.of_face, &usual));
        let all = all.chain(others.iter().map(|(of_face, probabilities)| (of_face, probabilities)));
        let told: Vec<Told> =
            all.map(|(of_face, probabilities)| Told { of_face, probabilities }).collect();
        let surface = Surface { skin: self.skin, condition, seeds: &self.seeds };
        let (labels, confidence) = fusion::labels(&surface, &told);
        drop(told);
        (labels, confidence, usual)
    }

    /// The segment of each face and what is believed of each segment, for every other way to cut a fused mesh.
    pub(super) fn asked_of_others(&self, condition: &Condition) -> Vec<(Vec<u32>, Probabilities)> {
        let root = condition.tree.root() as u16;
        let other = |(i, &cutting): (usize, &Cutting)| {
            let view = View::of(self.skin, (&self.seeds, root), cutting);
            let mut layout = self.layout(&view, condition);
            (view.cut.of_face, classify::estimated(&mut layout, true, Asked::Ensemble(i + 1)))
        };
        Cutting::OTHERS.par_iter().enumerate().map(other).collect()
    }

    /// The layout of the usual cut, before anything was asked.
    pub(super) fn usual_layout(&self, condition: &Condition) -> Layout {
        self.usual.get_or_init(|| self.layout(&self.view, condition)).clone()
    }

    pub(super) fn layout(&self, view: &View, condition: &Condition) -> Layout {
        let (View { cut, links, touches }, Self { skin, seeds, priors, .. }) = (view, self);
        let merged: Vec<_> = self.groups(view, condition).iter().map(|g| g.label).collect();
        let (mesh, masses, merged) = (&skin.mesh, &*skin.masses, &*merged);
        Layout::of(&Known { mesh, masses, condition, cut, links, touches, seeds, merged, priors })
    }
}

impl View {
    pub(super) fn of(skin: &Skin, (seeds, root): (&[Seed], u16), cutting: Cutting) -> Self {
        let cut = segments::cut(skin, (seeds, root), cutting);
        let diagonal = skin.diagonal;
        let touches = contact::touches((&skin.bodies, skin.near()), &cut.of_face, diagonal);
        let mut links = evidence::of_contacts(&touches, &cut.segments, diagonal);
        links.extend(evidence::of_seams(&cut.seams, &cut.segments, diagonal));
        Self { cut, links, touches }
    }
}

fn size_priors(condition: &Condition) -> Vec<SizePrior> {
    let root = condition.tree.root();
    (0..condition.tree.len()).map(|p| SizePrior::of(condition.text(p), p == root)).collect()
}
