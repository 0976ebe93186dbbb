//! USD file → mesh: USDA, USDC and USDZ, meshes with materials (`UsdPreviewSurface`) and colours.
//!
//! One file is read, and the pictures it names; layers that lie in other files are left out and named, but for
//! [`read_prims`], which is told how to come by them. Every
//! prim's transform is baked, the up axis and unit are the file's own. What the library that reads the layers
//! does with broken files is fenced: what a binary layer counts is checked before, it works in a thread of its
//! own that has a deadline, and the program lets it work in a process of its own ([`apart`]).

pub mod apart;
mod archive;
mod bounds;
mod build;
mod composed;
mod error;
mod extract;
mod look;
mod names;
pub mod prims;
mod scene;
mod stage;
mod walk;

pub use composed::read_prims;
pub use error::UsdError;

use crate::beside::Beside;
use crate::mesh::UpAxis;
use crate::reading::Reading;

/// Reads a USD file of any form. `up` counts where the file does not say its own; faces come out in the order
/// of the prims and of their faces, a polygon as a fan from its first corner.
///
/// # Errors
/// [`UsdError`], the first broken rule.
pub fn read(bytes: Vec<u8>, up: UpAxis, beside: Beside<'_>) -> Result<Reading, UsdError> {
    let (bytes, mut pictures) = archive::opened(bytes)?;
    let scene = apart::scene(bytes)?;
    build::reading(scene, up, &mut |name| match pictures.take(name) {
        Some(found) => Ok(found),
        None => beside(name),
    })
}

/// Reads what [`apart::answer`] said of a layer.
///
/// # Errors
/// [`UsdError`], the first broken rule.
pub fn of_answer(answer: &[u8], up: UpAxis, beside: Beside<'_>) -> Result<Reading, UsdError> {
    build::reading(apart::taken(answer)?, up, beside)
}

/// Refuses a binary layer whose lists, paths and values cannot be what it says; of what it is read for nothing
/// is looked at.
///
/// # Errors
/// [`UsdError::Unreadable`] with the first broken rule.
pub fn counted(layer: &[u8]) -> Result<(), UsdError> {
    bounds::bounded(layer).map_err(UsdError::Unreadable)
}

#[cfg(test)]
mod tests;
