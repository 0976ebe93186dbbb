//! Convex collision pieces of a link: few, fat, close to the surface and hollow where it is.
//!
//! Connected components whose hull fills no hollow become one piece; the others are cut along
//! their own flat sides until every hull is clean, then neighbours are merged again.

pub(crate) mod emptiness;
pub(crate) mod merge;
pub(crate) mod quickhull;
pub(crate) mod solid;
pub(crate) mod split;
pub(crate) mod surface;

#[cfg(test)]
pub(crate) mod tests;

use glamx::DVec3;
use object::mesh::Mesh;
use object::weld::Weld;
use serde::{Deserialize, Serialize};

use crate::clearance::cover::Cover;
use emptiness::Emptiness;
use solid::Solid;
use split::Gate;
use surface::Surface;

/// Most pieces of one link.
pub const MAX_PIECES: usize = 32;
/// How close pieces keep to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fineness {
    /// Hollows deeper than this share of the tolerance are kept free.
    clearance: f64,
    /// No place on a piece lies deeper in a hollow than this share of the tolerance...
    deepest: f64,
    /// ...as far as so many places on its sides tell.
    looked_at: usize,
}

/// Few pieces, quickly found.
pub(crate) const COARSE: Fineness = Fineness { clearance: 0.2, deepest: 0.8, looked_at: 300 };
/// The same, looked at closely.
pub(crate) const FINE: Fineness = Fineness { looked_at: 900, ..COARSE };
/// Smaller pieces.
pub(crate) const SMALL: Fineness = Fineness { clearance: 0.2, deepest: 0.5, looked_at: 900 };

/// Where there are too many pieces, one may go if others cover its surface within this share of
/// the tolerance, less what [`Cover`] keeps in hand.
const SERVED: f64 = 0.8;
/// Most corners of one piece.
pub const MAX_VERTICES: usize = 64;

/// A convex polyhedron, object frame, metres: closed, faces counter-clockwise seen from outside,
/// at most [`MAX_VERTICES`] corners, volume above 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConvexPiece {
    /// Corners, each used by a face.
    pub vertices: Vec<DVec3>,
    /// Triangles.
    pub faces: Vec<[u32; 3]>,
}

/// Why a link has no collision piece.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HullError {
    /// The tolerance is no length.
    #[error("the tolerance must be a positive number of metres, found {0}")]
    Tolerance(f64),
    /// No face has an area.
    #[error("a link needs a face with an area above 0, but all {faces} faces are degenerate")]
    NoArea {
        /// How many faces there are.
        faces: usize,
    },
}

/// Breadth, metres, below which no piece of an object judged with this tolerance may be.
pub(crate) fn least_width(tolerance: f64) -> f64 {
    (0.12 * tolerance).min(0.0013)
}

/// At most [`MAX_PIECES`] convex pieces that cover a link's surface (object frame, metres) and
/// leave its hollows free.
///
/// `tolerance` is how far pieces and surface may lie apart, metres: a share of the whole object's
/// size, not the link's. A flat sheet gets a little thickness inward.
///
/// # Errors
/// [`HullError`] if the tolerance is not positive or no face has an area.
pub fn decompose(link: &Mesh, tolerance: f64) -> Result<Vec<ConvexPiece>, HullError> {
    decompose_as(link, tolerance, COARSE)
}

/// [`decompose`], more or less finely.
pub(crate) fn decompose_as(
    link: &Mesh,
    tolerance: f64,
    fineness: Fineness,
) -> Result<Vec<ConvexPiece>, HullError> {
    let solids = decompose_solids(link, tolerance, fineness)?;
    Ok(solids.iter().filter_map(Solid::to_piece).collect())
}

fn decompose_solids(
    link: &Mesh,
    tolerance: f64,
    fineness: Fineness,
) -> Result<Vec<Solid>, HullError> {
    if !(tolerance.is_finite() && tolerance > 0.0) {
        return Err(HullError::Tolerance(tolerance));
    }
    let surface = Surface::new(link);
    let clearance = (fineness.clearance * tolerance).min(0.04 * link.bounds().diagonal());
    let deepest = fineness.deepest * tolerance;
    let empty = Emptiness::new(&surface, &link.bounds(), (clearance, tolerance));
    let looked_at = fineness.looked_at;
    let gate = Gate { empty: &empty, clearance, deepest, looked_at, width: least_width(tolerance) };
    let cover = Cover::new(link, 0, SERVED * tolerance);
    let solids = split::split(components(link), &gate);
    if solids.is_empty() {
        return Err(HullError::NoArea { faces: link.faces().len() });
    }
    Ok(merge::merge(solids, &gate, &cover, tolerance))
}

/// The triangles of each connected component that have an area.
fn components(link: &Mesh) -> Vec<Vec<[DVec3; 3]>> {
    let (component, count) = Weld::new(link).components();
    let mut triangles = vec![Vec::new(); count];
    for (face, &c) in component.iter().enumerate() {
        if link.area(face) > 0.0 {
            triangles[c as usize].push(link.corners(face));
        }
    }
    triangles.retain(|t| !t.is_empty());
    triangles
}
