//! Why a family could not be built.

use object::articulated::ObjectError;
use object::kinematics::TreeError;
use object::mesh::MeshError;

/// Why a family could not be built: a fault of its rules.
#[derive(Debug, thiserror::Error)]
pub enum FamilyError {
    /// There is none of this name.
    #[error("there is no family `{0}`")]
    Unknown(String),
    /// Its surface.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Its tree.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// Its joints.
    #[error(transparent)]
    Object(#[from] ObjectError),
}
