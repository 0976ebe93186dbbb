//! What a mesh file gives: a surface, how it looks, and what did not come along.

use crate::appearance::Appearance;
use crate::mesh::Mesh;

/// Most notes of one file; how many more there are is said in the last. A guess: a screenful.
const MAX_NOTES: usize = 24;

/// A mesh, how it looks, and what of its file did not make it in.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The surface, object frame.
    pub mesh: Mesh,
    /// Materials and textures of its faces; none where the file has no more than colours of vertices.
    pub appearance: Option<Appearance>,
    /// What was left out (animations, skins, hidden nodes, points and lines, unreadable textures), in
    /// plain words.
    pub notes: Vec<String>,
}

/// Notes, no more than a screenful; the last says how many more there are.
pub(crate) fn shortened(mut notes: Vec<String>) -> Vec<String> {
    let rest = notes.len().saturating_sub(MAX_NOTES);
    if rest > 0 {
        notes.truncate(MAX_NOTES);
        notes.push(format!("{rest} more of the kind"));
    }
    notes
}
