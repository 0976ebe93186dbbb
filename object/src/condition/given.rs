//! What a person says of the joints of an object, part by part.

use super::types::{GivenJoint, Prompt};
use crate::articulated::{JointMotion, Range};
use glamx::DVec3;

/// What is given of the joints of every part of an object. Ranges are in radians and metres; pivots in
/// the unit and the frame of the object's mesh, which is not yet placed.
#[derive(Clone, Debug, Default)]
pub struct GivenJoints(Vec<Vec<GivenJoint>>);

/// What is given of the joints of each part, in the order of the parts.
impl FromIterator<Vec<GivenJoint>> for GivenJoints {
    fn from_iter<I: IntoIterator<Item = Vec<GivenJoint>>>(parts: I) -> Self {
        Self(parts.into_iter().collect())
    }
}

impl GivenJoints {
    /// What the prompts of an object's parts say.
    pub fn of(prompts: &[Option<&Prompt>]) -> Self {
        prompts.iter().map(|p| p.map_or(vec![], |p| p.joints.clone())).collect()
    }

    /// What is given of one joint.
    pub fn joint(&self, part: usize, index: usize) -> GivenJoint {
        self.0.get(part).and_then(|joints| joints.get(index)).copied().unwrap_or_default()
    }

    /// Whether the place of a joint's axis is given.
    pub fn has_place(&self, part: usize, index: usize) -> bool {
        let given = self.joint(part, index);
        given.pivot.is_some() || given.axis.is_some()
    }

    /// Whether the lower and the upper end of a joint's range are given.
    pub fn ends(&self, part: usize, index: usize) -> [bool; 2] {
        let given = self.joint(part, index);
        [given.range.is_some() || given.open_by.is_some(), given.range.is_some()]
    }

    /// Motions of a placed object, metres, with what is given in the place of what was found: to the last
    /// bit, whatever was lost in between.
    pub fn kept(
        &self,
        motions: Vec<Vec<JointMotion>>,
        (scale, offset): (f64, DVec3),
    ) -> Vec<Vec<JointMotion>> {
        let keep = |(part, motions): (usize, Vec<JointMotion>)| {
            let one = |(index, found): (usize, JointMotion)| {
                let given = self.joint(part, index);
                let mut motion = found;
                motion.axis = given.axis.unwrap_or(motion.axis);
                motion.pivot = given.pivot.map_or(motion.pivot, |p| p * scale + offset);
                motion.range = match (given.range, given.open_by, motion.range) {
                    (Some(range), ..) => range,
                    (None, Some(open_by), Range::Limits { upper, .. }) => {
                        Range::Limits { lower: -open_by, upper }
                    }
                    (None, _, range) => range,
                };
                motion
            };
            motions.into_iter().enumerate().map(one).collect()
        };
        motions.into_iter().enumerate().map(keep).collect()
    }
}
