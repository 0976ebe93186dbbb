//! Who answers for what fails: comments in the files, the settings of the repository, the baseline.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;
use sim_check::report::answer::{Allowance, answer};
use sim_check::report::source::Source;
use sim_check::{Status, Verdict};

use super::baseline::Baseline;
use super::checked::Checked;
use super::config::Settings;
use crate::cli::args::CheckArgs;

/// A model's text that is longer is not looked through for comments and lines, bytes; a guess, ten times the
/// longest met.
const MOST: u64 = 64 << 20;

/// Checks a file once more, C1 waived for this reason.
pub(super) type Again<'a> = &'a (dyn Fn(&Path, &str) -> Verdict + Sync);

/// What somebody lets pass in one file.
struct Allowed {
    all: Vec<Allowance>,
    /// Which of them the settings say, by their place here and there.
    numbers: Vec<(usize, usize)>,
}

/// Lets pass what somebody answers for, in every file; returns what is to be said of it. Where that is an
/// overlap at rest, the file is checked `again`, for what could not be judged because of it.
pub(super) fn given(
    checked: &mut [Checked],
    args: &CheckArgs,
    (settings, baseline): (&Settings, Option<&Baseline>),
    again: Again<'_>,
) -> Vec<String> {
    let today = jiff::Timestamp::now().to_zoned(jiff::tz::TimeZone::UTC).date().to_string();
    let mut remarks = Vec::new();
    for of in checked.iter_mut() {
        let has_findings = of.verdict.checks.iter().any(|c| c.status != Status::Pass);
        if has_findings && let Ok(bytes) = guard::files::read(&of.path, MOST) {
            of.source = Some(Source::read(&String::from_utf8_lossy(&bytes)));
        }
        remarks.extend(said_in(of, &today));
    }
    let used: Vec<BTreeSet<usize>> = checked
        .par_iter_mut()
        .map(|of| {
            let Allowed { all, numbers } = allowed(of, settings, baseline);
            if all.is_empty() {
                return BTreeSet::new();
            }
            let mut is_used = answer(&mut of.verdict, &all, &today);
            let c1 = of.verdict.check("C1").and_then(|c| c.waived.clone());
            if let Some(reason) = c1.filter(|_| args.waive.iter().all(|(id, _)| id != "C1")) {
                of.verdict = again(&of.path, &reason);
                let later = answer(&mut of.verdict, &all, &today);
                is_used.iter_mut().zip(later).for_each(|(used, later)| *used |= later);
            }
            let ours = numbers.into_iter().filter(|(place, _)| is_used.get(*place) == Some(&true));
            ours.map(|(_, number)| number).collect()
        })
        .collect();
    let is_used =
        |id: &str| checked.iter().any(|c| c.verdict.check(id).is_some_and(|c| c.waived.is_some()));
    let unused = args.waive.iter().filter(|(id, _)| !is_used(id));
    remarks.extend(
        unused.map(|(id, _)| format!("--waive {id}: nothing failed it, so nothing was waived")),
    );
    // Where only some files are looked at, others may need it.
    if args.changed_since.is_none() {
        let used = used.into_iter().flatten().collect();
        remarks.extend(unneeded(settings, &used, &today));
    }
    remarks
}

/// What is to be said of the comments in a file.
fn said_in(of: &Checked, today: &str) -> Vec<String> {
    let Some(source) = &of.source else { return Vec::new() };
    let misread = source.misread.iter().map(|why| format!("{} {why}", of.name));
    let over = source.allowances.iter().filter(|own| own.is_over(today)).map(|own| {
        let (line, until) = (own.line.unwrap_or(1), own.until.as_deref().unwrap_or(""));
        format!("{} line {line}: {} was allowed until {until}", of.name, own.check)
    });
    misread.chain(over).collect()
}

fn allowed(of: &Checked, settings: &Settings, baseline: Option<&Baseline>) -> Allowed {
    let mut all: Vec<Allowance> =
        of.source.iter().flat_map(|source| source.allowances.iter().cloned()).collect();
    let mut numbers = Vec::new();
    for (number, waiver) in settings.waivers(&of.path) {
        numbers.push((all.len(), number));
        all.push(waiver.clone());
    }
    all.extend(baseline.map(|known| known.of(&of.path)).unwrap_or_default());
    Allowed { all, numbers }
}

/// Waivers of the settings that are over, or that nothing needed.
fn unneeded(settings: &Settings, used: &BTreeSet<usize>, today: &str) -> Vec<String> {
    let mut remarks = Vec::new();
    for (number, (_, waiver)) in settings.waivers.iter().enumerate() {
        let what = format!("[[waive]] {}, \u{201c}{}\u{201d}", waiver.check, waiver.reason);
        if waiver.is_over(today) {
            let until = waiver.until.as_deref().unwrap_or("");
            remarks.push(format!("{what}: it held until {until}"));
        } else if !used.contains(&number) {
            remarks.push(format!("{what}: nothing failed that it is for"));
        }
    }
    remarks
}
