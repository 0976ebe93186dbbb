//! Files → robot: URDF, MJCF, SDFormat or USD, the meshes it names, and all that is wrong with them.
//!
//! Files come from anybody. They are counted before they are parsed, meshes are read only from the
//! file's own folder, and every broken rule is listed with its line. All formats become one
//! [`Robot`](crate::Robot): metres, radians, kilograms.

mod assembly;
pub mod caps;
mod cone;
pub mod dae;
mod depends;
pub mod draft;
mod element;
#[cfg(test)]
mod formats;
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
mod usd;
mod xacro;
mod xml;
