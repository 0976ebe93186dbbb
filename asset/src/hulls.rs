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

use emptiness::Emptiness;
use solid::{MAX_CORNERS, Solid};
use split::Gate;
use surface::Surface;

/// Most pieces of one link.
pub const MAX_PIECES: usize = 32;
/// Hollows deeper than this share of the tolerance are kept free.
const FINE: f64 = 0.2;
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
    let solids = decompose_solids(link, tolerance)?;
    Ok(solids.iter().filter_map(Solid::to_piece).collect())
}

fn decompose_solids(link: &Mesh, tolerance: f64) -> Result<Vec<Solid>, HullError> {
    if !(tolerance.is_finite() && tolerance > 0.0) {
        return Err(HullError::Tolerance(tolerance));
    }
    let surface = Surface::new(link);
    let clearance = (FINE * tolerance).min(0.04 * link.bounds().diagonal());
    let depths = (clearance, 0.45 * tolerance);
    let empty = Emptiness::new(&surface, &link.bounds(), depths);
    let gate = Gate { empty: &empty, clearance };
    let patches = split::split(components(link), &gate);
    let width = least_width(tolerance);
    let solids: Vec<Solid> = patches.iter().filter_map(|p| thick(p, width, clearance)).collect();
    if solids.is_empty() {
        return Err(HullError::NoArea { faces: link.faces().len() });
    }
    Ok(merge::merge(solids, &gate, tolerance))
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

/// The hull of a patch, at least `width` metres thick; `None` if the patch has no area to speak of.
fn thick(patch: &[[DVec3; 3]], width: f64, clearance: f64) -> Option<Solid> {
    let vectors = patch.iter().map(|t| (t[1] - t[0]).cross(t[2] - t[0]));
    let facing: DVec3 = vectors.clone().sum();
    let one_sided = facing.length() > 0.3 * vectors.map(DVec3::length).sum::<f64>();
    let mut points: Vec<_> = patch.iter().flatten().copied().collect();
    let error = (0.1 * clearance).min(0.1 * width);
    for round in 0..4 {
        let hull = Solid::of(&points, MAX_CORNERS, error);
        let (thin, breadth) = match &hull {
            Some(solid) => solid.narrowest(),
            None => (largest_normal(patch)?, 0.0),
        };
        if breadth >= width {
            return hull;
        }
        let missing = 1.15 * width - breadth;
        let inward = if facing.dot(thin) > 0.0 { -thin } else { thin };
        let front = if one_sided && round == 0 { 0.0 } else { missing / 2.0 };
        let back = missing - front;
        let moved = points.iter().flat_map(|&p| [p + inward * back, p - inward * front]);
        points = moved.collect();
    }
    None
}

fn largest_normal(patch: &[[DVec3; 3]]) -> Option<DVec3> {
    let vectors = patch.iter().map(|t| (t[1] - t[0]).cross(t[2] - t[0]));
    let largest = vectors.fold(DVec3::ZERO, |a, b| if b.length() > a.length() { b } else { a });
    largest.try_normalize()
}
