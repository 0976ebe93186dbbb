//! How sure an articulation is of itself: calibrated probabilities, for each part and each joint.

use glamx::DVec3;
use serde::{Deserialize, Serialize};

/// How likely an articulation is right. Every number is a probability, 0 to 1; what a person gave is exactly
/// 1, and nothing else is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Confidence {
    /// That every part and every joint is right.
    pub object: f64,
    /// One for each part of the object, in its order.
    pub parts: Vec<PartConfidence>,
}

/// How likely a part and its joints are right.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartConfidence {
    /// That its surface is the true one, to an intersection over union of 0.75.
    pub labels: f64,
    /// The piece of it that is likeliest another part's, if any may be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<Doubt>,
    /// One for each of its joints, in order; none for the base.
    pub joints: Vec<JointConfidence>,
}

/// A piece of a part's surface that may be another part's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Doubt {
    /// That other part, by its place in the object's tree.
    pub other: usize,
    /// How likely the piece is of that part, 0 to 1, as the classifier has it, uncalibrated.
    pub chance: f64,
    /// How large it is, as a share of the part's surface, 0 to 1.
    pub share: f64,
    /// A point on it, in the mesh's frame and unit.
    pub at: DVec3,
}

/// How likely a joint is right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointConfidence {
    /// That its axis is within 15° of the true one, whichever way it points.
    pub axis: f64,
    /// That its line is where it ought to be, to 5 % of the object's largest extent; nothing for a slide,
    /// which has no place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<f64>,
    /// That it goes the right way where its axis is right: the one that it ought to, or both; nothing for an
    /// endless joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub way: Option<f64>,
    /// That all of these are right.
    pub joint: f64,
    /// The likeliest other axis, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instead: Option<OtherAxis>,
}

/// An axis that a joint may have instead.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherAxis {
    /// Unit direction, either way round, in the mesh's frame.
    pub axis: DVec3,
    /// A point on it, in the mesh's frame and unit.
    pub pivot: DVec3,
    /// How likely it is right where the one that was found is not, 0 to 1, uncalibrated.
    pub chance: f64,
}

impl Confidence {
    /// The same in another frame: every place moved, every direction turned.
    #[must_use]
    pub fn moved(
        mut self,
        place: impl Fn(DVec3) -> DVec3,
        turned: impl Fn(DVec3) -> DVec3,
    ) -> Self {
        for part in &mut self.parts {
            if let Some(doubt) = &mut part.doubt {
                doubt.at = place(doubt.at);
            }
            for other in part.joints.iter_mut().filter_map(|joint| joint.instead.as_mut()) {
                other.axis = turned(other.axis);
                other.pivot = place(other.pivot);
            }
        }
        self
    }

    /// The least of what is said of a part and its joints, 0 to 1; 1 for a part that is not there.
    pub fn of_part(&self, part: usize) -> f64 {
        let joints =
            |part: &PartConfidence| part.joints.iter().map(|j| j.joint).collect::<Vec<_>>();
        let part = self.parts.get(part);
        part.map_or(1.0, |p| joints(p).into_iter().fold(p.labels, f64::min))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_as_sure_as_the_least_of_its_labels_and_joints() {
        let joint =
            |joint| JointConfidence { axis: 1.0, line: None, way: None, joint, instead: None };
        let part = |labels, joints| PartConfidence { labels, doubt: None, joints };
        let parts = vec![part(0.9, vec![]), part(0.8, vec![joint(0.7), joint(0.95)])];
        let confidence = Confidence { object: 0.5, parts };
        assert_eq!([0, 1, 2].map(|p| confidence.of_part(p)), [0.9, 0.7, 1.0]);
    }
}
