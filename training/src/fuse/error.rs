//! Why an object cannot be fused.

use object::articulated::ObjectError;
use object::kinematics::TreeError;
use object::mesh::MeshError;

/// Why an object cannot be fused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FuseError {
    /// The skin.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// What is left of the tree.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// What is left of the object.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// Too coarse or too fine a grid.
    #[error("a skin needs between 8 and 256 cells along its longest side, found {0}")]
    Cells(usize),
    /// Distances that make no skin.
    #[error(
        "a skin lies more than 0.5 and at most 2 cells out and keeps clear by 0 to 2.5, found {0} and {1}"
    )]
    Distances(f64, f64),
    /// What is no recipe.
    #[error("a skin is CELLS[:FACES[:OFFSET[:CLEARANCE[:even]]]], found `{0}`")]
    Recipe(String),
    /// Parts no face of the skin belongs to.
    #[error("only {left} of {parts} parts can be seen from outside")]
    Hidden {
        /// Parts that are left.
        left: usize,
        /// Parts there were.
        parts: usize,
    },
}
