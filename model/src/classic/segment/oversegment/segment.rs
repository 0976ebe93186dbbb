//! A segment: a piece of the surface that is given to one part as a whole, and what is known of it
//! by itself.

use object::DVec3;
use object::mesh::Bounds;

/// A segment of the surface: a component, or a patch of a component that holds several prompts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Segment {
    /// The part a prompt gives it, if any.
    pub seed: Option<u16>,
    /// Its share of the whole surface, 0 to 1.
    pub share: f64,
    /// Area, m².
    pub area: f64,
    /// Mean of its faces' centroids, weighted by area, object frame, metres.
    pub centre: DVec3,
    /// Its box, object frame, metres.
    pub bounds: Bounds,
    /// Mean of its faces' normals, weighted by area: a unit vector where it is flat.
    pub normal: DVec3,
}
