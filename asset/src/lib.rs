//! From an articulated object to a simulation-ready asset: closed surfaces, convex collision
//! pieces, mass and inertia, joint drives, and the files that hold them: URDF, MJCF, USD, GLB.
//!
//! [`build()`] makes an [`Asset`] (metres, z up, standing on z = 0); [`Asset::to_urdf`] writes it as
//! a [`Package`] of files, [`Asset::to_mjcf`], [`Asset::to_usd`] and [`Asset::to_glb`] write one file
//! each. Every number carries its origin, everything altered is a [`Change`].

mod adjacent;
mod agreement;
mod amend;
pub mod asset;
mod balance;
mod borders;
pub mod build;
mod caps;
pub mod change;
pub mod clearance;
mod collision;
mod columns;
mod drive;
mod fans;
mod glb;
mod ground;
mod hinges;
pub mod hulls;
mod links;
pub mod mass;
pub mod materials;
mod mjcf;
pub mod moments;
pub mod orient;
mod patches;
mod pivots;
mod polygon;
mod principal;
pub mod repair;
mod seal;
mod sidecar;
mod simplify;
mod sockets;
mod standing;
mod stays;
mod urdf;
mod usd;
mod usda;
mod xml;

pub use amend::Amendment;
pub use asset::{Asset, Inertial, Joint, JointType, Link, LinkBody, Motion};
pub use build::{AssetError, BuildOptions, build};
pub use change::Change;
pub use urdf::Package;

#[cfg(test)]
mod tests;
