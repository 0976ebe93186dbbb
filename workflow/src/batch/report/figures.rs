//! The figures of a batch, counted in one pass over its index.

use std::collections::BTreeMap;
use std::path::Path;

use crate::batch::index::{self, DUPLICATE_OF, IndexError, Row};
use crate::batch::record::COLUMNS;

/// Rows of a table at most; the rest is in the index.
pub(super) const ROWS: usize = 20;
/// Pictures in the gallery at most.
const SHOWN: usize = 60;
/// Items out of quarantine that are shown at most.
const REFUSED_SHOWN: usize = 24;
/// Near-duplicates that are listed at most.
const TWINS: usize = 100;
/// Times of a stage that are kept at most.
const TIMES: usize = 4096;
/// Reasons that are listed at most; there may be as many as items.
const REASONS: usize = 5000;
/// Items of one reason that are named.
const NAMED: usize = 3;
/// Checks that are counted at most; the profile has fewer.
const CHECKS: usize = 200;

/// How many items ended how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Yield {
    /// Accepted.
    pub accepted: u64,
    /// Made and not accepted.
    pub rejected: u64,
    /// Not made.
    pub failed: u64,
}

impl Yield {
    /// All of them.
    pub fn all(self) -> u64 {
        self.accepted + self.rejected + self.failed
    }

    /// The accepted share, 0 to 1; 0 of nothing.
    pub fn share(self) -> f64 {
        self.accepted as f64 / self.all().max(1) as f64
    }

    fn note(&mut self, outcome: &str) {
        match outcome {
            "accepted" => self.accepted += 1,
            "rejected" => self.rejected += 1,
            _ => self.failed += 1,
        }
    }
}

/// Items that were not accepted for one reason.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reason {
    /// How many.
    pub items: u64,
    /// The first of them by id.
    pub ids: Vec<String>,
}

/// An item that is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Its id.
    pub id: String,
    /// What stands under its picture.
    pub words: String,
    /// The asset it nearly repeats.
    pub twin: Option<String>,
}

/// What there is to say about a batch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    /// All items.
    pub total: Yield,
    /// By category.
    pub categories: BTreeMap<String, Yield>,
    /// By who made the mesh and who the condition.
    pub providers: BTreeMap<String, Yield>,
    /// Assets by tier.
    pub tiers: BTreeMap<String, u64>,
    /// Not accepted, by class.
    pub classes: BTreeMap<String, u64>,
    /// Not accepted, by class and reason.
    pub reasons: BTreeMap<(String, String), Reason>,
    /// Assets that fail a check, by its id.
    pub checks: BTreeMap<String, Yield>,
    /// The first lines of the manifest that are no items, with why, and how many there are.
    pub bad_lines: (Vec<(u64, String)>, u64),
    /// Calls of providers.
    pub calls: u64,
    /// Their cost.
    pub cost: f64,
    /// Seconds of each stage that ran, ascending; every so-manieth where there are many.
    pub times: BTreeMap<String, Vec<f64>>,
    /// How many times each stage ran.
    pub ran: BTreeMap<String, u64>,
    /// Near-duplicates and what they repeat.
    pub twins: Vec<(String, String)>,
    /// How many near-duplicates there are.
    pub twin_count: u64,
    /// Accepted assets to look at, spread over all.
    pub gallery: Vec<Shown>,
    /// Items out of quarantine to look at.
    pub refused: Vec<Shown>,
}

impl Figures {
    /// Cost of an accepted asset; none without any.
    pub fn cost_per_accepted(&self) -> Option<f64> {
        (self.total.accepted > 0).then(|| self.cost / self.total.accepted as f64)
    }

    /// The commonest reasons, with class and words.
    pub(super) fn commonest(&self) -> Vec<(&(String, String), &Reason)> {
        let mut sorted: Vec<_> = self.reasons.iter().collect();
        sorted.sort_by_key(|(_, reason)| std::cmp::Reverse(reason.items));
        sorted.truncate(ROWS);
        sorted
    }
}

/// Counts an index.
///
/// # Errors
/// [`IndexError`] when it cannot be read.
pub(super) fn of(path: &Path) -> Result<Figures, IndexError> {
    let mut accepted = 0_usize;
    index::read(path, |row| accepted += usize::from(row.text("outcome") == Some("accepted")))?;
    let mut counter = Counter { step: accepted.div_ceil(SHOWN).max(1), ..Counter::default() };
    index::read(path, |row| counter.take(&row))?;
    Ok(counter.done())
}

#[derive(Default)]
struct Counter {
    figures: Figures,
    samples: BTreeMap<String, Sample>,
    step: usize,
    accepted: usize,
}

impl Counter {
    fn take(&mut self, row: &Row) {
        let f = &mut self.figures;
        let text = |column: &str| row.text(column).unwrap_or_default();
        let outcome = text("outcome");
        f.total.note(outcome);
        f.categories
            .entry(or(text("category"), "without category").into())
            .or_default()
            .note(outcome);
        f.providers.entry(providers(row)).or_default().note(outcome);
        if let Some(tier) = row.text("verdict") {
            *f.tiers.entry(tier.into()).or_default() += 1;
        }
        for check in text("failed_checks").split_whitespace() {
            if f.checks.len() < CHECKS || f.checks.contains_key(check) {
                f.checks.entry(check.into()).or_default().note(outcome);
            }
        }
        f.calls += row.number("calls").unwrap_or_default() as u64;
        f.cost += row.number("cost").unwrap_or_default();
        if outcome == "accepted" {
            self.show(row);
        } else {
            self.refuse(row);
        }
        for (column, stage) in stage_columns() {
            if let Some(seconds) = row.number(column) {
                self.samples.entry(stage).or_default().take(seconds);
            }
        }
    }

    fn show(&mut self, row: &Row) {
        let id = row.text("id").unwrap_or_default();
        let twin = row.text(DUPLICATE_OF).map(String::from);
        if let Some(first) = &twin {
            self.figures.twin_count += 1;
            if self.figures.twins.len() < TWINS {
                self.figures.twins.push((id.into(), first.clone()));
            }
        }
        if self.accepted.is_multiple_of(self.step) {
            let joints = row.number("joints").unwrap_or_default();
            let tier = row.text("verdict").unwrap_or_default();
            let what = row.text("category").unwrap_or("asset");
            let s = if joints == 1.0 { "" } else { "s" };
            let words = format!("{what}, {joints} joint{s}, {tier}");
            self.figures.gallery.push(Shown { id: id.into(), words, twin });
        }
        self.accepted += 1;
    }

    fn refuse(&mut self, row: &Row) {
        let f = &mut self.figures;
        let text = |column: &str| row.text(column).unwrap_or_default().to_owned();
        let (id, class, reason) = (text("id"), text("class"), text("reason"));
        *f.classes.entry(class.clone()).or_default() += 1;
        let general = reason.replace(&id, "…");
        let key = (class.clone(), general);
        if f.reasons.len() < REASONS || f.reasons.contains_key(&key) {
            let reason = f.reasons.entry(key).or_default();
            reason.items += 1;
            if reason.ids.len() < NAMED {
                reason.ids.push(id.clone());
            }
        }
        if f.refused.len() < REFUSED_SHOWN && text("outcome") == "rejected" {
            let words = format!("{class}: {reason}");
            f.refused.push(Shown { id, words, twin: None });
        }
    }

    fn done(self) -> Figures {
        let mut figures = self.figures;
        for (stage, sample) in self.samples {
            figures.ran.insert(stage.clone(), sample.count);
            figures.times.insert(stage, sample.sorted());
        }
        figures
    }
}

/// Some of many numbers, evenly spaced: every second one is dropped whenever there are too many.
#[derive(Clone, Debug)]
struct Sample {
    kept: Vec<f64>,
    step: u64,
    count: u64,
}

impl Default for Sample {
    fn default() -> Self {
        Self { kept: Vec::new(), step: 1, count: 0 }
    }
}

impl Sample {
    fn take(&mut self, number: f64) {
        if self.count.is_multiple_of(self.step) {
            self.kept.push(number);
        }
        self.count += 1;
        if self.kept.len() > TIMES {
            let mut nth = 0;
            self.kept.retain(|_| {
                nth += 1;
                nth % 2 == 1
            });
            self.step *= 2;
        }
    }

    fn sorted(mut self) -> Vec<f64> {
        self.kept.sort_by(f64::total_cmp);
        self.kept
    }
}

/// The stages in the order of the flow.
pub(super) fn stages() -> impl Iterator<Item = String> {
    stage_columns().map(|(_, stage)| stage)
}

/// Columns of seconds and the stage each is of.
fn stage_columns() -> impl Iterator<Item = (&'static str, String)> {
    COLUMNS
        .into_iter()
        .filter_map(|(name, _)| Some((name, name.strip_prefix("seconds_")?.replace('_', " "))))
}

fn providers(row: &Row) -> String {
    let one = |column| or(row.text(column).unwrap_or_default(), "nobody").to_owned();
    format!("{} + {}", one("provider"), one("condition_provider"))
}

fn or<'a>(text: &'a str, other: &'a str) -> &'a str {
    if text.is_empty() { other } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_bounded_and_spread_over_all() {
        let mut sample = Sample::default();
        (0..100_000).for_each(|n| sample.take(f64::from(n)));
        assert_eq!(sample.count, 100_000);
        let kept = sample.sorted();
        assert!(kept.len() <= TIMES && kept.len() > TIMES / 4, "{}", kept.len());
        let middle = kept[kept.len() / 2];
        assert!((middle - 50_000.0).abs() < 1000.0, "{middle}");
    }

    #[test]
    fn a_yield_of_nothing_is_nothing() {
        assert_eq!(Yield::default().share(), 0.0);
        let some = Yield { accepted: 3, rejected: 1, failed: 0 };
        assert_eq!((some.all(), some.share()), (4, 0.75));
    }
}
