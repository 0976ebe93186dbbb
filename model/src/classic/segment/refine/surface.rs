//! What clean-up looks at: the mesh, the condition and the faces that points lie on.

use object::{Condition, Mesh};

use crate::classic::segment::prompts::seeds::Seed;

/// A surface and what is said of it.
pub(crate) struct Surface<'a> {
    pub mesh: &'a Mesh,
    pub condition: &'a Condition,
    pub seeds: &'a [Seed],
}
