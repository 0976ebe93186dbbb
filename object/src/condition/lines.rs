//! Where in a file what stands.

use std::collections::BTreeMap;

/// In which lines what stands: of a part by its place in the list, and a field of it.
#[derive(Debug, Default)]
pub(super) struct Lines(BTreeMap<(Option<usize>, &'static str), usize>);

impl Lines {
    /// Notes the line of a field of a part, or of the file where no part is meant.
    pub(super) fn put(&mut self, place: (Option<usize>, &'static str), line: usize) {
        self.0.insert(place, line);
    }

    /// The line of a field of a part, else that of the part; of a field of the file where no part is meant.
    pub(super) fn of(&self, part: Option<usize>, field: &'static str) -> Option<usize> {
        self.0.get(&(part, field)).or_else(|| self.0.get(&(part, ""))).copied()
    }
}
