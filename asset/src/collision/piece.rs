//! A convex collision piece, how many a link may have, and what they hold.

use glamx::DVec3;
use serde::{Deserialize, Serialize};

/// Most pieces of one link.
pub const MAX_PIECES: usize = 32;
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

/// Breadth, metres, below which no piece of an object judged with this tolerance may be.
pub(crate) fn least_width(tolerance: f64) -> f64 {
    (0.12 * tolerance).min(0.0013)
}

/// Volume of convex pieces, m³.
pub(crate) fn held(pieces: &[ConvexPiece]) -> f64 {
    let volume = |p: &ConvexPiece| -> f64 {
        let corner = |v: u32| p.vertices.get(v as usize).copied().unwrap_or(DVec3::ZERO);
        let cone = |[a, b, c]: [DVec3; 3]| a.dot(b.cross(c)) / 6.0;
        p.faces.iter().map(|f| cone(f.map(corner))).sum()
    };
    pieces.iter().map(volume).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::block;

    #[test]
    fn pieces_hold_their_volumes_added_up() {
        let piece = |size: DVec3| {
            let mesh = block(size, DVec3::new(3.0, -1.0, 2.0));
            ConvexPiece { vertices: mesh.vertices().to_vec(), faces: mesh.faces().to_vec() }
        };
        let both = [piece(DVec3::ONE), piece(DVec3::new(1.0, 2.0, 0.25))];
        assert!((held(&both) - 1.5).abs() < 1e-12, "{}", held(&both));
        assert_eq!(held(&[]), 0.0);
    }

    #[test]
    fn the_least_breadth_grows_with_the_object_up_to_a_millimetre_and_a_third() {
        assert_eq!([least_width(0.005), least_width(0.02)], [0.12 * 0.005, 0.0013]);
    }
}
