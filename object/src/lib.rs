//! What an articulated object is: surface, kinematic tree, condition, joints and poses.
//!
//! Everything here lives in the *object frame*: right-handed, z up, lengths in metres, angles in
//! radians. Files in other frames are turned on the way in ([`glb`], [`gltf`], [`obj`], [`ply`], [`stl`]) and the turn is kept
//! in [`mesh::FileFrame`], so it can be undone on the way out.

pub mod appearance;
pub mod articulated;
pub mod beside;
pub mod condition;
pub mod confidence;
pub mod glb;
pub mod gltf;
pub mod kinematics;
pub mod mesh;
pub mod meshfile;
pub mod normals;
pub mod obj;
pub mod origin;
pub mod ply;
pub mod pose;
pub mod posed;
pub mod reading;
pub mod sample;
pub mod sheets;
pub mod sides;
pub mod simplify;
pub mod stl;
pub mod upright;
pub mod usd;
pub mod weld;

pub use appearance::Appearance;
pub use articulated::{ArticulatedObject, JointMotion, Range};
pub use condition::{Condition, ConditionFile};
pub use confidence::Confidence;
pub use kinematics::{JointKind, KinematicTree, Part};
pub use mesh::{FileFrame, Mesh};
pub use origin::{Origin, Sourced};
pub use pose::Configuration;

pub use glamx::{DMat3, DPose3, DQuat, DVec3};
