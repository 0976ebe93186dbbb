//! How the whole object stands on the ground z = 0 under gravity.
//!
//! What a photo shows standing shall stand: masses that would tip it over are guessed again, a lean
//! is turned upright, uneven feet are made level. Metres, asset frame, z up.

pub(crate) mod ground;
pub(crate) mod stand;
