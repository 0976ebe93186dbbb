//! Files → robot: URDF, MJCF or SDFormat text, the meshes it names, and all that is wrong with them.
//!
//! Files come from anybody. They are counted before they are parsed, meshes are read only from the
//! file's own folder, and every broken rule is listed with its line. All formats become one
//! [`Robot`](crate::Robot): metres, radians, kilograms.

mod assembly;
pub mod caps;
pub mod dae;
mod depends;
pub mod draft;
mod element;
mod include;
pub mod load;
pub mod meshes;
mod mjcf;
mod msh;
pub mod parse;
pub mod places;
pub(crate) mod rest;
mod rgba;
mod sdf;
pub mod source;
mod srdf;
mod urdf;
mod xacro;
mod xml;
