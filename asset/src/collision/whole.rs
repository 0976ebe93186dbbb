//! A part's surface before it is cut, and what was learnt of it: attempts ask the same again.

use std::sync::{Mutex, OnceLock, PoisonError};

use object::Mesh;

use crate::collision::agreement;
use crate::collision::hulls::surface::Surface;
use crate::collision::piece::ConvexPiece;
use crate::collision::solid::Solid;
use crate::surface::seal;

/// A whole surface, and how far it lies from pieces it was held against.
pub(crate) struct Whole<'a> {
    pub(crate) mesh: &'a Mesh,
    surface: OnceLock<(Surface, bool)>,
    gaps: Mutex<Vec<Known>>,
}

struct Known {
    pieces: Vec<ConvexPiece>,
    tolerance: f64,
    gap: f64,
}

impl<'a> Whole<'a> {
    /// Nothing is known of it yet.
    pub(crate) fn new(mesh: &'a Mesh) -> Self {
        Self { mesh, surface: OnceLock::new(), gaps: Mutex::default() }
    }

    /// What [`agreement::gap`] says of it and these pieces, which are `solids`.
    pub(crate) fn gap(&self, pieces: &[ConvexPiece], solids: &[Solid], tolerance: f64) -> f64 {
        let gaps = || self.gaps.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |k: &&Known| k.tolerance == tolerance && k.pieces == pieces;
        if let Some(known) = gaps().iter().find(is_same) {
            return known.gap;
        }
        let ready = || (Surface::new(self.mesh), seal::is_closed(self.mesh));
        let (surface, is_closed) = self.surface.get_or_init(ready);
        let gap = agreement::gap_of(self.mesh, (surface, *is_closed), solids, tolerance);
        gaps().push(Known { pieces: pieces.to_vec(), tolerance, gap });
        gap
    }
}
