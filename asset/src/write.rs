//! Writers: one asset as URDF with its meshes and sidecar, as MJCF, as USD, as GLB.
//!
//! All say the same masses, axes and limits. The same asset gives the same bytes.

mod adjacent;
pub(crate) mod appearance;
mod glb;
mod mjcf;
mod obj;
mod paths;
mod shading;
mod sidecar;
pub mod urdf;
mod usd;
mod usda;
mod usdz;
mod xml;
