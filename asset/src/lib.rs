//! From an articulated object to a simulation-ready asset: closed surfaces, convex collision
//! pieces, mass and inertia, joint drives, and the files that hold them: URDF, MJCF, USD, GLB.
//!
//! [`build()`] makes an [`Asset`] (metres, z up, standing on z = 0) in two steps: [`shape`] makes all
//! that depends on the [`Measures`] of a condition alone, [`finish`] weighs it. [`Asset::to_urdf`] writes it as
//! a [`Package`] of files, [`Asset::to_mjcf`], [`Asset::to_usd`] and [`Asset::to_glb`] write one file
//! each. Every number carries its origin, everything altered is a [`Change`].

mod amend;
pub mod asset;
pub mod build;
pub mod change;
pub mod collision;
pub mod error;
mod joints;
pub mod mass;
mod parts;
mod standing;
pub mod surface;
pub mod write;

pub use amend::Amendment;
pub use asset::{Asset, Inertial, Joint, JointType, Link, LinkBody, Motion};
pub use build::{BuildOptions, Measures, Shapes, build, finish, shape};
pub use change::Change;
pub use error::AssetError;
pub use write::appearance::look::AssetAppearance;
pub use write::urdf::Package;

#[cfg(test)]
mod tests;
