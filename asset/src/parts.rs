//! An object's parts on the way to an asset: what is known of each.

use object::condition::GivenJoints;
use object::{ArticulatedObject, JointMotion, Mesh};

use crate::collision::piece::ConvexPiece;
use crate::mass::materials::Substance;
use crate::mass::weigh::Body;
use crate::surface::repaired::Surface;

/// Everything known about the parts once they are placed, repaired, cleared and weighed.
pub(crate) struct Parts {
    /// Metres, asset frame; joints as cleared.
    pub(crate) object: ArticulatedObject,
    /// What a person says of their joints.
    pub(crate) given: GivenJoints,
    /// Motions before they were cleared, for the record.
    pub(crate) wanted: Vec<Vec<JointMotion>>,
    pub(crate) surfaces: Vec<Surface>,
    /// The surfaces less what other parts hide for good.
    pub(crate) seen: Vec<Mesh>,
    pub(crate) pieces: Vec<Vec<ConvexPiece>>,
    pub(crate) substances: Vec<Substance>,
    pub(crate) bodies: Vec<Body>,
}

/// The motions of every part.
pub(crate) fn motions(object: &ArticulatedObject) -> Vec<Vec<JointMotion>> {
    (0..object.tree().len()).map(|p| object.joints(p).to_vec()).collect()
}
