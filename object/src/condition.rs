//! The kinematic condition: what the parts are, how they hang together, where to find them, and what a
//! person has corrected.
//!
//! On disk it is a JSON file a person can write ([`ConditionFile`], `kinfold-condition/2`); in
//! memory it is a [`Condition`], the paper's C, whose tree is proved and whose points are in the
//! object frame. Files of `kinfold-condition/1` and of the schema `condition/1` are read as well.

mod fault;
mod file;
mod foreign;
mod names;
mod points;
mod read;
mod resolve;
mod runs;

use glamx::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use fault::{ConditionError, Fault};
pub use file::{ConditionFile, FileJoint, FileJoints, FilePart, FileSize, Quantity};
pub use names::name_from_text;
pub use runs::{Runs, RunsError};

use crate::articulated::Range;
use crate::kinematics::{KinematicTree, Part};
use crate::mesh::{FileFrame, Mesh, UpAxis};
use crate::origin::Origin;

/// The schema name a condition file of ours carries.
pub const SCHEMA: &str = "kinfold-condition/2";
/// The schema before it: the same without corrections.
pub const SCHEMA_1: &str = "kinfold-condition/1";
/// A prompt point may lie this far off the surface, as a share of the mesh's diagonal.
pub const POINT_TOLERANCE: f64 = 0.01;
/// Longest part text, in characters.
pub const MAX_TEXT: usize = 120;
/// Most points, and most points that are not of it, of one part.
pub const MAX_POINTS: usize = 64;

/// What the model is told about an object: the paper's C, plus physical properties where known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// What the object is, in a word or two; may be empty.
    pub category: String,
    /// Parts and joint types.
    pub tree: KinematicTree,
    /// For each part, where it is, what it is made of and how it moves.
    pub prompts: Vec<Prompt>,
    /// True size, where known.
    pub size: Option<TrueSize>,
    /// Who wrote the numbers: a person or a vision-language model.
    pub origin: Origin,
    /// The frame in which its points were written.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub frame: FileFrame,
    /// Digest of the mesh on which faces were painted ([`Mesh::digest`]).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub painted_on: Option<String>,
}

/// Where a part is, what it is made of and how it moves; every field may be unknown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Prompt {
    /// A point on the part's surface, object frame, the mesh's own unit.
    pub point: Option<DVec3>,
    /// Further points on it; none without the first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<DVec3>,
    /// Points on the object's surface that are not on this part.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not: Vec<DVec3>,
    /// Faces of the mesh that are of this part whatever else is found.
    #[serde(default, skip_serializing_if = "Runs::is_empty")]
    pub faces: Runs,
    /// What is given of its joints, in the order of [`crate::Part::joints`]; empty where nothing is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<GivenJoint>,
    /// Material in words.
    pub material: Option<String>,
    /// Density of the solid material, kg/m³.
    pub density: Option<f64>,
    /// Mass of the part, kg; wins over density.
    pub mass: Option<f64>,
    /// Coefficient of friction of the surface, 0 to 2.
    pub friction: Option<f64>,
}

/// What a person says of a joint: it is kept as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GivenJoint {
    /// Unit direction of the axis, object frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<DVec3>,
    /// A point on the axis, object frame, the mesh's own unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pivot: Option<DVec3>,
    /// How far it moves from the pose the mesh shows: radians, or metres of the finished object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<Range>,
    /// How far it is open in the pose the mesh shows, where no range is given: radians or metres, ≥ 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open_by: Option<f64>,
    /// Largest torque or force of its drive, N·m or N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort: Option<f64>,
    /// Viscous damping, N·m·s/rad or N·s/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
}

/// How large the object is in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrueSize {
    /// Which extent is meant.
    pub of: Extent,
    /// Its length, metres, 0.005 to 20.
    pub metres: f64,
}

impl TrueSize {
    /// The factor that brings `mesh` to this size.
    pub fn scale_for(&self, mesh: &Mesh) -> f64 {
        let size = mesh.bounds().size();
        let extent = match self.of {
            Extent::Largest => size.max_element(),
            Extent::Height => size.z,
            Extent::Width => size.x,
            Extent::Depth => size.y,
        };
        self.metres / extent
    }
}

/// An extent of an object, object frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// The longest side of its box.
    Largest,
    /// Along z.
    Height,
    /// Along x.
    Width,
    /// Along y.
    Depth,
}

impl Prompt {
    /// All points on the part's surface, object frame, the mesh's own unit.
    pub fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.point.into_iter().chain(self.also.iter().copied())
    }

    /// What is given of one of its joints; nothing where nothing is.
    pub fn given(&self, joint: usize) -> GivenJoint {
        self.joints.get(joint).copied().unwrap_or_default()
    }
}

impl Condition {
    /// A condition of a tree about which nothing else is known.
    pub fn of_tree(category: impl Into<String>, tree: KinematicTree, origin: Origin) -> Self {
        let prompts = vec![Prompt::default(); tree.len()];
        Self {
            category: category.into(),
            tree,
            prompts,
            size: None,
            origin,
            frame: FileFrame::default(),
            painted_on: None,
        }
    }

    /// Reads a condition file of any of the three schemas. A byte-order mark, comments, commas after the
    /// last of a list, single quotes and names without quotes are read, too.
    ///
    /// # Errors
    /// [`ConditionError`]: everything that is wrong, with lines, what was found and what is allowed.
    pub fn from_json(text: &str) -> Result<Self, ConditionError> {
        read::condition(text, UpAxis::Y)
    }

    /// The same of a mesh whose up axis somebody else said, where the file does not say it.
    ///
    /// # Errors
    /// As [`Condition::from_json`].
    pub fn from_json_with(text: &str, up: UpAxis) -> Result<Self, ConditionError> {
        read::condition(text, up)
    }

    /// What parts and joints are found from: tree, texts, points and corrections. Left out is what only a
    /// finished asset has: masses, materials, drives, and the size unless a slide's length is given in metres.
    #[must_use]
    pub fn of_shape(&self) -> Self {
        let joint = |given: &GivenJoint| GivenJoint { effort: None, damping: None, ..*given };
        let prompt = |prompt: &Prompt| Prompt {
            point: prompt.point,
            also: prompt.also.clone(),
            not: prompt.not.clone(),
            faces: prompt.faces.clone(),
            joints: kept(prompt.joints.iter().map(joint).collect()),
            ..Prompt::default()
        };
        let parts = self.tree.parts().iter().zip(&self.prompts);
        let says_length = |(part, prompt): (&Part, &Prompt)| {
            let slides = part.joints.iter().zip(&prompt.joints).filter(|(kind, _)| !kind.turns());
            slides.into_iter().any(|(_, given)| given.range.is_some() || given.open_by.is_some())
        };
        let has_lengths = parts.into_iter().any(says_length);
        Self {
            prompts: self.prompts.iter().map(prompt).collect(),
            size: self.size.filter(|_| has_lengths),
            origin: Origin::User,
            ..self.clone()
        }
    }

    /// The part a text prompt and point describe, as the paper's (t, x).
    pub fn text(&self, part: usize) -> &str {
        &self.tree.parts()[part].text
    }

    /// Checks that every point lies on the mesh, within [`POINT_TOLERANCE`], and that painted faces are
    /// faces of it.
    ///
    /// # Errors
    /// [`ConditionError`]: every point that does not, with the nearest one that does, and what they look
    /// like.
    pub fn check_points(&self, mesh: &Mesh) -> Result<(), ConditionError> {
        points::check(self, mesh)
    }

    /// The same with every point that lies off the mesh moved to the nearest one on it, and how many were.
    #[must_use]
    pub fn snapped(&self, mesh: &Mesh) -> (Self, usize) {
        points::snapped(self, mesh)
    }

    /// The JSON Schema of a condition file, for editors.
    pub fn json_schema() -> serde_json::Value {
        schemars::schema_for!(ConditionFile).to_value()
    }
}

/// What is given of joints; nothing where nothing is left of it.
fn kept(joints: Vec<GivenJoint>) -> Vec<GivenJoint> {
    if joints.iter().all(|given| *given == GivenJoint::default()) { vec![] } else { joints }
}

fn is_usual(frame: &FileFrame) -> bool {
    *frame == FileFrame::default()
}

#[cfg(test)]
mod tests;
