//! Files → robot: URDF or MJCF text, the meshes it names, and all that is wrong with them.
//!
//! Files come from anybody. They are counted before they are parsed, meshes are read only from the
//! file's own folder, and every broken rule is listed with its line. Both formats become one
//! [`Robot`](crate::Robot): metres, radians, kilograms.

pub mod caps;
pub mod draft;
pub mod load;
pub mod meshes;
mod mjcf;
pub mod parse;
mod rgba;
mod urdf;
mod xml;
