//! The parts that got a face, and those that got none.

use object::{Condition, KinematicTree};

use crate::articulate::{ArticulateError, Note};

/// What is left once parts without a face are gone.
pub(super) struct Kept {
    pub tree: KinematicTree,
    pub part_of_condition: Vec<Option<usize>>,
    pub part_of_face: Vec<u16>,
}

pub(super) fn keep(condition: &Condition, part_of_face: &[u16]) -> Result<Kept, ArticulateError> {
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

pub(super) fn lost_part(part: String) -> Note {
    let message = "no face of the mesh was found to belong to it, so it is left out".into();
    Note { part, message, loss: true }
}
