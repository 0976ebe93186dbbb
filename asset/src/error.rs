//! Why no asset can be built, naming the part, the rule and what was found.
//!
//! ```
//! use asset::AssetError;
//! let told = AssetError::PartMap { parts: 3, found: 2 }.to_string();
//! assert_eq!(told, "the condition has 3 parts, but 2 are mapped to the object");
//! ```

use object::articulated::ObjectError;
use object::mesh::MeshError;

/// Why no asset can be built.
#[derive(Debug, thiserror::Error)]
pub enum AssetError {
    /// The map from condition to object does not fit them.
    #[error("the condition has {parts} parts, but {found} are mapped to the object")]
    PartMap {
        /// Parts of the condition.
        parts: usize,
        /// Entries of the map.
        found: usize,
    },
    /// A part of the condition is mapped to a part that is not there.
    #[error("part `{part}` of the condition is mapped to part {index}, but the object has {parts}")]
    UnknownPart {
        /// The condition's part.
        part: String,
        /// The index given.
        index: usize,
        /// Parts of the object.
        parts: usize,
    },
    /// The object has no extent where the condition gives its size.
    #[error("the scale must be a finite number above 0, found {found}: {how}")]
    Scale {
        /// The scale.
        found: f64,
        /// How it came about.
        how: String,
    },
    /// A part without a face that has an area, or a surface that cannot be placed.
    #[error("{part}: no usable surface")]
    Surface {
        /// The part, or the whole object.
        part: String,
        /// The broken rule.
        #[source]
        source: MeshError,
    },
    /// No collision pieces for a part.
    #[error("part `{part}` gets no collision pieces")]
    Collision {
        /// The part.
        part: String,
        /// Why.
        #[source]
        source: HullError,
    },
    /// Every collision piece of a part had to give way to others.
    #[error("part `{0}` keeps no collision piece clear of the other parts")]
    NoPieceLeft(String),
    /// An intermediate result broke a rule of articulated objects.
    #[error(transparent)]
    Object(#[from] ObjectError),
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

/// The error of a rule that the object as a whole breaks.
pub(crate) fn whole_surface(source: MeshError) -> AssetError {
    AssetError::Surface { part: "whole object".into(), source }
}
