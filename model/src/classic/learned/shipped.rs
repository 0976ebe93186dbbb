//! The packs that ship inside the program, each read when it is first asked for.

use std::sync::OnceLock;

use crate::classic::learned::pack::{Pack, PackError};

/// A pack that ships, and how it is read.
pub(crate) struct Shipped<T: 'static> {
    name: &'static str,
    bytes: &'static [u8],
    read: fn(&Pack<'_>) -> Result<T, PackError>,
    cell: OnceLock<(T, Option<PackError>)>,
}

impl<T: Default> Shipped<T> {
    pub(crate) const fn new(
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

    /// What was learned. Of a pack that is refused, nothing: [`crate::classic::check`] comes first, and ends the run.
    pub(crate) fn get(&self) -> &T {
        &self.opened().0
    }

    /// Why the pack is refused, if it is.
    pub(crate) fn check(&self) -> Result<(), PackError> {
        self.opened().1.clone().map_or(Ok(()), Err)
    }

    /// The name of the pack, and the digest of what was learned, without what is said of it; of a pack that
    /// is refused, of nothing.
    pub(crate) fn digest(&self) -> (&'static str, String) {
        let pack = Pack::open(self.name, self.bytes);
        let content = pack.map(|pack| pack.content()).unwrap_or_default();
        (self.name, blake3::hash(content).to_hex().to_string())
    }
}
