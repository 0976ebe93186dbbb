//! What was learned and ships inside the program.

use std::collections::BTreeMap;

use crate::classic::confidence;
use crate::classic::joints::{axis_model, range_model};
use crate::classic::learned::pack::PackError;
use crate::classic::segment;

/// Refuses to begin with a pack that this program cannot read.
///
/// # Errors
/// [`PackError`] of the first such pack.
pub fn check() -> Result<(), PackError> {
    segment::check()?;
    axis_model::check()?;
    range_model::check()
}

/// What was learned and ships, by the name of its pack: BLAKE3 digests of what is in it, without what is
/// said of it. Whatever is fitted to labels follows from it, too.
pub fn digests() -> BTreeMap<&'static str, String> {
    segment::digests()
        .into_iter()
        .chain([axis_model::digest_of_pack(), range_model::digest_of_pack()])
        .chain([confidence::digest_of_pack()])
        .collect()
}

/// The packs of these names as one digest, shortened: other numbers are another identity.
pub(super) fn learned(of: impl Fn(&str) -> bool) -> String {
    let mut hasher = blake3::Hasher::new();
    for (name, digest) in digests().iter().filter(|(name, _)| of(name)) {
        hasher.update(name.as_bytes()).update(digest.as_bytes());
    }
    hasher.finalize().to_hex().chars().take(12).collect()
}
