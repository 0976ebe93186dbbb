//! An object whose parts are labelled and whose joints are known: the paper's (M, m, K, a, θ).

use glamx::DVec3;
use serde::{Deserialize, Serialize};

use crate::kinematics::{JointKind, KinematicTree};
use crate::mesh::Mesh;

/// How far a joint moves from the pose the mesh shows (q = 0).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Range {
    /// From `lower` to `upper`: radians for a turn, metres for a slide; lower ≤ 0 ≤ upper.
    Limits {
        /// Smallest value, ≤ 0.
        lower: f64,
        /// Largest value, ≥ 0.
        upper: f64,
    },
    /// Turns without end.
    Continuous,
}

impl Range {
    /// Length of the range; a full turn for a continuous joint.
    pub fn span(self) -> f64 {
        let (lower, upper) = self.ends();
        upper - lower
    }

    /// The same seen along the axis turned round.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::Limits { lower, upper } => Self::Limits { lower: -upper, upper: -lower },
            Self::Continuous => Self::Continuous,
        }
    }

    /// The same with both ends times a factor above 0, as lengths in another unit.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Limits { lower, upper } => {
                Self::Limits { lower: lower * factor, upper: upper * factor }
            }
            Self::Continuous => Self::Continuous,
        }
    }

    /// Both ends; ±π for a continuous joint.
    pub fn ends(self) -> (f64, f64) {
        use std::f64::consts::PI;
        match self {
            Self::Limits { lower, upper } => (lower, upper),
            Self::Continuous => (-PI, PI),
        }
    }
}

/// One fitted degree of freedom of a part, at the rest pose (q = 0), object frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointMotion {
    /// Turn or slide; agrees with the tree.
    pub kind: JointKind,
    /// Unit direction: a positive turn is counter-clockwise seen against it, a positive slide along it.
    pub axis: DVec3,
    /// A point on the axis, metres; for a slide, a point of the contact with the parent.
    pub pivot: DVec3,
    /// How far it moves.
    pub range: Range,
}

/// A mesh with a part for every face, and for every part the joints that tie it to its parent.
///
/// Built only through [`ArticulatedObject::new`]: one label per face, every part has a face, joints
/// agree with the tree, axes are unit, ranges hold the rest pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawObject", into = "RawObject")]
pub struct ArticulatedObject {
    mesh: Mesh,
    tree: KinematicTree,
    part_of_face: Vec<u16>,
    joints: Vec<Vec<JointMotion>>,
}

#[derive(Serialize, Deserialize)]
struct RawObject {
    tree: KinematicTree,
    joints: Vec<Vec<JointMotion>>,
    part_of_face: Vec<u16>,
    mesh: Mesh,
}

/// Why labels and joints do not make an articulated object.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ObjectError {
    /// Not one label per face.
    #[error("expected one part label per face ({faces}), found {labels}")]
    LabelCount {
        /// Faces of the mesh.
        faces: usize,
        /// Labels given.
        labels: usize,
    },
    /// A label no part has.
    #[error("face {face} is labelled {label}, but there are only {parts} parts")]
    UnknownLabel {
        /// Index of the face.
        face: usize,
        /// Its label.
        label: u16,
        /// Number of parts.
        parts: usize,
    },
    /// A part without a face.
    #[error("part `{0}` has no face")]
    EmptyPart(String),
    /// Fitted joints that are not the tree's.
    #[error("part `{part}`: the tree has joints {expected:?}, found {found:?}")]
    JointKinds {
        /// The part.
        part: String,
        /// What the tree says.
        expected: Vec<JointKind>,
        /// What was fitted.
        found: Vec<JointKind>,
    },
    /// An axis that is not a unit vector, or a pivot that is not finite.
    #[error("part `{part}`: axis {axis} must have length 1 and pivot {pivot} must be finite")]
    Axis {
        /// The part.
        part: String,
        /// Its axis.
        axis: DVec3,
        /// Its pivot.
        pivot: DVec3,
    },
    /// A range that leaves out the rest pose, or is not finite.
    #[error(
        "part `{part}`: range must be finite with lower <= 0 <= upper, found {lower} to {upper}"
    )]
    Range {
        /// The part.
        part: String,
        /// Its lower end.
        lower: f64,
        /// Its upper end.
        upper: f64,
    },
}

impl ArticulatedObject {
    /// Proves the invariants of [`ArticulatedObject`]. `joints` holds, for each part of the tree,
    /// its motions in the order of [`crate::Part::joints`].
    ///
    /// # Errors
    /// [`ObjectError`], the first broken rule.
    pub fn new(
        mesh: Mesh,
        tree: KinematicTree,
        part_of_face: Vec<u16>,
        joints: Vec<Vec<JointMotion>>,
    ) -> Result<Self, ObjectError> {
        let object = Self { mesh, tree, part_of_face, joints };
        object.check_labels()?;
        object.check_joints()?;
        Ok(object)
    }

    fn check_labels(&self) -> Result<(), ObjectError> {
        let (faces, labels) = (self.mesh.faces().len(), self.part_of_face.len());
        if faces != labels {
            return Err(ObjectError::LabelCount { faces, labels });
        }
        let parts = self.tree.len();
        let mut seen = vec![false; parts];
        for (face, &label) in self.part_of_face.iter().enumerate() {
            let slot = seen.get_mut(usize::from(label));
            *slot.ok_or(ObjectError::UnknownLabel { face, label, parts })? = true;
        }
        match seen.iter().position(|s| !s) {
            Some(p) => Err(ObjectError::EmptyPart(self.tree.parts()[p].name.clone())),
            None => Ok(()),
        }
    }

    fn check_joints(&self) -> Result<(), ObjectError> {
        for (p, part) in self.tree.parts().iter().enumerate() {
            let motions = self.joints.get(p).map_or(&[][..], Vec::as_slice);
            let found: Vec<_> = motions.iter().map(|m| m.kind).collect();
            if found != part.joints {
                let (part, expected) = (part.name.clone(), part.joints.clone());
                return Err(ObjectError::JointKinds { part, expected, found });
            }
            motions.iter().try_for_each(|m| check_motion(&part.name, m))?;
        }
        Ok(())
    }

    /// The surface at the rest pose.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Parts and who hangs on whom.
    pub fn tree(&self) -> &KinematicTree {
        &self.tree
    }

    /// The part each face belongs to.
    pub fn part_of_face(&self) -> &[u16] {
        &self.part_of_face
    }

    /// The fitted motions of a part, the first nearest the parent.
    pub fn joints(&self, part: usize) -> &[JointMotion] {
        &self.joints[part]
    }

    /// Faces of one part, ascending.
    pub fn faces_of(&self, part: usize) -> impl Iterator<Item = usize> {
        let is_mine = move |&(_, &p): &(usize, &u16)| usize::from(p) == part;
        self.part_of_face.iter().enumerate().filter(is_mine).map(|(f, _)| f)
    }

    /// The same object with other motions (a range cut, an axis turned round).
    ///
    /// # Errors
    /// [`ObjectError`] if the motions break a rule.
    pub fn with_joints(self, joints: Vec<Vec<JointMotion>>) -> Result<Self, ObjectError> {
        Self::new(self.mesh, self.tree, self.part_of_face, joints)
    }

    /// The same parts and joints on another surface, every face of which has its part (one that was cut
    /// up, mended or made simpler).
    ///
    /// # Errors
    /// [`ObjectError`] if labels do not fit the surface.
    pub fn with_surface(&self, mesh: Mesh, part_of_face: Vec<u16>) -> Result<Self, ObjectError> {
        Self::new(mesh, self.tree.clone(), part_of_face, self.joints.clone())
    }

    /// The same object moved and scaled: every point p becomes `scale · p + offset`; slides and
    /// pivots scale along, angles stay.
    ///
    /// # Errors
    /// [`crate::mesh::MeshError`] if the result has no extent.
    pub fn scaled(&self, scale: f64, offset: DVec3) -> Result<Self, crate::mesh::MeshError> {
        let mesh = self.mesh.map_vertices(|v| v * scale + offset)?;
        let motion = |m: &JointMotion| JointMotion {
            pivot: m.pivot * scale + offset,
            range: match m.range {
                Range::Limits { lower, upper } if !m.kind.turns() => {
                    Range::Limits { lower: lower * scale, upper: upper * scale }
                }
                angle => angle,
            },
            ..*m
        };
        let joints = self.joints.iter().map(|js| js.iter().map(motion).collect()).collect();
        Ok(Self { mesh, joints, tree: self.tree.clone(), part_of_face: self.part_of_face.clone() })
    }
}

fn check_motion(part: &str, m: &JointMotion) -> Result<(), ObjectError> {
    if !(m.axis.is_finite() && m.axis.is_normalized() && m.pivot.is_finite()) {
        return Err(ObjectError::Axis { part: part.into(), axis: m.axis, pivot: m.pivot });
    }
    let (lower, upper) = m.range.ends();
    let unlimited = matches!(m.range, Range::Continuous);
    let holds_rest = lower.is_finite() && upper.is_finite() && lower <= 0.0 && upper >= 0.0;
    if !holds_rest || (unlimited != (m.kind == JointKind::Continuous)) {
        return Err(ObjectError::Range { part: part.into(), lower, upper });
    }
    Ok(())
}

impl TryFrom<RawObject> for ArticulatedObject {
    type Error = ObjectError;
    fn try_from(raw: RawObject) -> Result<Self, ObjectError> {
        Self::new(raw.mesh, raw.tree, raw.part_of_face, raw.joints)
    }
}

impl From<ArticulatedObject> for RawObject {
    fn from(o: ArticulatedObject) -> Self {
        Self { tree: o.tree, joints: o.joints, part_of_face: o.part_of_face, mesh: o.mesh }
    }
}
