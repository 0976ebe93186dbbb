//! Links and joints with frames, limits and drives.
//!
//! Each joint's frame sits on its axis, near both parts. Limits end where a part would leave what
//! it hangs on. Effort, speed, damping and friction follow from mass and gravity by rules. Radians
//! and N·m for a turn, metres and newtons for a slide.

pub(crate) mod drive;
pub(crate) mod links;
pub(crate) mod pivots;
pub(crate) mod stays;
