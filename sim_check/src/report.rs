//! Verdicts for build servers, code hosts and browsers: SARIF, JUnit, Markdown and HTML; and
//! who answers for what fails.

pub mod answer;
pub mod html;
pub mod junit;
pub mod markdown;
pub mod sarif;
pub mod source;

use source::Source;

use crate::profile::{self, Tier};
use crate::verdict::{Check, Status, Verdict, figure};

/// A checked file, as a report tells of it.
#[derive(Clone, Copy, Debug)]
pub struct Item<'a> {
    /// The name it goes by: its path, as it was given.
    pub name: &'a str,
    /// What was found.
    pub verdict: &'a Verdict,
    /// The tier it should reach.
    pub asked: Tier,
    /// Its text, for lines and columns; none where it could not be read again.
    pub source: Option<&'a Source>,
}

impl Item<'_> {
    /// Whether it reaches the tier that is asked of it.
    pub fn is_enough(&self) -> bool {
        self.verdict.tier >= self.asked
    }

    /// The checks that somebody should see: what does not hold, and what a person should look at.
    pub fn told(&self) -> impl Iterator<Item = &Check> {
        self.verdict.checks.iter().filter(|c| c.status != Status::Pass)
    }

    /// Whether a check is what keeps it below the tier that is asked of it.
    pub fn is_blocking(&self, check: &Check) -> bool {
        check.counts_against() && profile::rule(&check.id).tier <= self.asked
    }
}

/// What was expected of a check and what was found, in a line.
pub(crate) fn expectation(check: &Check) -> String {
    let found = check.value.map(|v| format!(", found {} {}", figure(v), check.unit));
    format!("expected {}{}", check.threshold, found.unwrap_or_default()).trim_end().to_owned()
}
