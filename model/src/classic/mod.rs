//! Labels the parts of a mesh and finds their joints without a neural network over the whole
//! object.
//!
//! The surface is cut into segments, each segment is given to a part, and each joint is chosen
//! among a few candidate axes. What is learned (boosted trees, tables, one small network for axes)
//! ships inside the program as packs. Lengths inside are shares of the object's diagonal.

pub mod joints;
pub mod learned;
pub mod lexicon;
pub mod segment;

use std::collections::BTreeMap;

use crate::classic::joints::{axis_model, range_model};
use crate::classic::learned::pack::PackError;
use crate::classic::segment::classify;
use object::sides::OuterSide;
use object::weld::Weld;
use object::{ArticulatedObject, Condition, Mesh};

use crate::articulate::{Articulate, ArticulateError, Articulation, Note};
use crate::classic::joints::{Joints, Labelled, fit_joints, given};
use crate::classic::segment::{Labels, Way, labellings};

/// Labels by merging along evidence, joints by candidate axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Geometric;

impl Articulate for Geometric {
    fn identity(&self) -> String {
        format!("geometric/17 {}", learned(|pack| !pack.starts_with(classify::KIND)))
    }

    fn articulate(
        &self,
        mesh: &Mesh,
        condition: &Condition,
        seed: u64,
    ) -> Result<Articulation, ArticulateError> {
        articulated(mesh, condition, seed, Way::Merging)
    }
}

/// Labels by trees that ask every segment about every part, joints by candidate axes: what is used where
/// nobody chooses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hybrid;

impl Articulate for Hybrid {
    fn identity(&self) -> String {
        format!("hybrid/21 {}", learned(|_| true))
    }

    fn articulate(
        &self,
        mesh: &Mesh,
        condition: &Condition,
        seed: u64,
    ) -> Result<Articulation, ArticulateError> {
        articulated(mesh, condition, seed, Way::Fitted)
    }
}

/// Where fitted models label, axes are placed in the light of these labellings, too.
const HYPOTHESES: [Way; 4] =
    [Way::Merging, Way::OutOfFold(0), Way::OutOfFold(1), Way::OutOfFold(2)];

/// Refuses to begin with a pack that this program cannot read.
///
/// # Errors
/// [`PackError`] of the first such pack.
pub fn check() -> Result<(), PackError> {
    segment::check()?;
    axis_model::check()?;
    range_model::check()
}

/// What was learned and ships, by the name of its pack: BLAKE3 digests of what is in it, without what is
/// said of it. Whatever is fitted to labels follows from it, too.
pub fn digests() -> BTreeMap<&'static str, String> {
    segment::digests()
        .into_iter()
        .chain([axis_model::digest_of_pack(), range_model::digest_of_pack()])
        .collect()
}

/// The packs of these names as one digest, shortened: other numbers are another identity.
fn learned(of: impl Fn(&str) -> bool) -> String {
    let mut hasher = blake3::Hasher::new();
    for (name, digest) in digests().iter().filter(|(name, _)| of(name)) {
        hasher.update(name.as_bytes()).update(digest.as_bytes());
    }
    hasher.finalize().to_hex().chars().take(12).collect()
}

/// Of a mesh that is drawn on both sides, or in part from within, the outer side is articulated, and all
/// faces go along.
fn articulated(
    mesh: &Mesh,
    condition: &Condition,
    seed: u64,
    way: Way,
) -> Result<Articulation, ArticulateError> {
    check()?;
    condition.check_points(mesh)?;
    let weld = Weld::new(mesh);
    let Some(side) = OuterSide::of(mesh, &weld) else {
        return of_one_side((mesh, &weld), condition, seed, way);
    };
    let outer = side.mesh(mesh)?;
    let mut there = condition.clone();
    for prompt in &mut there.prompts {
        prompt.faces = prompt.faces.iter().map(|face| side.of_face[face as usize] as u32).collect();
    }
    let Articulation { object, part_of_condition, notes } =
        of_one_side((&outer, &Weld::new(&outer)), &there, seed, way)?;
    let part_of_face = side.of_face.iter().map(|&face| object.part_of_face()[face]).collect();
    let object = object.with_surface(mesh.clone(), part_of_face)?;
    Ok(Articulation { object, part_of_condition, notes })
}

/// Articulates a mesh that is drawn once and from without.
fn of_one_side(
    (mesh, weld): (&Mesh, &Weld),
    condition: &Condition,
    seed: u64,
    way: Way,
) -> Result<Articulation, ArticulateError> {
    let asked: &[Way] = if way == Way::Fitted { &HYPOTHESES } else { &[] };
    let (labels, others) = labellings(mesh, condition, weld, (way, asked));
    let Labels { part_of_face, mut notes } = labels;
    let Kept { tree, part_of_condition, part_of_face } = keep(condition, &part_of_face)?;
    let name = |p: usize| condition.tree.parts()[p].name.clone();
    let lost = part_of_condition.iter().enumerate().filter(|(_, new)| new.is_none());
    notes.extend(lost.map(|(p, _)| lost_part(name(p))));
    let category = condition.category.as_str();
    let scale = condition.size.map_or(1.0, |size| size.scale_for(mesh));
    let given = given::of_parts(condition, &part_of_condition, scale);
    let from =
        Labelled { mesh, weld, tree: &tree, part_of_face: &part_of_face, category, given: &given };
    let now = |&p: &u16| part_of_condition[usize::from(p)].unwrap_or(tree.root()) as u16;
    let others: Vec<Vec<u16>> = others.iter().map(|o| o.iter().map(now).collect()).collect();
    let Joints { motions, notes: doubts } = fit_joints(&from, &others, seed);
    notes.extend(doubts);
    let place = |n: &Note| condition.tree.parts().iter().position(|p| p.name == n.part);
    notes.sort_by_key(place);
    let object = ArticulatedObject::new(mesh.clone(), tree, part_of_face, motions)?;
    Ok(Articulation { object, part_of_condition, notes })
}

/// What is left once parts without a face are gone.
struct Kept {
    tree: object::KinematicTree,
    part_of_condition: Vec<Option<usize>>,
    part_of_face: Vec<u16>,
}

fn keep(condition: &Condition, part_of_face: &[u16]) -> Result<Kept, ArticulateError> {
    let mut lost = vec![true; condition.tree.len()];
    for &part in part_of_face {
        if let Some(slot) = lost.get_mut(usize::from(part)) {
            *slot = false;
        }
    }
    let root = condition.tree.root();
    if lost[root] {
        return Err(ArticulateError::BaseLost(condition.tree.parts()[root].name.clone()));
    }
    if lost.iter().filter(|l| !**l).count() < 2 && condition.tree.len() > 1 {
        let found = format!("{} faces, all one part", part_of_face.len());
        return Err(ArticulateError::NothingLabelled(found));
    }
    let (tree, part_of_condition) = condition.tree.without(&lost)?;
    let new =
        |&p: &u16| part_of_condition.get(usize::from(p)).copied().flatten().unwrap_or(0) as u16;
    let part_of_face = part_of_face.iter().map(new).collect();
    Ok(Kept { tree, part_of_condition, part_of_face })
}

fn lost_part(part: String) -> Note {
    let message = "no face of the mesh was found to belong to it, so it is left out".into();
    Note { part, message, loss: true }
}

#[cfg(test)]
mod identity {
    use super::*;

    /// The tables of roles, contacts and sizes stood in the source, whose digest is part of every key.
    #[test]
    fn every_pack_that_labels_and_joints_follow_from_is_in_the_identity() {
        let all: Vec<&str> = digests().into_keys().collect();
        let packs = "axes contacts fused_unary ranges roles segments segments_fused sizes";
        assert_eq!(all.join(" "), packs);
        assert_eq!(Hybrid.identity(), format!("hybrid/21 {}", learned(|_| true)));
        for left_out in &all {
            assert_ne!(learned(|pack| pack != *left_out), learned(|_| true), "{left_out}");
        }
        let geometric = learned(|pack| pack != "segments" && pack != "segments_fused");
        assert_eq!(Geometric.identity(), format!("geometric/17 {geometric}"));
    }
}

#[cfg(test)]
mod corrected;
#[cfg(test)]
mod golden;
#[cfg(test)]
mod tests;
