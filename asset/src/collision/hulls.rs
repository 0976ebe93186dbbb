//! Convex collision pieces of a link: few, fat, close to the surface and hollow where it is.
//!
//! Connected components whose hull fills no hollow become one piece; the others are cut along
//! their own flat sides until every hull is clean, then neighbours are merged again.
//!
//! ```
//! use asset::collision::hulls::decompose;
//! use object::{DVec3, Mesh};
//! let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
//! let mesh = Mesh::new(corners, faces)?;
//! let pieces = decompose(&mesh, 0.02)?;
//! assert_eq!((pieces.len(), pieces[0].vertices.len()), (1, 4));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod emptiness;
pub(crate) mod merge;
pub(crate) mod split;
pub(crate) mod surface;

#[cfg(test)]
pub(crate) mod tests;

use std::sync::{Arc, Mutex, PoisonError};

use glamx::DVec3;
use object::mesh::Mesh;
use object::weld::Weld;

use crate::collision::cover::Cover;
use crate::collision::piece::{ConvexPiece, MAX_VERTICES, held, least_width};
use crate::collision::solid::Solid;
use crate::error::HullError;
use emptiness::Emptiness;
use split::Gate;
use surface::Surface;

/// Hollows deeper than this share of the tolerance are kept free.
const CLEARANCE: f64 = 0.2;

/// How close pieces keep to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fineness {
    /// No place on a piece lies deeper in a hollow than this share of the tolerance...
    deepest: f64,
    /// ...as far as so many places on its sides tell.
    looked_at: usize,
    /// Neighbours are merged down to so many pieces where that fills no hollow.
    few: usize,
}

/// Few pieces, quickly found.
pub(crate) const COARSE: Fineness = Fineness { deepest: 0.8, looked_at: 300, few: 10 };
/// The same, looked at closely.
pub(crate) const FINE: Fineness = Fineness { deepest: 0.8, looked_at: 900, few: 10 };
/// Smaller pieces.
pub(crate) const SMALL: Fineness = Fineness { deepest: 0.35, looked_at: 900, few: 24 };

/// Where there are too many pieces, one may go if others cover its surface within this share of
/// the tolerance, less what [`Cover`] keeps in hand.
const SERVED: f64 = 0.8;
/// At most [`MAX_PIECES`](crate::collision::piece::MAX_PIECES) convex pieces that cover a link's surface (object frame, metres) and
/// leave its hollows free.
///
/// `tolerance` is how far pieces and surface may lie apart, metres: a share of the whole object's
/// size, not the link's. A flat sheet gets a little thickness inward.
///
/// # Errors
/// [`HullError`] if the tolerance is not positive or no face has an area.
pub fn decompose(link: &Mesh, tolerance: f64) -> Result<Vec<ConvexPiece>, HullError> {
    Decomposer::new(link, tolerance)?.pieces(COARSE)
}

/// A link ready to be decomposed, more or less finely; what is learnt of its surface is kept from
/// one time to the next.
#[derive(Clone)]
pub(crate) struct Decomposer<'a> {
    link: &'a Mesh,
    /// How far pieces and surface may lie apart, metres.
    tolerance: f64,
    /// How far they do where that takes no more pieces than may be, metres.
    close: f64,
    clearance: f64,
    empty: Arc<Emptiness>,
    cover: Arc<Cover>,
    surface: Arc<Surface>,
    /// What was made before, also while it kept closer or less close: of many attempts some ask the same.
    made: Arc<Mutex<Vec<Made>>>,
}

/// Pieces, and what they follow from for one link.
struct Made {
    close: f64,
    depths: (f64, f64),
    fineness: Fineness,
    pieces: Vec<ConvexPiece>,
}

impl<'a> Decomposer<'a> {
    /// `tolerance` as for [`decompose`].
    pub(crate) fn new(link: &'a Mesh, tolerance: f64) -> Result<Self, HullError> {
        if !(tolerance.is_finite() && tolerance > 0.0) {
            return Err(HullError::Tolerance(tolerance));
        }
        let clearance = clearance(link, tolerance);
        let surface = Arc::new(Surface::new(link));
        let depths = (clearance, tolerance);
        let empty = Arc::new(Emptiness::new(Arc::clone(&surface), &link.bounds(), depths));
        let cover = Arc::new(Cover::new(link, 0, SERVED * tolerance));
        let made = Arc::default();
        Ok(Self { link, tolerance, close: tolerance, clearance, empty, cover, surface, made })
    }

    /// The same, keeping so close to the surface, metres, as far as the number of pieces allows.
    pub(crate) fn keeping(&self, close: f64) -> Self {
        let clearance = clearance(self.link, close);
        let (bounds, depths) = (self.link.bounds(), (clearance, self.tolerance));
        let empty = if self.empty.serves(&bounds, depths) {
            Arc::clone(&self.empty)
        } else {
            Arc::new(Emptiness::new(Arc::clone(&self.surface), &bounds, depths))
        };
        Self { close, clearance, empty, ..self.clone() }
    }

    /// Whether it keeps closer to the surface than it has to.
    pub(crate) fn is_closer(&self) -> bool {
        self.close < self.tolerance
    }

    /// Share of the surface that lies too far from all of these pieces.
    pub(crate) fn bare(&self, pieces: &[ConvexPiece]) -> f64 {
        self.cover.uncovered(&self.cover.nearest(self.rows(pieces).iter()))
    }

    /// For each piece, how far the surface lies from it.
    fn rows(&self, pieces: &[ConvexPiece]) -> Vec<Vec<f64>> {
        let solid = |p: &ConvexPiece| Solid::of(&p.vertices, MAX_VERTICES, 0.0);
        let row = |p| solid(p).map_or_else(Vec::new, |solid| self.cover.row(&solid));
        pieces.iter().map(row).collect()
    }

    /// These pieces without some whose surface the others serve, the one whose loss costs least first,
    /// while they fill more than `most`, added up; none may leave less than `least`, m³.
    pub(crate) fn thinned(
        &self,
        mut pieces: Vec<ConvexPiece>,
        (least, most): (f64, f64),
    ) -> Vec<ConvexPiece> {
        if held(&pieces) <= most {
            return pieces;
        }
        let mut rows = self.rows(&pieces);
        while held(&pieces) > most {
            let spare = held(&pieces) - least;
            let known: Vec<_> = rows.iter().collect();
            let is_small = |i: usize| held(&pieces[i..=i]) <= spare;
            let Some(gone) = self.cover.spare(&known, is_small) else { break };
            pieces.remove(gone);
            rows.remove(gone);
        }
        pieces
    }

    /// The pieces, as [`decompose`] gives them.
    pub(crate) fn pieces(&self, fineness: Fineness) -> Result<Vec<ConvexPiece>, HullError> {
        let (close, depths) = (self.close, self.empty.made_for());
        let made = || self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |m: &&Made| (m.close, m.depths, m.fineness) == (close, depths, fineness);
        if let Some(known) = made().iter().find(is_same) {
            return Ok(known.pieces.clone());
        }
        let pieces = self.pieces_anew(fineness)?;
        made().push(Made { close, depths, fineness, pieces: pieces.clone() });
        Ok(pieces)
    }

    fn pieces_anew(&self, fineness: Fineness) -> Result<Vec<ConvexPiece>, HullError> {
        let gate = Gate {
            empty: &self.empty,
            clearance: self.clearance,
            deepest: fineness.deepest * self.close,
            looked_at: fineness.looked_at,
            width: least_width(self.tolerance),
        };
        let solids = split::split(components(self.link), &gate);
        if solids.is_empty() {
            return Err(HullError::NoArea { faces: self.link.faces().len() });
        }
        let merged = merge::merge(solids, &gate, &self.cover, self.tolerance, fineness.few);
        Ok(merged.iter().filter_map(Solid::to_piece).collect())
    }
}

/// Hollows deeper than this are kept free where pieces keep so close to a surface, metres.
fn clearance(link: &Mesh, close: f64) -> f64 {
    (CLEARANCE * close).min(0.04 * link.bounds().diagonal())
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
