//! Collision pieces of all parts, cleared of each other at rest and along every range.

use object::ArticulatedObject;
use rayon::prelude::*;

use crate::build::{AssetError, BuildOptions};
use crate::change::Change;
use crate::clearance::{ClearanceOptions, Cleared, clear};
use crate::hinges;
use crate::hulls::{ConvexPiece, decompose};
use crate::repair::Surface;

/// Pieces per part, and the object with ranges that are free of contact.
pub(crate) struct Collision {
    pub(crate) object: ArticulatedObject,
    pub(crate) pieces: Vec<Vec<ConvexPiece>>,
    /// The pieces before they were cleared of each other: what each part fills, as it is seen.
    pub(crate) whole: Vec<Vec<ConvexPiece>>,
    pub(crate) changes: Vec<Change>,
}

/// Decomposes every part and clears the pieces of each other. Metres, asset frame.
pub(crate) fn collision(
    object: ArticulatedObject,
    surfaces: &[Surface],
    options: &BuildOptions,
) -> Result<Collision, AssetError> {
    let diagonal = object.mesh().bounds().diagonal();
    let room = ClearanceOptions { seed: options.seed, ..ClearanceOptions::for_diagonal(diagonal) };
    let name = |part: usize| object.tree().parts()[part].name.clone();
    let one = |(part, surface): (usize, &Surface)| {
        decompose(&surface.mesh, room.tolerance)
            .map_err(|source| AssetError::Collision { part: name(part), source })
    };
    let pieces = surfaces.par_iter().enumerate().map(one).collect::<Result<Vec<_>, _>>()?;
    let (joints, mut changes) = hinges::settle(&object, &pieces);
    let object = object.clone().with_joints(joints)?;
    let whole = pieces.clone();
    let Cleared { pieces, joints, changes: cleared } = clear(&object, pieces, &room);
    changes.extend(cleared);
    if let Some(part) = pieces.iter().position(Vec::is_empty) {
        return Err(AssetError::NoPieceLeft(name(part)));
    }
    Ok(Collision { object: object.with_joints(joints)?, pieces, whole, changes })
}
