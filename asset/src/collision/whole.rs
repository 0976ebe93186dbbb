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

#[cfg(test)]
mod tests {
    use glamx::DVec3;

    use super::*;
    use crate::collision::solid::MAX_CORNERS;
    use crate::tests::block;

    #[test]
    fn a_gap_that_is_asked_for_again_is_that_of_the_same_pieces() {
        let mesh = block(DVec3::ONE, DVec3::ZERO);
        let whole = Whole::new(&mesh);
        for size in [DVec3::new(1.05, 1.0, 1.0), DVec3::new(1.08, 1.0, 1.0)] {
            let of = block(size, DVec3::ZERO);
            let vertices = of.vertices().to_vec();
            let solids = [Solid::of(&vertices, MAX_CORNERS, 0.0).unwrap()];
            let pieces = [ConvexPiece { vertices, faces: of.faces().to_vec() }];
            let first = whole.gap(&pieces, &solids, 0.02);
            assert_eq!(first, agreement::gap(&mesh, &solids, 0.02));
            assert!(first > 1.0, "{size}: {first}");
            // Solids are not looked at where the pieces are known.
            assert_eq!(whole.gap(&pieces, &[], 0.02), first);
        }
        assert_eq!(whole.gaps.lock().unwrap().len(), 2);
    }
}
