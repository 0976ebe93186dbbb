//! A repaired surface: its faces in patches that agree on what is outside, and what was altered.

use glamx::DVec3;
use object::Mesh;
use serde::{Deserialize, Serialize};

/// A face whose height is below this share of the surface's diagonal has no area to show.
pub const FLAT: f64 = 1e-9;

/// A repaired surface, its patches, and what was done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    /// The faces that remain, oriented; vertices are shared within a patch only.
    pub mesh: Mesh,
    /// The patches of `mesh`.
    pub patches: Vec<Patch>,
    /// What was done.
    pub report: Report,
}

/// Faces that hang together and agree on what is outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Patch {
    /// Faces, ascending.
    pub faces: Vec<u32>,
    /// Volume enclosed, m³; negative for the wall of a cavity. `None` for a patch with a border.
    pub volume: Option<f64>,
    /// For the wall of a cavity, the patch it is hollowed out of.
    pub hollows: Option<usize>,
}

/// Counts of what was altered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// Faces without area, dropped.
    pub degenerate: usize,
    /// Exact copies of another face (same corners, same side), dropped.
    pub repeated: usize,
    /// Faces turned over.
    pub flipped: usize,
    /// Joins of faces that no orientation satisfies.
    pub conflicts: usize,
}

/// Whether a triangle is no higher than `flat`.
pub(crate) fn is_flat([a, b, c]: [DVec3; 3], flat: f64) -> bool {
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    (b - a).cross(c - a).length() <= longest * flat
}
