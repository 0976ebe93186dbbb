//! The asset: links with geometry and mass, joints with limits and drives, every number sourced.
//!
//! The asset frame is right-handed, z up, metres and radians; the asset stands on z = 0 with the
//! centre of its base part at x = y = 0. All link frames are parallel to it at rest.
//!
//! ```
//! use asset::JointType;
//! let kinds: Vec<JointType> = serde_json::from_str(r#"["fixed", "prismatic"]"#)?;
//! assert_eq!(kinds, [JointType::Fixed, JointType::Prismatic]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use glamx::{DMat3, DQuat, DVec3};
use object::confidence::{JointConfidence, PartConfidence};
use object::{Confidence, Mesh, Sourced};
use serde::{Deserialize, Serialize};

use crate::change::Change;
use crate::collision::piece::ConvexPiece;
use crate::mass::materials::Substance;
use crate::surface::repaired::Report;

/// A simulation-ready asset, made by [`crate::build()`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Asset {
    /// Identifier made of the category: the URDF robot's name.
    pub name: String,
    /// What the object is, in the condition's words; may be empty.
    pub category: String,
    /// Metres per unit of the object's mesh.
    pub scale: Sourced<f64>,
    /// How the object was turned so that it stands on its own; identity for most.
    pub turn: DQuat,
    /// Where the origin of the object's frame lies in the asset frame, metres: a point p of the
    /// object stands at `turn · (scale · p) + offset`.
    pub offset: DVec3,
    /// Sides of the box around the asset at rest, metres.
    pub size: Sourced<DVec3>,
    /// Links, each after its parent; the first is the root.
    pub links: Vec<Link>,
    /// Joints, in the order of their children.
    pub joints: Vec<Joint>,
    /// What was altered on the way, in order of part.
    pub changes: Vec<Change>,
    /// How likely its parts and joints are right, if that is known, by the parts of the object
    /// ([`Link::part`]); places in the asset frame, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<Confidence>,
}

/// A rigid link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Unique name: the part's, or the part's with a suffix for the carrier between its two joints.
    pub name: String,
    /// Index of the part in the object's tree.
    pub part: usize,
    /// What the part is, in words: its semantic label.
    pub label: String,
    /// Origin of the link's frame at rest, asset frame, metres.
    pub frame: DVec3,
    /// Mass, centre and inertia.
    pub inertial: Inertial,
    /// Geometry; `None` for a carrier, which has none.
    pub body: Option<LinkBody>,
}

/// Mass and how it is spread.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inertial {
    /// Mass, kg, above 0.
    pub mass: Sourced<f64>,
    /// Centre of mass, link frame, metres.
    pub centre: Sourced<DVec3>,
    /// Inertia tensor about the centre along the link frame's axes, kg·m²; positive definite and
    /// within the triangle inequality.
    pub inertia: Sourced<DMat3>,
}

/// What a link looks like, is made of and collides with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinkBody {
    /// The surface to draw, link frame, metres.
    pub visual: Mesh,
    /// What repairing the surface altered.
    pub repaired: Report,
    /// Mean colour, sRGB and opacity, each 0 to 1.
    pub colour: Sourced<[f64; 4]>,
    /// Convex pieces to collide with, link frame, metres.
    pub collision: Vec<ConvexPiece>,
    /// Material, density, wall, friction.
    pub substance: Substance,
    /// Space the part fills, m³.
    pub volume: Sourced<f64>,
    /// Whether its words say that it is made to be gripped: a handle, a knob, a lever.
    pub graspable: bool,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JointType {
    /// Not at all.
    Fixed,
    /// Turns within limits.
    Revolute,
    /// Turns without end.
    Continuous,
    /// Slides within limits.
    Prismatic,
}

impl JointType {
    /// What URDF and SDFormat call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
        }
    }
}

/// A joint; its frame is the child's, at rest parallel to the asset frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// How it moves.
    pub kind: JointType,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link.
    pub child: usize,
    /// Origin of the child's frame in the parent's, metres.
    pub origin: Sourced<DVec3>,
    /// What moves it and holds it; `None` for a fixed joint.
    pub motion: Option<Motion>,
}

/// Axis, limits and drive of a moving joint. Units: radians and N·m for a turn, metres and newtons
/// for a slide.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Unit axis, joint frame.
    pub axis: Sourced<DVec3>,
    /// Lower and upper end, lower ≤ 0 ≤ upper; `None` for a continuous joint.
    pub limits: Option<[Sourced<f64>; 2]>,
    /// Largest force or torque a drive needs.
    pub effort: Sourced<f64>,
    /// Largest speed, rad/s or m/s.
    pub velocity: Sourced<f64>,
    /// Viscous damping, N·m·s/rad or N·s/m.
    pub damping: Sourced<f64>,
    /// Dry friction, N·m or N.
    pub friction: Sourced<f64>,
}

impl Asset {
    /// The index of the joint whose child is the given link.
    pub fn joint_of(&self, link: usize) -> Option<&Joint> {
        self.joints.iter().find(|j| j.child == link)
    }

    /// How likely the surface of a link with geometry is right, if that is known.
    pub(crate) fn confidence_of_link(&self, link: &Link) -> Option<&PartConfidence> {
        link.body.as_ref()?;
        self.confidence.as_ref()?.parts.get(link.part)
    }

    /// How likely a joint is right, if that is known.
    pub(crate) fn confidence_of_joint(&self, joint: usize) -> Option<&JointConfidence> {
        let (part, place) = self.place_of_joint(joint)?;
        self.confidence.as_ref()?.parts.get(part)?.joints.get(place)
    }

    /// The part that a joint moves, and which of its joints it is.
    fn place_of_joint(&self, joint: usize) -> Option<(usize, usize)> {
        let part = |joint: &Joint| self.links.get(joint.child).map(|link| link.part);
        let own = part(self.joints.get(joint)?)?;
        let before = self.joints.iter().take(joint).filter(|j| part(j) == Some(own));
        Some((own, before.count()))
    }

    /// Notes that a joint opens the other way than it was found to: as likely right as that was wrong.
    pub(crate) fn note_flipped(&mut self, joint: usize) {
        let Some((part, place)) = self.place_of_joint(joint) else { return };
        let parts = self.confidence.as_mut().map(|c| &mut c.parts);
        let of = parts.and_then(|parts| parts.get_mut(part)?.joints.get_mut(place));
        if let Some(JointConfidence { way: Some(way), joint, .. }) = of {
            *way = 1.0 - *way;
            *joint = joint.min(*way);
        }
    }

    /// Mass of the whole asset, kg.
    pub fn mass(&self) -> f64 {
        self.links.iter().map(|l| l.inertial.mass.value).sum()
    }
}
