//! What `kinfold check` finds: by the rules of each kind.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

use sim_check::{Asked, CheckOptions, Status, Subject, Tier, Verdict};

use super::answers::{Asker, Found, Seen};
use super::program::numberless;
use crate::cli::isolated::{Checker, Isolation};
use crate::mutate::manifest::{Manifest, Mutant};

/// `kinfold check` on one model and its mutants.
pub(super) struct Ours<'a> {
    checker: Checker<'a>,
    original: Option<Verdict>,
}

/// How all of them are judged: as the original was found to be, for a defect must not change that.
pub(super) fn options(manifest: &Manifest) -> CheckOptions {
    let is_robot = manifest.original.judged == Subject::Robot.name();
    let subject = if is_robot { Subject::Robot } else { Subject::Object };
    CheckOptions { up_to: Tier::Dynamic, subject: Asked::As(subject), ..CheckOptions::default() }
}

impl<'a> Ours<'a> {
    pub(super) fn new(isolation: &'a Isolation, options: &'a CheckOptions) -> Self {
        Self { checker: Checker::new(isolation, options), original: None }
    }
}

/// Findings of a verdict, a rule and its words each: what fails, and what a person should look at.
fn findings<'v>(verdict: &'v Verdict, rules: &[String]) -> BTreeSet<(&'v str, &'v str)> {
    let told = |s: Status| matches!(s, Status::Fail | Status::Warn);
    let asked = |id: &String| rules.is_empty() || rules.contains(id);
    let checks = verdict.checks.iter().filter(|c| told(c.status) && asked(&c.id));
    let is_finding =
        |e: &&String| !["looked at", "judged at", "and "].iter().any(|w| e.starts_with(w));
    checks
        .flat_map(|c| {
            let said = c.evidence.iter().filter(is_finding).map(|e| (c.id.as_str(), e.as_str()));
            said.chain([(c.id.as_str(), "")])
        })
        .collect()
}

impl Asker for Ours<'_> {
    fn original(&mut self, file: &Path) -> Seen {
        let began = Instant::now();
        let verdict = self.checker.check(file);
        let failing: Vec<&str> = verdict.failures().map(|c| c.id.as_str()).collect();
        let alarm = (!failing.is_empty()).then(|| failing.join(", "));
        let seen = Seen { alarm, seconds: began.elapsed().as_secs_f64() };
        self.original = Some(verdict);
        seen
    }

    fn mutant(&mut self, file: &Path, mutant: &Mutant) -> Found {
        let began = Instant::now();
        let verdict = self.checker.check(file);
        let seconds = began.elapsed().as_secs_f64();
        let Some(original) = &self.original else {
            return Found { is_found: false, by: "the original was not asked".into(), seconds };
        };
        // Figures of what was found before may be others: they make no new finding.
        let known: BTreeSet<(&str, String)> =
            findings(original, &[]).into_iter().map(|(id, w)| (id, numberless(w))).collect();
        let is_known = |f: &(&str, &str)| known.contains(&(f.0, numberless(f.1)));
        let now = findings(&verdict, &mutant.rules);
        let new: Vec<_> = now.iter().filter(|f| !is_known(f)).collect();
        let is_found = !new.is_empty();
        let by = match new.iter().find(|f| !f.1.is_empty()).or(new.first()) {
            Some((id, words)) => format!("{id}: {words}"),
            None => {
                let elsewhere = findings(&verdict, &[]);
                let ids: BTreeSet<&str> =
                    elsewhere.iter().filter(|f| !is_known(f)).map(|f| f.0).collect();
                let open = verdict.checks.iter().filter(|c| c.status == Status::Unknown);
                let open: Vec<&str> = open.map(|c| c.id.as_str()).take(4).collect();
                let ids: Vec<&str> = ids.into_iter().collect();
                format!(
                    "nothing by its rules; others: [{}], unknown: [{}]",
                    ids.join(" "),
                    open.join(" ")
                )
            }
        };
        Found { is_found, by, seconds }
    }
}
