//! What a joint moves.

use glamx::DVec3;

use crate::asset::{Asset, Joint, JointType};

/// What a joint moves at rest: kg m² about its axis for a turn, kg for a slide.
pub(crate) fn inertia(asset: &Asset, joint: &Joint) -> f64 {
    let Some(motion) = &joint.motion else { return 0.0 };
    let (mut below, mut total) = (vec![joint.child], 0.0);
    let pivot = asset.links.get(joint.child).map_or(DVec3::ZERO, |l| l.frame);
    let axis = motion.axis.value;
    while let Some(at) = below.pop() {
        let Some(link) = asset.links.get(at) else { continue };
        let i = &link.inertial;
        total += match joint.kind {
            JointType::Prismatic => i.mass.value,
            _ => {
                let arm = axis.cross(link.frame + i.centre.value - pivot).length_squared();
                axis.dot(i.inertia.value * axis) + i.mass.value * arm
            }
        };
        below.extend(asset.joints.iter().filter(|j| j.parent == at).map(|j| j.child));
    }
    total
}
