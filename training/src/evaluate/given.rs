//! What a case gives to whoever answers, and who supplies the rest: the paper's three settings
//! ("Comparisons").

use std::error::Error;
use std::path::Path;
use std::str::FromStr;

use object::{Condition, Mesh};
use serde::Serialize;

/// What is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Mode {
    /// The mesh and the kinematic condition, whose parts are the true ones by number.
    #[default]
    #[serde(rename = "mesh+kinematic")]
    MeshAndKinematic,
    /// The mesh, and a picture; which parts there are is proposed.
    #[serde(rename = "mesh")]
    Mesh,
    /// A picture; the mesh is generated, and which parts there are is proposed.
    #[serde(rename = "image")]
    Image,
}

/// A word that is no mode.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected mesh+kinematic, mesh or image, found `{0}`")]
pub struct ModeError(String);

impl FromStr for Mode {
    type Err = ModeError;

    fn from_str(text: &str) -> Result<Self, ModeError> {
        let all = [Self::MeshAndKinematic, Self::Mesh, Self::Image];
        all.into_iter().find(|m| m.name() == text).ok_or_else(|| ModeError(text.into()))
    }
}

impl Mode {
    /// As written on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::MeshAndKinematic => "mesh+kinematic",
            Self::Mesh => "mesh",
            Self::Image => "image",
        }
    }

    /// Whether parts of both sides are the same by number.
    pub fn has_numbers(self) -> bool {
        self == Self::MeshAndKinematic
    }

    /// Whether both sides label the same surface.
    pub fn has_surface(self) -> bool {
        self != Self::Image
    }
}

/// What an articulator is asked about.
#[derive(Clone, Debug)]
pub struct Given {
    /// The surface: the case's own, or another in a frame and unit of its own.
    pub mesh: Mesh,
    /// The question; its parts go by whatever numbers whoever proposed them gave.
    pub condition: Condition,
}

/// Supplies what a case does not give.
///
/// Promise: the condition belongs to the mesh; in [`Mode::Mesh`] the mesh is the case's own, face by
/// face; nothing of the case's condition or truth is looked at.
pub trait Supply: Send + Sync {
    /// What is taken from the case.
    fn mode(&self) -> Mode;

    /// Who supplies, with version.
    fn identity(&self) -> String;

    /// What belongs to the case in a folder.
    ///
    /// # Errors
    /// [`SupplyError`], naming the file or service and what was found.
    fn given(&self, folder: &Path) -> Result<Given, SupplyError>;
}

/// Why something was not supplied.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct SupplyError(#[from] pub Box<dyn Error + Send + Sync>);
