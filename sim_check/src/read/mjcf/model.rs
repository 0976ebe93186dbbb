//! An MJCF model while it is read: settings, classes, meshes, and the draft it becomes.

use std::collections::BTreeMap;

use glamx::DVec3;

use super::attributes::{Compiler, Defaults};
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
    pub(super) draft: &'r mut Draft,
}

/// A mesh that geoms may name.
pub(super) struct MeshAsset {
    /// The file as written, or the mesh's name.
    pub source: String,
    pub scale: DVec3,
    pub geometry: Geometry,
}
