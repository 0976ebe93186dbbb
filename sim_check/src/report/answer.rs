//! Who answers for what fails: waivers by file and element, with a reason and a last day, and findings that
//! were known before.
//!
//! ```
//! use sim_check::report::answer::{Allowance, answer};
//! use sim_check::{CheckOptions, undecided};
//! let mut verdict = undecided("stopped after 60 s", &CheckOptions::default());
//! // What is unknown cannot be let pass: nobody has looked at it.
//! let used = answer(&mut verdict, &[Allowance::new("C1", "the pin sits in its hole")], "2026-11-30");
//! assert_eq!(used, [false]);
//! ```

use std::collections::BTreeSet;

use crate::verdict::{self, Check, Status, Verdict};

/// What may fail, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Allowance {
    /// Id of the check.
    pub check: String,
    /// The link, joint, body, geom or mesh that it is for; none for the whole file.
    pub about: Option<String>,
    /// One finding and no other, as [`known`] writes it.
    pub finding: Option<String>,
    /// Why it may.
    pub reason: String,
    /// The last day on which it may, `YYYY-MM-DD`; none for ever.
    pub until: Option<String>,
    /// Where it is said, in a file's own text.
    pub line: Option<usize>,
}

impl Allowance {
    /// Lets a check fail for the whole file, for ever.
    pub fn new(check: &str, reason: &str) -> Self {
        let (check, reason) = (check.to_owned(), reason.to_owned());
        Self { check, about: None, finding: None, reason, until: None, line: None }
    }

    /// The same up to a day, with it.
    #[must_use]
    pub fn until(self, until: Option<String>) -> Self {
        Self { until, ..self }
    }

    /// The same for one element.
    #[must_use]
    pub fn about(self, about: Option<String>) -> Self {
        Self { about, ..self }
    }

    /// Whether it has lapsed on that day.
    pub fn is_over(&self, today: &str) -> bool {
        self.until.as_deref().is_some_and(|last| last < today)
    }

    fn covers(&self, check: &Check, finding: Option<&str>) -> bool {
        let fits = |finding: &str| {
            self.about.as_deref().is_none_or(|about| quoted(finding).any(|name| name == about))
                && self.finding.as_deref().is_none_or(|own| own == known(finding))
        };
        let is_whole = self.about.is_none() && self.finding.is_none();
        self.check == check.id && finding.map_or(is_whole, fits)
    }
}

/// What a finding quotes.
pub(crate) fn quoted(finding: &str) -> impl Iterator<Item = &str> {
    finding.split('`').skip(1).step_by(2)
}

/// A finding without its figures, by which it is known again.
pub fn known(finding: &str) -> String {
    let mut out = String::with_capacity(finding.len());
    let mut is_quoted = false;
    for c in finding.chars() {
        is_quoted ^= c == '`';
        match c {
            // Names keep their digits.
            '0'..='9' if !is_quoted => {
                if !out.ends_with('#') {
                    out.push('#');
                }
            }
            '.' if !is_quoted && out.ends_with('#') => {}
            c => out.push(c),
        }
    }
    out
}

/// Lets those checks pass that failed and for each of whose findings somebody answers, and counts again.
/// Returns for each allowance whether it was of use.
pub fn answer(verdict: &mut Verdict, allowances: &[Allowance], today: &str) -> Vec<bool> {
    let mut is_used = vec![false; allowances.len()];
    for check in
        verdict.checks.iter_mut().filter(|c| c.status == Status::Fail && c.waived.is_none())
    {
        let mut used = BTreeSet::new();
        let mut answered = |finding: Option<&str>| {
            let by = allowances.iter().position(|a| !a.is_over(today) && a.covers(check, finding));
            used.extend(by);
            by.is_some()
        };
        let is_answered = match check.evidence.is_empty() {
            true => answered(None),
            false => check.evidence.iter().filter(|finding| !answered(Some(finding))).count() == 0,
        };
        if is_answered {
            let mut reasons: Vec<&str> = Vec::new();
            for &by in &used {
                is_used[by] = true;
                let reason = allowances[by].reason.as_str();
                if !reasons.contains(&reason) {
                    reasons.push(reason);
                }
            }
            check.waived = Some(reasons.join("; "));
        }
    }
    verdict.counts = verdict::count(&verdict.checks);
    verdict.tier = verdict::tier_of(&verdict.checks, verdict.asked);
    is_used
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CheckOptions, undecided};

    fn failing(evidence: &[&str]) -> Verdict {
        let mut verdict = undecided("not run", &CheckOptions::default());
        for check in &mut verdict.checks {
            *check = Check::pass(&check.id);
        }
        let c1 = verdict.checks.iter_mut().find(|c| c.id == "C1").unwrap();
        *c1 = Check::fail("C1").evidences(evidence.iter().map(|e| (*e).to_owned()));
        verdict
    }

    #[test]
    fn a_failure_passes_only_where_each_of_its_findings_is_answered_for() {
        let two = ["`door` and `body` overlap by 3.2 mm", "`lid` and `body` overlap by 1 mm"];
        let door = Allowance::new("C1", "a hinge").about(Some("door".into()));
        let lid = Allowance::new("C1", "a rim").about(Some("lid".into()));
        let mut verdict = failing(&two);
        assert_eq!(answer(&mut verdict, std::slice::from_ref(&door), "2026-01-01"), [false]);
        assert_eq!(verdict.check("C1").unwrap().waived, None);
        assert_eq!(answer(&mut verdict, &[door, lid], "2026-01-01"), [true, true]);
        assert_eq!(verdict.check("C1").unwrap().waived.as_deref(), Some("a hinge; a rim"));
        assert_eq!((verdict.counts.waived, verdict.counts.fail), (1, 0));
    }

    #[test]
    fn a_waiver_holds_on_its_last_day_and_no_longer() {
        let brief = Allowance::new("C1", "until the next scan").until(Some("2027-03-31".into()));
        for (today, is_used) in [("2027-03-31", true), ("2027-04-01", false)] {
            let mut verdict = failing(&["`a` and `b` overlap by 2 mm"]);
            assert_eq!(answer(&mut verdict, std::slice::from_ref(&brief), today), [is_used]);
        }
    }

    #[test]
    fn a_known_finding_is_known_with_other_figures_and_not_with_other_names() {
        let of = |finding: &str| Allowance {
            finding: Some(known(finding)),
            ..Allowance::new("C1", "known before")
        };
        let before = of("`door_2` and `body` overlap by 3.25 mm");
        for (finding, is_known) in [
            ("`door_2` and `body` overlap by 14 mm", true),
            ("`door_3` and `body` overlap by 3.25 mm", false),
        ] {
            let mut verdict = failing(&[finding]);
            assert_eq!(
                answer(&mut verdict, std::slice::from_ref(&before), "2026-01-01"),
                [is_known]
            );
        }
    }
}
