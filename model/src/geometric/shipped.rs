//! The packs that ship inside the program, each read when it is first asked for.

use std::sync::OnceLock;

use super::pack::{Pack, PackError};
use super::{labels, reach, score};

/// A pack that ships, and how it is read.
pub(super) struct Shipped<T: 'static> {
    name: &'static str,
    bytes: &'static [u8],
    read: fn(&Pack<'_>) -> Result<T, PackError>,
    cell: OnceLock<(T, Option<PackError>)>,
}

impl<T: Default> Shipped<T> {
    pub(super) const fn new(
        name: &'static str,
        bytes: &'static [u8],
        read: fn(&Pack<'_>) -> Result<T, PackError>,
    ) -> Self {
        Self { name, bytes, read, cell: OnceLock::new() }
    }

    fn opened(&self) -> &(T, Option<PackError>) {
        self.cell.get_or_init(|| {
            match Pack::open(self.name, self.bytes).and_then(|pack| (self.read)(&pack)) {
                Ok(model) => (model, None),
                Err(refused) => (T::default(), Some(refused)),
            }
        })
    }

    /// What was learned. Of a pack that is refused, nothing: [`check`] comes first, and ends the run.
    pub(super) fn get(&self) -> &T {
        &self.opened().0
    }

    /// Why the pack is refused, if it is.
    pub(super) fn check(&self) -> Result<(), PackError> {
        self.opened().1.clone().map_or(Ok(()), Err)
    }

    /// Adds what was learned, without what is said of it, to a digest.
    pub(super) fn hash_into(&self, hasher: &mut blake3::Hasher) {
        if let Ok(pack) = Pack::open(self.name, self.bytes) {
            hasher.update(pack.content());
        }
    }
}

/// Refuses to begin with a pack that this program cannot read.
///
/// # Errors
/// [`PackError`] of the first such pack.
pub fn check() -> Result<(), PackError> {
    labels::check()?;
    score::check()?;
    reach::check()
}
