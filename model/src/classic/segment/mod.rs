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
pub(crate) mod confidence;
mod corrections;
pub mod grow;
mod memory;
pub mod oversegment;
pub mod prompts;
pub mod refine;
pub mod sheets;
pub(crate) mod skin;
mod start;

use std::sync::Arc;

use object::weld::Weld;
use object::{Condition, Mesh};
use rayon::prelude::*;

use crate::articulate::Note;
use crate::classic::learned::pack::PackError;
use crate::classic::lexicon::sizes;
use crate::classic::lexicon::words::stem;
use crate::classic::segment::classify::{Asked, Layout};
use crate::classic::segment::grow::{evidence, fused_unary};
use crate::classic::segment::memory::Answer;
pub(crate) use crate::classic::segment::memory::Memory;
use crate::classic::segment::prompts::roles;
use crate::classic::segment::refine::copies;
pub use crate::classic::segment::sheets::{
    Contact, ContactSheet, RolePart, RoleSheet, contact_sheet, role_sheet,
};
use crate::classic::segment::skin::Skin;
use crate::classic::segment::start::Start;

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

/// The part of each face in one way, from what is known before labels spread.
fn labelled(start: &Start, condition: &Condition, way: Way) -> Vec<u16> {
    let part_of_face = match way {
        Way::Merging => start.merged(condition),
        Way::Fitted => return answered(start, condition).part_of_face,
        Way::OutOfFold(fold) => start.asked(condition, Asked::Fold(fold)).0,
    };
    evened_out(part_of_face, start, condition)
}

/// What the fitted models say, from what is known before labels spread.
fn answered(start: &Start, condition: &Condition) -> Answer {
    let (part_of_face, confidence, usual) = if start.is_fused(condition.tree.root() as u16) {
        start.asked_of_all(condition)
    } else {
        let (part_of_face, confidence) = start.asked(condition, Asked::Ensemble(0));
        let usual = confidence.rows.clone();
        (part_of_face, confidence, usual)
    };
    Answer { part_of_face: evened_out(part_of_face, start, condition), confidence, usual }
}

fn evened_out(mut part_of_face: Vec<u16>, start: &Start, condition: &Condition) -> Vec<u16> {
    let Start { skin, seeds, .. } = start;
    copies::even_out(&mut part_of_face, condition, &skin.component, &skin.bodies, seeds);
    part_of_face
}

/// Labels, how sure each is, and what other ways make of the same segments.
pub(crate) struct Spread {
    /// Labels in the way that was asked for.
    pub labels: Labels,
    /// For each face, how likely its part is, 0 to 1: the class probability, averaged over cuts; 1 where it
    /// was painted, and where labels came by merging.
    pub confidence: Vec<f32>,
    /// The part of each face, way by way.
    pub others: Vec<Vec<u16>>,
    /// For each part of the condition, what [`confidence::NAMES`] say of it; nothing where labels came by
    /// merging.
    pub evidence: Option<Vec<PartEvidence>>,
}

/// What is told of a part of the condition, and which piece of it may be another's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartEvidence {
    /// The numbers of [`confidence::NAMES`].
    pub numbers: [f64; confidence::COUNT],
    pub doubt: Option<confidence::Doubtful>,
}

/// Labels in one way, and what other ways make of the same segments: the part of each face, way by way.
pub fn labellings(
    mesh: &Mesh,
    condition: &Condition,
    weld: &Weld,
    ways: (Way, &[Way]),
) -> (Labels, Vec<Vec<u16>>) {
    let Spread { labels, others, .. } =
        spread((&Skin::of(mesh, weld), &Memory::default()), condition, ways);
    (labels, others)
}

/// Labels in one way of which something may be remembered, how sure each is, and what other ways make of the
/// same segments.
pub(crate) fn spread(
    (skin, memory): (&Skin, &Memory),
    condition: &Condition,
    (way, others): (Way, &[Way]),
) -> Spread {
    let mut start = Start::of(skin, condition);
    let barred = corrections::barred(&skin.mesh, condition);
    let found = |start: &Start, way: Way| {
        let asked = || memory::Asked::of(condition, &start.seeds, start.fused);
        let answer =
            (way == Way::Fitted).then(|| memory.recall(asked(), || answered(start, condition)));
        let part_of_face = answer
            .as_ref()
            .map_or_else(|| labelled(start, condition, way), |a| a.part_of_face.clone());
        (part_of_face, answer)
    };
    let before = (!barred.is_empty()).then(|| found(&start, way));
    if let Some((_, answer)) = &before {
        let usual = answer.as_ref().map(|answer| &answer.usual);
        let by_merging = way == Way::Merging;
        let instead = corrections::instead(&start, condition, &barred, (usual, by_merging));
        start = start.with(condition, instead);
    }
    let place = |n: &Note| condition.tree.parts().iter().position(|p| p.name == n.part);
    start.notes.sort_by_key(place);
    let corrected = |way: Way| {
        let (mut part_of_face, answer) = found(&start, way);
        let known = (&*start.view.cut.of_face, &*start.seeds);
        corrections::enforce(&mut part_of_face, known, &barred);
        condition.paint(&mut part_of_face);
        (part_of_face, answer)
    };
    let (mut part_of_face, answer) = corrected(way);
    let sure = |answer: &Option<Arc<Answer>>, labels: &[u16]| match answer {
        Some(answer) => answer.confidence.of_all(labels),
        None => vec![1.0; labels.len()],
    };
    let mut confidence = sure(&answer, &part_of_face);
    if let Some((before, answer)) = before {
        let known = (&*start.seeds, &*barred);
        let taken = corrections::taken(skin, known, (&before, &part_of_face));
        let stays = |face: usize| taken[face] == before[face];
        let kept = sure(&answer, &before).into_iter().enumerate().filter(|(f, _)| stays(*f));
        kept.for_each(|(face, sure)| confidence[face] = sure);
        part_of_face = taken;
    }
    condition.paint(&mut part_of_face);
    for face in condition.prompts.iter().flat_map(|prompt| prompt.faces.iter()) {
        confidence.iter_mut().skip(face as usize).take(1).for_each(|sure| *sure = 1.0);
    }
    let others: Vec<Vec<u16>> = others.par_iter().map(|way| corrected(*way).0).collect();
    let found = answer.map(|answer| {
        evidence_of(&start, condition, (&part_of_face, &confidence), (&answer, &others))
    });
    let labels = Labels { part_of_face, notes: start.notes };
    Spread { labels, confidence, others, evidence: found }
}

/// What is told of every part of the condition.
fn evidence_of(
    start: &Start,
    condition: &Condition,
    (part_of_face, own): (&[u16], &[f32]),
    (answer, others): (&Answer, &[Vec<u16>]),
) -> Vec<PartEvidence> {
    let skin = start.skin;
    let stem_of = |part: usize| stem(condition.text(part));
    let stems: Vec<String> = (0..condition.tree.len()).map(stem_of).collect();
    let like = |part: usize| (0..stems.len()).filter(|&p| stems[p] == stems[part]).collect();
    let alike: Vec<Vec<usize>> = (0..stems.len()).map(like).collect();
    let areas: Vec<f64> = skin.masses.iter().map(|mass| mass.area).collect();
    let found = confidence::Found {
        mesh: &skin.mesh,
        areas: &areas,
        component: &skin.component,
        part_of_face,
        own,
        chances: &answer.confidence,
        others,
        fused: start.fused,
        alike: &alike,
    };
    let both = found.numbers().into_iter().zip(found.doubts());
    both.map(|(numbers, doubt)| PartEvidence { numbers, doubt }).collect()
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
    let skin = Skin::of(mesh, weld);
    let start = Start::of(&skin, condition);
    let features = fused_unary::features(&start.fused_surface(&start.view, condition));
    let share = start.view.cut.segments.iter().map(|p| p.share).collect();
    let is_fused = start.is_fused(condition.tree.root() as u16);
    is_fused.then_some(Sheet { segment_of_face: start.view.cut.of_face, share, features })
}

/// The segment of each face, and the layout of all segments.
pub fn layout(mesh: &Mesh, condition: &Condition, weld: &Weld) -> (Vec<u32>, Layout) {
    let skin = Skin::of(mesh, weld);
    let start = Start::of(&skin, condition);
    let layout = start.layout(&start.view, condition);
    (start.view.cut.of_face, layout)
}

#[cfg(test)]
pub(crate) mod golden;
#[cfg(test)]
mod tests;
