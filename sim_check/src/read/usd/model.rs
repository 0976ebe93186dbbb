//! A stage while it is read.

use std::collections::BTreeMap;

use glamx::DVec3;

use super::lines::Lines;
use super::prims::Prims;
use crate::read::draft::{Draft, MAX_LENGTH};
use crate::robot::Unread;

/// A stage being read.
pub(super) struct Usd<'d> {
    pub draft: &'d mut Draft,
    pub prims: Prims,
    pub lines: Lines,
    /// The body of each prim that is one.
    pub bodies: BTreeMap<usize, usize>,
}

impl Usd<'_> {
    pub(super) fn line(&self, prim: usize) -> u32 {
        self.lines.of_path(self.prims.path(prim))
    }

    /// A prim and its line, for a finding.
    pub(super) fn at(&self, prim: usize) -> String {
        format!("line {}: `{}`", self.line(prim), self.prims.path(prim))
    }

    pub(super) fn unread(&mut self, prim: usize, what: &str, checks: &'static [&'static str]) {
        let what = format!("{}: {what}", self.at(prim));
        self.draft.beside.unread.push(Unread { what, checks });
    }
}

/// Three numbers as a vector.
pub(super) fn vector(numbers: &[f64]) -> Option<DVec3> {
    (numbers.len() == 3).then(|| DVec3::new(numbers[0], numbers[1], numbers[2]))
}

/// Whether lengths can be worked with.
pub(super) fn is_length(v: DVec3) -> bool {
    v.is_finite() && v.abs().max_element() <= MAX_LENGTH
}
