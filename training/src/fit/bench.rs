//! What every fit works with, and what it says.

use std::collections::BTreeMap;

use model::classic::learned::pack::{Ensemble, Section, Table};

use super::data::Data;
use super::error::{FitError, Watcher};
use super::kept::Kept;
use super::origin;
use super::recipe::Model;

/// What a fit says.
pub(crate) struct Fitted {
    pub kind: &'static str,
    pub tables: Vec<Table>,
    pub ensembles: Vec<Ensemble>,
    pub settings: BTreeMap<String, f64>,
    pub sections: Vec<(Section, Vec<u8>)>,
    pub metrics: BTreeMap<String, f64>,
}

impl Fitted {
    pub(crate) fn of(kind: &'static str, tables: Vec<Table>) -> Self {
        let (ensembles, settings, metrics) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
        Self { kind, tables, ensembles, settings, sections: Vec::new(), metrics }
    }
}

/// What a fit works with.
pub(crate) struct Bench<'a> {
    pub data: Data<'a>,
    pub kept: Kept<'a>,
    pub watcher: &'a dyn Watcher,
    /// The packs that the program reads objects with, by name, and their digests.
    pub packs: BTreeMap<&'static str, String>,
}

impl Bench<'_> {
    /// A digest of what everything that is fitted here follows from: the program, the packs that it reads
    /// objects with, the data, and what else is said.
    pub(crate) fn inputs(&self, more: &str) -> blake3::Hasher {
        let mut inputs = blake3::Hasher::new();
        let packs = self.packs.iter().map(|(name, digest)| (*name, digest));
        let data = self.data.digests.iter().map(|(name, digest)| (&**name, digest));
        let program = [origin::BUILT_FROM.to_owned(), more.to_owned()];
        let all = packs.chain(data).chain(program.iter().map(|text| ("", text)));
        for text in all.flat_map(|(name, digest)| [name.as_bytes(), digest.as_bytes()]) {
            inputs.update(&(text.len() as u64).to_le_bytes()).update(text);
        }
        inputs
    }
}

/// How a kind of pack is fitted.
pub(crate) trait Fits: Model {
    /// The packs that objects are read with before anything is fitted to them.
    const READS: &'static [&'static str];

    fn fitted(&self, bench: &Bench<'_>) -> Result<Fitted, FitError>;
}
