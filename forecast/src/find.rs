//! What the rules look for: each a plain function of a model, which lists the places.

pub(crate) mod joints;
pub(crate) mod links;
pub(crate) mod mass;
pub(crate) mod meshes;
pub(crate) mod mjcf;
pub(crate) mod place;
pub(crate) mod shapes;
pub(crate) mod sink;
pub(crate) mod usd;
mod vectors;
