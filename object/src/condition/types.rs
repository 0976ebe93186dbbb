//! A condition in memory: its tree is proved, its points are in the object frame.

use glamx::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::runs::Runs;
use crate::articulated::Range;
use crate::kinematics::{KinematicTree, Part};
use crate::mesh::{FileFrame, Mesh};
use crate::origin::Origin;

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

    /// Leaves out all that says where the part is: its points, those that are not of it, painted faces.
    pub fn forget_places(&mut self) {
        self.point = None;
        self.also.clear();
        self.not.clear();
        self.faces = Runs::default();
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

    /// Gives painted faces the part they were painted as: `part_of_face` has a part for each face of the mesh.
    pub fn paint(&self, part_of_face: &mut [u16]) {
        for (part, prompt) in self.prompts.iter().enumerate() {
            for face in prompt.faces.iter() {
                if let Some(label) = part_of_face.get_mut(face as usize) {
                    *label = part as u16;
                }
            }
        }
    }

    /// The part a text prompt and point describe, as the paper's (t, x).
    pub fn text(&self, part: usize) -> &str {
        &self.tree.parts()[part].text
    }
}

/// What is given of joints; nothing where nothing is left of it.
pub(super) fn kept(joints: Vec<GivenJoint>) -> Vec<GivenJoint> {
    if joints.iter().all(|given| *given == GivenJoint::default()) { vec![] } else { joints }
}

fn is_usual(frame: &FileFrame) -> bool {
    *frame == FileFrame::default()
}
