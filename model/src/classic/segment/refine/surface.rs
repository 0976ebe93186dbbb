//! What clean-up looks at: the mesh, the condition and the faces that points lie on.

use object::Condition;

use crate::classic::segment::prompts::seeds::Seed;
use crate::classic::segment::skin::Skin;

/// A surface and what is said of it.
pub(crate) struct Surface<'a> {
    pub skin: &'a Skin,
    pub condition: &'a Condition,
    pub seeds: &'a [Seed],
}
