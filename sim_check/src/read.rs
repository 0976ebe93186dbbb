//! Files → robot: URDF or MJCF text, the meshes it names, and all that is wrong with them.
//!
//! Files come from anybody. They are counted before they are parsed, meshes are read only from the
//! file's own folder, and every broken rule is listed with its line. Both formats become one
//! [`Robot`](crate::Robot): metres, radians, kilograms.

pub mod caps;
pub mod dae;
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
pub mod source;
mod srdf;
mod urdf;
mod xacro;
mod xml;
