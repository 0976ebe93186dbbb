//! Verdicts as JUnit XML, which build servers read: a suite per URDF, a case per check.
//!
//! A failed check is a failure, an unknown one an error. What the tier asked for does not depend on,
//! and what was waived, is skipped, so that a suite is green exactly where the tier is reached.
//!
//! ```
//! use sim_check::report::{Item, junit};
//! use sim_check::{CheckOptions, Tier, undecided};
//! let verdict = undecided("stopped after 60 s", &CheckOptions::default());
//! let item = Item { name: "door.urdf", verdict: &verdict, asked: Tier::Audited, source: None };
//! let report = junit::report(&[item]);
//! assert!(report.contains("door.urdf") && report.contains("stopped after 60 s"));
//! ```

use std::fmt::Write as _;

use crate::profile;
use crate::profile::{Severity, Tier};
use crate::report::{Item, expectation};
use crate::verdict::{Check, Status, Verdict};

/// What became of a case.
enum Outcome {
    Passed,
    Skipped(String),
    Failed,
    Error,
}

/// The report on checked models. The same verdicts give the same bytes.
pub fn report(items: &[Item<'_>]) -> String {
    let mut suites = String::new();
    let mut all = Tally::default();
    for item in items {
        let (suite, tally) = suite(item.name, item.verdict, item.asked);
        suites.push_str(&suite);
        all.add(&tally);
    }
    let head = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    format!("{head}<testsuites name=\"kinfold check\" {}>\n{suites}</testsuites>\n", all.shown())
}

/// How many cases ended how.
#[derive(Default)]
struct Tally {
    tests: usize,
    failures: usize,
    errors: usize,
    skipped: usize,
}

impl Tally {
    fn count(&mut self, outcome: &Outcome) {
        self.tests += 1;
        match outcome {
            Outcome::Passed => {}
            Outcome::Skipped(_) => self.skipped += 1,
            Outcome::Failed => self.failures += 1,
            Outcome::Error => self.errors += 1,
        }
    }

    fn add(&mut self, other: &Self) {
        self.tests += other.tests;
        self.failures += other.failures;
        self.errors += other.errors;
        self.skipped += other.skipped;
    }

    fn shown(&self) -> String {
        let Self { tests, failures, errors, skipped } = self;
        format!(
            "tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\""
        )
    }
}

fn suite(name: &str, verdict: &Verdict, asked: Tier) -> (String, Tally) {
    let (mut cases, mut tally) = (String::new(), Tally::default());
    for check in &verdict.checks {
        let outcome = outcome(check, asked);
        tally.count(&outcome);
        case(&mut cases, name, check, &outcome);
    }
    let head = format!("  <testsuite name=\"{}\" {}>\n", escaped(name), tally.shown());
    (format!("{head}{cases}  </testsuite>\n"), tally)
}

fn outcome(check: &Check, asked: Tier) -> Outcome {
    let tier = profile::rule(&check.id).tier;
    if let Some(reason) = &check.waived {
        return Outcome::Skipped(format!("waived: {reason}"));
    }
    if check.holds() {
        return Outcome::Passed;
    }
    if check.severity == Severity::Warning {
        return Outcome::Skipped(format!("{}, only a warning", check.status.name()));
    }
    if tier > asked {
        let (status, tier) = (check.status.name(), tier.name());
        return Outcome::Skipped(format!("{status}, but only tier {tier} asks for it"));
    }
    if check.status == Status::Unknown { Outcome::Error } else { Outcome::Failed }
}

fn case(out: &mut String, of: &str, check: &Check, outcome: &Outcome) {
    let name = escaped(&format!("{} {}", check.id, check.rule));
    let head = format!("    <testcase classname=\"{}\" name=\"{name}\"", escaped(of));
    let message = escaped(&expectation(check));
    let evidence = check.evidence.iter().map(|e| escaped(e)).collect::<Vec<_>>().join("\n");
    // Writing to a string cannot fail.
    let _ = match outcome {
        Outcome::Passed => writeln!(out, "{head}/>"),
        Outcome::Skipped(why) => {
            writeln!(out, "{head}>\n      <skipped message=\"{}\"/>\n    </testcase>", escaped(why))
        }
        Outcome::Failed => writeln!(
            out,
            "{head}>\n      <failure message=\"{message}\">{evidence}</failure>\n    </testcase>"
        ),
        Outcome::Error => writeln!(
            out,
            "{head}>\n      <error message=\"{message}\">{evidence}</error>\n    </testcase>"
        ),
    };
}

/// Text for attributes and elements, inert on whatever page a build server makes of it; characters
/// XML has no way to hold become a question mark.
fn escaped(text: &str) -> String {
    let text = guard::text::shown(text).replace(['\u{fffe}', '\u{ffff}'], "?");
    guard::text::markup(&text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::CheckOptions;
    use roxmltree::Document;

    fn attributes(of: roxmltree::Node<'_, '_>) -> [String; 4] {
        ["tests", "failures", "errors", "skipped"].map(|a| of.attribute(a).unwrap().to_owned())
    }

    #[test]
    fn a_suite_is_green_exactly_where_the_tier_is_reached() {
        let mut verdict = crate::undecided("stopped", &CheckOptions::default());
        for check in &mut verdict.checks {
            check.status = Status::Pass;
        }
        let set = |verdict: &mut Verdict, id: &str, status, waived: Option<&str>| {
            let check = verdict.checks.iter_mut().find(|c| c.id == id).unwrap();
            (check.status, check.waived) = (status, waived.map(str::to_owned));
        };
        set(&mut verdict, "C1", Status::Fail, Some("meant \"so\""));
        set(&mut verdict, "U3", Status::Fail, None);
        set(&mut verdict, "S1", Status::Unknown, None);
        let item = |asked| Item { name: "a<b>.urdf", verdict: &verdict, asked, source: None };
        let text = report(&[item(Tier::Kinematic)]);
        let document = Document::parse(&text).unwrap();
        let tests = verdict.checks.len().to_string();
        assert_eq!(attributes(document.root_element()), [&tests, "0", "0", "3"]);
        let text = report(&[item(Tier::Dynamic)]);
        let document = Document::parse(&text).unwrap();
        assert_eq!(attributes(document.root_element()), [&tests, "0", "1", "2"]);
    }

    #[test]
    fn any_evidence_makes_well_formed_xml() {
        let reason = "bytes \u{1}\u{b} and ]]> & <tags> \"quoted\"\nnext line";
        let verdict = crate::undecided(reason, &CheckOptions::default());
        let item = Item { name: "x", verdict: &verdict, asked: Tier::Parse, source: None };
        let text = report(&[item]);
        let document = Document::parse(&text).unwrap();
        let error = document.descendants().find(|n| n.has_tag_name("error")).unwrap();
        let told = "bytes \\u{1}\\u{b} and ]]> & <tags> \"quoted\"\\u{a}next line";
        assert_eq!(error.text(), Some(told));
    }
}
