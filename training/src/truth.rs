//! What is known about an object beforehand: `truth.json` (`evalcase/1`), the true parts and joints.

use object::mesh::FileFrame;
use object::{ArticulatedObject, DVec3, JointKind, JointMotion, Range};
use serde::{Deserialize, Serialize};

use crate::metrics::{Link, Motion};

/// The schema name a truth file carries.
pub const SCHEMA: &str = "evalcase/1";
/// Most an axis's length may differ from 1.
const UNIT: f64 = 1e-3;

/// A truth file; keys not listed here are passed over.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthFile {
    /// Always `evalcase/1`.
    pub schema: String,
    /// Where the object comes from, such as `articraft`; empty where nobody says.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// Its identifier there.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub record_id: String,
    /// What the object is, in words; empty where nobody says.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub category: String,
    /// `train`, `val` or `dev`, where the object belongs to a split.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub split: String,
    /// Parts by number; 0 is the base.
    pub parts: Vec<TruthPart>,
}

/// One true part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthPart {
    /// Its number: its place in the list.
    pub id: usize,
    /// Its name.
    pub name: String,
    /// Number of the part it hangs on; none for the base.
    pub parent: Option<usize>,
    /// Its joints, the first nearest the parent.
    pub joints: Vec<TruthJoint>,
}

/// One true joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthJoint {
    /// Turn or slide.
    #[serde(rename = "type")]
    pub kind: JointKind,
    /// Unit direction, frame of the mesh file.
    pub axis: [f64; 3],
    /// A point on the axis, frame and unit of the mesh file.
    pub pivot: [f64; 3],
    /// Lower end relative to the pose shown, radians or mesh units; none if endless.
    pub lower: Option<f64>,
    /// Upper end.
    pub upper: Option<f64>,
}

/// Why a truth file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TruthError {
    /// Not JSON, or something is missing.
    #[error("not a truth file: {0}")]
    Json(#[from] serde_json::Error),
    /// Another schema.
    #[error("schema `{0}` is unknown, expected `{SCHEMA}`")]
    Schema(String),
    /// Numbers that are not 0, 1, 2 and so on.
    #[error("part {found} stands at place {place}, expected parts numbered from 0 in order")]
    Order {
        /// Place in the list.
        place: usize,
        /// The number there.
        found: usize,
    },
    /// An axis that is no direction, or a pivot or end that is no number.
    #[error("part {part}: {rule}, found {found}")]
    Joint {
        /// Number of the part.
        part: usize,
        /// The rule.
        rule: &'static str,
        /// What was found.
        found: String,
    },
}

impl TruthFile {
    /// Reads a truth file.
    ///
    /// # Errors
    /// [`TruthError`], the first broken rule.
    pub fn from_json(text: &[u8]) -> Result<Self, TruthError> {
        let file: Self = serde_json::from_slice(text)?;
        if file.schema != SCHEMA {
            return Err(TruthError::Schema(file.schema));
        }
        match file.parts.iter().map(|p| p.id).enumerate().find(|(place, id)| place != id) {
            Some((place, found)) => Err(TruthError::Order { place, found }),
            None => Ok(file),
        }
    }

    /// What is known about an object, in the frame of its mesh file.
    pub fn of(object: &ArticulatedObject) -> Self {
        let frame = object.mesh().frame();
        let part = |(id, part): (usize, &object::Part)| TruthPart {
            id,
            name: part.name.clone(),
            parent: part.parent,
            joints: object.joints(id).iter().map(|m| TruthJoint::of(m, frame)).collect(),
        };
        let parts = object.tree().parts().iter().enumerate().map(part).collect();
        let nobody = String::new;
        let (source, record_id, category, split) = (nobody(), nobody(), nobody(), nobody());
        Self { schema: SCHEMA.into(), source, record_id, category, split, parts }
    }

    /// Every part's joints in the object frame, the mesh's own unit.
    ///
    /// # Errors
    /// [`TruthError::Joint`] for the first joint that is none.
    pub fn motions(&self, frame: FileFrame) -> Result<Vec<Vec<JointMotion>>, TruthError> {
        let of = |p: &TruthPart| p.joints.iter().map(|j| j.motion(p.id, frame)).collect();
        self.parts.iter().map(of).collect()
    }

    /// Parents and motions in the object frame, the mesh's own unit.
    ///
    /// # Errors
    /// [`TruthError::Joint`] for the first joint that is none.
    pub fn links(&self, frame: FileFrame) -> Result<Vec<Link>, TruthError> {
        let motion = |m: JointMotion| {
            let (lower, upper) = m.range.ends();
            Motion { kind: m.kind, axis: m.axis, pivot: m.pivot, lower, upper }
        };
        let link = |(part, joints): (&TruthPart, Vec<JointMotion>)| Link {
            parent: part.parent,
            motions: joints.into_iter().map(motion).collect(),
        };
        Ok(self.parts.iter().zip(self.motions(frame)?).map(link).collect())
    }
}

impl TruthJoint {
    fn of(motion: &JointMotion, frame: FileFrame) -> Self {
        let (lower, upper) = match motion.range {
            Range::Limits { lower, upper } => (Some(lower), Some(upper)),
            Range::Continuous => (None, None),
        };
        let axis = frame.point_to_file(motion.axis).to_array();
        let pivot = frame.point_to_file(motion.pivot).to_array();
        Self { kind: motion.kind, axis, pivot, lower, upper }
    }

    fn motion(&self, part: usize, frame: FileFrame) -> Result<JointMotion, TruthError> {
        let broken = |rule, found: String| Err(TruthError::Joint { part, rule, found });
        let [axis, pivot] =
            [self.axis, self.pivot].map(|v| frame.point_to_object(DVec3::from_array(v)));
        let is_unit = (axis.length() - 1.0).abs() <= UNIT;
        if !(is_unit && pivot.is_finite()) {
            let found = format!("{axis} at {pivot}");
            return broken("an axis has length 1 and a pivot is finite", found);
        }
        let range = match (self.lower, self.upper) {
            (Some(lower), Some(upper)) => Range::Limits { lower, upper },
            (None, None) if self.kind.turns() => Range::Continuous,
            ends => {
                return broken("a joint has two ends, or turns without any", format!("{ends:?}"));
            }
        };
        let (lower, upper) = range.ends();
        if !(lower.is_finite() && upper.is_finite() && lower <= upper) {
            return broken("a range is finite and lower <= upper", format!("{lower} to {upper}"));
        }
        Ok(JointMotion { kind: self.kind, axis: axis.normalize(), pivot, range })
    }
}
