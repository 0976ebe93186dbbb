//! A model and what was found about it.

use std::path::PathBuf;

use sim_check::report::Item;
use sim_check::report::source::Source;
use sim_check::{Tier, Verdict};

/// A file and what was found about it.
#[derive(Debug)]
pub(super) struct Checked {
    /// The file.
    pub path: PathBuf,
    /// The name it goes by.
    pub name: String,
    /// What was found.
    pub verdict: Verdict,
    /// The tier that is asked of it.
    pub asked: Tier,
    /// Its text, where something fails.
    pub source: Option<Source>,
}

impl Checked {
    /// As reports tell of it.
    pub(super) fn item(&self) -> Item<'_> {
        let Self { name, verdict, asked, source, .. } = self;
        Item { name, verdict, asked: *asked, source: source.as_ref() }
    }
}
