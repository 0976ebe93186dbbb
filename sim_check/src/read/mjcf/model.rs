//! An MJCF model while it is read: settings, classes, meshes, and the draft it becomes.

use std::collections::{BTreeMap, BTreeSet};

use glamx::DVec3;

use super::attributes::{Compiler, Defaults};
use super::weighing::Weighing;
use crate::read::draft::Draft;
use crate::read::xml::Reader;
use crate::robot::Geometry;

/// A model being read.
pub(super) struct Model<'r, 's> {
    pub(super) reader: &'r mut Reader<'s>,
    pub(super) compiler: Compiler,
    pub(super) defaults: Defaults,
    pub(super) meshes: BTreeMap<String, MeshAsset>,
    /// Colours of materials by name.
    pub(super) paints: BTreeMap<String, [u8; 4]>,
    /// Of each joint in the order of MuJoCo's coordinates: its name (none if it floats), how many
    /// coordinates it has, and which value stands for the pose the file is written in.
    pub(super) coordinates: Vec<(Option<String>, usize, f64)>,
    /// Bodies that a program moves.
    pub(super) mocaps: Vec<String>,
    /// The body each site stands in.
    pub(super) sites: BTreeMap<String, String>,
    /// Bodies of which nothing is seen but what viewers hide, and whether others are seen.
    pub(super) unseen: (Vec<String>, bool),
    /// What each geom may touch, with the number of its body.
    pub(super) masks: Vec<(usize, [u32; 2])>,
    /// Names given so far to links and to joints.
    pub(super) taken: [BTreeSet<String>; 2],
    pub(super) draft: &'r mut Draft,
}

/// A mesh that geoms may name.
pub(super) struct MeshAsset {
    /// The file as written, or the mesh's name.
    pub source: String,
    pub scale: DVec3,
    pub geometry: Geometry,
    /// How it is weighed.
    pub weighing: Weighing,
}
