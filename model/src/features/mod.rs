//! What the network sees of texts and of surfaces: encoders behind two narrow traits.

pub mod clip;
pub mod geometric;
pub mod moments;
pub mod regions;
pub mod text;

use object::sample::SurfacePoint;
use object::{DVec3, Mesh};

use crate::net::NetworkError;

pub use clip::{ClipError, ClipText};
pub use geometric::GeometricFeatures;
pub use text::{NgramText, TextFeatures};

/// Describes points of a surface by numbers.
///
/// Promise: [`PointFeatures::width`] finite numbers for each point, row-major, that depend on the
/// mesh and the point alone: the same for any number of threads and whichever other points are
/// asked about.
pub trait PointFeatures: Send + Sync {
    /// Name and version; changes whenever results may.
    fn identity(&self) -> String;

    /// Numbers for each point.
    fn width(&self) -> usize;

    /// Features of points of `mesh`, object frame; `frame` is the unit cube the network works in.
    ///
    /// # Errors
    /// [`FeatureError`] when the surface cannot be described.
    fn encode(
        &self,
        mesh: &Mesh,
        frame: UnitCube,
        points: &[SurfacePoint],
    ) -> Result<Vec<f32>, FeatureError>;
}

/// Why texts or surfaces could not be described.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FeatureError {
    /// A text longer than allowed.
    #[error("a text may have at most {limit} characters, found {found}")]
    TextTooLong {
        /// The limit.
        limit: usize,
        /// How many it has.
        found: usize,
    },
    /// A text of more tokens than its encoder has places for; none is cut.
    #[error("a text may have at most {limit} tokens, found {found}")]
    TooManyTokens {
        /// The limit.
        limit: usize,
        /// How many it has.
        found: usize,
    },
    /// A text encoder that gave no answer.
    #[error("the text encoder: {0}")]
    Encoder(#[from] NetworkError),
    /// A surface without area.
    #[error("the surface has no area, so no point of it can be described")]
    NoArea,
    /// A feature that is not a number.
    #[error("feature {feature} of point {point} is not finite")]
    NotFinite {
        /// Which point.
        point: usize,
        /// Which feature.
        feature: usize,
    },
}

/// The cube [−½, ½]³ the network works in: centre and longest side of the object's box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitCube {
    /// What becomes the origin, object frame, metres.
    pub centre: DVec3,
    /// What becomes length 1, metres.
    pub side: f64,
}

impl UnitCube {
    /// The cube of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        let bounds = mesh.bounds();
        Self { centre: bounds.centre(), side: bounds.size().max_element() }
    }

    /// Object frame, metres → unit cube.
    pub fn inside(&self, p: DVec3) -> DVec3 {
        (p - self.centre) / self.side
    }

    /// Unit cube → object frame, metres.
    pub fn outside(&self, p: DVec3) -> DVec3 {
        p * self.side + self.centre
    }
}
