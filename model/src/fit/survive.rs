//! The parts that got a face: the tree without the others, and labels that count only them.

use object::{Condition, KinematicTree};

use crate::articulate::ArticulateError;

/// What is left once parts without a face are gone.
#[derive(Clone, Debug)]
pub struct Survivors {
    /// The tree; children of lost parts hang on the nearest surviving ancestor.
    pub tree: KinematicTree,
    /// For each part of the condition, its new index.
    pub part_of_condition: Vec<Option<usize>>,
    /// The part of each face, by new index.
    pub part_of_face: Vec<u16>,
}

/// Takes parts without a face out of the tree.
///
/// # Errors
/// [`ArticulateError::NothingLabelled`] when a single part of several got all faces,
/// [`ArticulateError::Tree`] when the base got none.
pub fn survivors(
    condition: &Condition,
    part_of_face: &[u16],
) -> Result<Survivors, ArticulateError> {
    let mut lost = vec![true; condition.tree.len()];
    part_of_face.iter().for_each(|&p| lost[usize::from(p)] = false);
    if lost.len() > 1 && lost.iter().filter(|l| !**l).count() < 2 {
        let found = format!("{} faces, all one part", part_of_face.len());
        return Err(ArticulateError::NothingLabelled(found));
    }
    let (tree, part_of_condition) = condition.tree.without(&lost)?;
    let new: Vec<u16> = part_of_condition.iter().map(|p| p.unwrap_or(0) as u16).collect();
    let part_of_face = part_of_face.iter().map(|&p| new[usize::from(p)]).collect();
    Ok(Survivors { tree, part_of_condition, part_of_face })
}
