//! A surface with a part for every face: what joints are looked for on.

use object::condition::GivenJoint;
use object::weld::Weld;
use object::{KinematicTree, Mesh};

/// A mesh whose faces have parts: what joints are fitted to.
#[derive(Clone, Copy, Debug)]
pub struct Labelled<'a> {
    /// The surface.
    pub mesh: &'a Mesh,
    /// Its connectivity.
    pub weld: &'a Weld,
    /// Parts and joint kinds; every part has a face.
    pub tree: &'a KinematicTree,
    /// The part of each face.
    pub part_of_face: &'a [u16],
    /// What the object is, in words; may be empty.
    pub category: &'a str,
    /// For each part, what is given of its joints, lengths in the mesh's unit; may be shorter.
    pub given: &'a [Vec<GivenJoint>],
}

impl Labelled<'_> {
    /// What is given of a part's joints, in the order of the tree's; empty where nothing is.
    pub fn given(&self, part: usize) -> &[GivenJoint] {
        self.given.get(part).map_or(&[], Vec::as_slice)
    }
}
