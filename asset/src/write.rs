//! Writers: one asset as URDF with its meshes and sidecar, as MJCF, USD, GLB and SDFormat, and packed for
//! ROS 2, Isaac Lab and NVIDIA's SimReady.
//!
//! All say the same masses, axes and limits. The same asset gives the same bytes.

mod adjacent;
pub(crate) mod appearance;
mod glb;
mod isaaclab;
mod mjcf;
mod moved;
mod obj;
mod paths;
mod ros;
mod runtimes;
mod sdf;
mod shading;
mod sidecar;
mod simready;
pub mod urdf;
mod usd;
mod usda;
mod usdz;
mod xml;
