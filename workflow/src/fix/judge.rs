//! Whether a model is better or worse than it was, check by check.

use sim_check::{Check, Status, Verdict};

/// Checks whose figure is a depth, a gap or a distance: a larger one is worse.
const DEPTHS: [&str; 6] = ["C1", "C2", "C3", "G3", "J5", "M5"];
/// Figures that differ by less than this share are the same: what an edit elsewhere makes of them.
const SAME: f64 = 1e-3;

/// What a change made of the checks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Outcome {
    /// Checks that are worse, each with how.
    pub worse: Vec<String>,
    /// Whether some check finds less.
    pub is_better: bool,
}

/// How bad it is: what cannot be decided and what fails are alike, for neither holds.
fn rank(status: Status) -> u8 {
    match status {
        Status::Pass => 0,
        Status::Warn => 1,
        Status::Unknown | Status::Fail => 2,
    }
}

/// Findings of a check, those left out of its evidence counted.
pub(super) fn count(check: &Check) -> usize {
    let told = check.evidence.len();
    let more = check
        .evidence
        .last()
        .and_then(|last| last.strip_prefix("and ")?.strip_suffix(" more")?.parse::<usize>().ok());
    more.map_or(told, |more| told.saturating_sub(1).saturating_add(more))
}

/// Compares two verdicts. `adds_geometry`: what could not be decided for want of collision geometry
/// must not fail because of what was added.
pub(super) fn compare(before: &Verdict, after: &Verdict, adds_geometry: bool) -> Outcome {
    let mut outcome = Outcome::default();
    for was in &before.checks {
        let Some(is) = after.check(&was.id) else {
            outcome.worse.push(format!("{} is no longer asked", was.id));
            continue;
        };
        let (old, new) = (rank(was.status), rank(is.status));
        let both_fail = was.status == Status::Fail && is.status == Status::Fail;
        let deeper = || {
            let pair = was.value.zip(is.value).filter(|_| was.unit == is.unit);
            let due = DEPTHS.contains(&was.id.as_str()) && both_fail;
            due && pair.is_some_and(|(was, is)| is > was * (1.0 + SAME))
        };
        let lies_open = was.status == Status::Unknown && is.status == Status::Fail;
        if new > old {
            let first = is.evidence.first().map_or("", String::as_str);
            outcome.worse.push(format!("{} would {}: {first}", was.id, verb(is.status)));
        } else if both_fail && count(is) > count(was) || deeper() {
            outcome.worse.push(format!("{} would find more", was.id));
        } else if lies_open && adds_geometry && was.id.starts_with('C') {
            let first = is.evidence.first().map_or("", String::as_str);
            outcome.worse.push(format!("{} would fail: {first}", was.id));
        } else if new < old || both_fail && count(is) < count(was) || is_rest_unread(was, is) {
            outcome.is_better = true;
        }
    }
    outcome
}

/// Whether a check of geometry, masses or joints has no findings left, and is unknown for what could not
/// be read before either.
fn is_rest_unread(was: &Check, is: &Check) -> bool {
    let is_static = was.id.starts_with(['G', 'M', 'J']);
    is_static && was.status == Status::Fail && is.status == Status::Unknown
}

fn verb(status: Status) -> &'static str {
    match status {
        Status::Pass => "pass",
        Status::Warn => "ask for a look",
        Status::Fail => "fail",
        Status::Unknown => "be unknown",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim_check::{CheckOptions, undecided};

    fn with(check: Check) -> Verdict {
        let mut verdict = undecided("x", &CheckOptions::default());
        verdict.checks.iter_mut().for_each(|c| *c = Check::pass(&c.id));
        verdict.checks.iter_mut().filter(|c| c.id == check.id).for_each(|c| *c = check.clone());
        verdict
    }

    #[test]
    fn fewer_findings_are_better_and_more_or_deeper_ones_worse() {
        let of = |n: usize| with(Check::from_faults("G2", (0..n).map(|i| i.to_string())));
        assert!(compare(&of(30), &of(29), false).is_better, "those left out are counted");
        assert_eq!(compare(&of(1), &of(2), false).worse, ["G2 would find more"]);
        assert_eq!(compare(&of(2), &of(2), false), Outcome::default());
        let deep = |d: f64| with(Check::fail("C2").evidence("a").value(d));
        assert_eq!(compare(&deep(3.0), &deep(4.0), false).worse, ["C2 would find more"]);
    }

    #[test]
    fn what_passed_must_pass_and_what_was_unknown_may_fail_unless_we_added_what_meets() {
        let fails = with(Check::fail("C1").evidence("a meets b"));
        let open = with(Check::unknown("C1", "no colliders"));
        assert_eq!(
            compare(&with(Check::pass("C1")), &fails, false).worse,
            ["C1 would fail: a meets b"]
        );
        assert!(compare(&with(Check::pass("C1")), &open, false).worse[0].contains("be unknown"));
        assert_eq!(compare(&open, &fails, false), Outcome::default());
        assert_eq!(compare(&open, &fails, true).worse.len(), 1);
        assert!(compare(&open, &with(Check::pass("C1")), true).is_better);
        let (broken, unread) = (Check::fail("M4").evidence("a"), Check::unknown("M4", "b.dae"));
        assert!(compare(&with(broken), &with(unread), false).is_better);
        assert!(!compare(&fails, &open, false).is_better);
    }
}
