//! What a check found and what it amounts to: checks, tiers, the verdict.
//!
//! ```
//! use sim_check::Check;
//! let check = Check::fail("C1").value(3.2).evidence("`door` and `body` overlap by 3.20 mm");
//! assert!(check.counts_against());
//! assert_eq!((check.unit.as_str(), check.rule.as_str()), ("mm", "no parts overlap at rest"));
//! ```

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::options::CheckOptions;
use crate::profile::due::{Due, asked_of};
use crate::profile::subject::{Judged, Subject};
use crate::profile::{self, Group, Severity, Tier};

/// Name and version of the profile the verdict is about.
pub const PROFILE: &str = "simready-urdf 1.0";

/// What became of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Holds.
    Pass,
    /// Holds, or is of severity warning, but a person should look.
    Warn,
    /// Does not hold.
    Fail,
    /// Could not be decided; counts as a failure.
    Unknown,
}

impl Status {
    /// Its name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Warn => "warn",
            Self::Fail => "fail",
            Self::Unknown => "unknown",
        }
    }
}

/// One check of the profile and what it found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Id in the profile, like `C1`.
    pub id: String,
    /// The rule in plain words.
    pub rule: String,
    /// What became of it.
    pub status: Status,
    /// Whether failing it lowers the tier.
    pub severity: Severity,
    /// The worst figure found.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// The bound, with its unit.
    pub threshold: String,
    /// Links, joints, lines and figures behind the status; worst first.
    pub evidence: Vec<String>,
    /// Why somebody lets this failure pass: it does not lower the tier then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waived: Option<String>,
}

/// Most pieces of evidence a check keeps.
pub const MAX_EVIDENCE: usize = 20;

impl Check {
    fn new(id: &str, status: Status) -> Self {
        let rule = profile::rule(id);
        Self {
            id: id.into(),
            rule: rule.words.into(),
            status,
            severity: rule.severity,
            value: None,
            unit: rule.unit.into(),
            threshold: rule.threshold(),
            evidence: Vec::new(),
            waived: None,
        }
    }

    /// The rule holds.
    pub fn pass(id: &str) -> Self {
        Self::new(id, Status::Pass)
    }

    /// The rule holds, but a person should look.
    pub fn warn(id: &str) -> Self {
        Self::new(id, Status::Warn)
    }

    /// The rule does not hold.
    pub fn fail(id: &str) -> Self {
        Self::new(id, Status::Fail)
    }

    /// The rule could not be decided, for this reason.
    pub fn unknown(id: &str, reason: impl Into<String>) -> Self {
        Self::new(id, Status::Unknown).evidence(reason)
    }

    /// Fails with the faults, passes without any.
    pub fn from_faults(id: &str, faults: impl IntoIterator<Item = String>) -> Self {
        let mut faults = faults.into_iter().peekable();
        let check = if faults.peek().is_some() { Self::fail(id) } else { Self::pass(id) };
        check.evidences(faults)
    }

    /// The same check with the worst figure found (dropped if it is not finite).
    #[must_use]
    pub fn value(mut self, value: f64) -> Self {
        self.value = Some(value).filter(|v| v.is_finite());
        self
    }

    /// The same check with its figure in another unit than the profile's.
    #[must_use]
    pub fn unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = unit.into();
        self
    }

    /// The same check with another bound than the profile's text gives.
    #[must_use]
    pub fn threshold(mut self, threshold: impl Into<String>) -> Self {
        self.threshold = threshold.into();
        self
    }

    /// The same check with one more piece of evidence.
    #[must_use]
    pub fn evidence(self, evidence: impl Into<String>) -> Self {
        self.evidences([evidence.into()])
    }

    /// The same check with more evidence; beyond [`MAX_EVIDENCE`] only the count is kept.
    #[must_use]
    pub fn evidences(mut self, evidence: impl IntoIterator<Item = String>) -> Self {
        // It quotes names out of files that anybody may have written.
        let mut rest = evidence.into_iter().map(|e| guard::text::shown(&e).into_owned());
        let room = MAX_EVIDENCE.saturating_sub(self.evidence.len());
        self.evidence.extend(rest.by_ref().take(room));
        let left_out = rest.count();
        if left_out > 0 {
            self.evidence.push(format!("and {left_out} more"));
        }
        self
    }

    /// Whether it neither failed nor stayed unknown.
    pub fn holds(&self) -> bool {
        matches!(self.status, Status::Pass | Status::Warn)
    }

    /// Whether it lowers the tier.
    pub fn counts_against(&self) -> bool {
        !self.holds() && self.severity == Severity::Error && self.waived.is_none()
    }
}

/// How many checks ended how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Status pass.
    pub pass: usize,
    /// Status warn, or a failure of severity warning.
    pub warn: usize,
    /// Status fail, severity error.
    pub fail: usize,
    /// Status unknown, severity error.
    pub unknown: usize,
    /// Failures somebody lets pass.
    #[serde(default)]
    pub waived: usize,
}

/// Everything found about one URDF.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Name and version of the profile.
    pub profile: String,
    /// What it was judged as, where that was not told to be an asset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judged: Option<Judged>,
    /// The highest tier whose checks, and all below, hold.
    pub tier: Tier,
    /// The highest tier that was asked for; checks above it were not run.
    pub asked: Tier,
    /// Name of the robot; empty if unreadable.
    pub robot: String,
    /// BLAKE3 of the URDF's bytes, hex; empty if unreadable.
    pub urdf_blake3: String,
    /// Links and moving joints found.
    pub links: usize,
    /// Joints that move.
    pub moving_joints: usize,
    /// Seed of every random choice.
    pub seed: u64,
    /// How many checks ended how.
    pub counts: Counts,
    /// The checks in the order of the profile.
    pub checks: Vec<Check>,
}

impl Verdict {
    /// The check of that id.
    pub fn check(&self, id: &str) -> Option<&Check> {
        self.checks.iter().find(|c| c.id == id)
    }

    /// The checks that lower the tier, in the order of the profile.
    pub fn failures(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|c| c.counts_against())
    }

    /// Pretty JSON; the same verdict gives the same bytes. Ends with a newline.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        guard::text::json(&text).into_owned() + "\n"
    }
}

/// A figure with four significant digits.
pub fn figure(v: f64) -> String {
    let magnitude = if v == 0.0 { 0 } else { v.abs().log10().floor() as i32 };
    if !(-4..7).contains(&magnitude) {
        return format!("{v:.3e}");
    }
    let text = format!("{v:.*}", (3 - magnitude).max(0) as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// How many checks ended how.
pub(crate) fn count(checks: &[Check]) -> Counts {
    let mut counts = Counts::default();
    for check in checks {
        let slot = match check.status {
            _ if check.waived.is_some() => &mut counts.waived,
            Status::Pass => &mut counts.pass,
            Status::Fail if check.counts_against() => &mut counts.fail,
            Status::Unknown if check.counts_against() => &mut counts.unknown,
            _ => &mut counts.warn,
        };
        *slot += 1;
    }
    counts
}

/// The highest tier whose checks, and all below, hold; at most `asked`.
pub(crate) fn tier_of(checks: &[Check], asked: Tier) -> Tier {
    let holds = |tier: Tier| {
        let mut of_tier = checks.iter().filter(|c| profile::rule(&c.id).tier == tier).peekable();
        of_tier.peek().is_some() && of_tier.all(|c| !c.counts_against())
    };
    let reached = |t: &Tier| *t <= asked && holds(*t);
    Tier::ALL[1..].iter().copied().take_while(reached).last().unwrap_or_default()
}

/// Sorts checks into the order of the profile, drops those above the asked tier and adds what is
/// missing as unknown: a check nobody ran is not a pass. T4 applies only where counts are expected, the group
/// R only where an asset has a sidecar.
pub(crate) fn complete(
    mut checks: Vec<Check>,
    options: &CheckOptions,
    subject: Subject,
) -> Vec<Check> {
    let asked = options.up_to;
    let is_asked = |r: &&profile::Rule| applies(r, options) && asked_of(r.id, subject) != Due::Not;
    for rule in profile::RULES.iter().filter(|r| r.tier <= asked).filter(is_asked) {
        if !checks.iter().any(|c| c.id == rule.id) {
            checks.push(Check::unknown(rule.id, "the check gave no result"));
        }
    }
    checks.retain(|c| profile::rule(&c.id).tier <= asked && asked_of(&c.id, subject) != Due::Not);
    for check in checks.iter_mut().filter(|c| asked_of(&c.id, subject) == Due::Flag) {
        check.severity = Severity::Warning;
    }
    checks.sort_by_key(|c| profile::position(&c.id));
    checks
}

/// Whether a rule is asked of every model.
pub(crate) fn applies(rule: &profile::Rule, options: &CheckOptions) -> bool {
    (rule.id != "T4" || options.expected.is_some()) && rule.group != Group::Right
}

/// Lets failures pass that somebody answers for. What is unknown stays so: nobody has looked at it.
pub(crate) fn waive(checks: &mut [Check], waivers: &BTreeMap<String, String>) {
    for check in checks.iter_mut().filter(|c| c.status == Status::Fail) {
        check.waived = waivers.get(&check.id).cloned();
    }
}

/// All checks of a group unknown, for one reason.
pub(crate) fn all_unknown(group: Group, reason: &str) -> Vec<Check> {
    let of_group = profile::RULES.iter().filter(|r| r.group == group);
    of_group.map(|r| Check::unknown(r.id, reason)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every check passes, but for the given ones.
    fn tier_with(but: Vec<Check>) -> Tier {
        let passes = profile::RULES.iter().map(|r| Check::pass(r.id));
        let mut checks: Vec<Check> = passes.filter(|c| but.iter().all(|b| b.id != c.id)).collect();
        checks.extend(but);
        let checks = complete(checks, &CheckOptions::default(), Subject::Object);
        tier_of(&checks, Tier::Audited)
    }

    #[test]
    fn the_tier_is_the_highest_whose_checks_and_all_below_hold() {
        assert_eq!(tier_with(vec![]), Tier::Audited);
        assert_eq!(tier_with(vec![Check::fail("P2")]), Tier::Dynamic);
        assert_eq!(tier_with(vec![Check::fail("M7")]), Tier::Dynamic);
        assert_eq!(tier_with(vec![Check::fail("S3"), Check::fail("C1")]), Tier::Static);
        assert_eq!(tier_with(vec![Check::fail("G2")]), Tier::Parse);
        assert_eq!(tier_with(vec![Check::fail("F1")]), Tier::None);
    }

    #[test]
    fn unknown_is_a_failure_and_a_warning_is_none() {
        assert_eq!(tier_with(vec![Check::unknown("C1", "no colliders")]), Tier::Static);
        let warnings = ["U3", "J6", "L1", "L2"].map(Check::fail).to_vec();
        assert_eq!(tier_with(warnings), Tier::Audited);
        assert_eq!(tier_with(vec![Check::warn("M2"), Check::warn("J4")]), Tier::Audited);
    }

    #[test]
    fn a_waiver_lets_a_failure_pass_but_nothing_unknown() {
        let waivers = BTreeMap::from([("C1".into(), "a pin sits in its hole".into())]);
        let waived = |check: Check| {
            let mut checks = vec![check];
            waive(&mut checks, &waivers);
            checks.remove(0)
        };
        let failed = waived(Check::fail("C1"));
        assert_eq!(
            (failed.waived.as_deref(), failed.status),
            (Some("a pin sits in its hole"), Status::Fail)
        );
        assert_eq!(count(std::slice::from_ref(&failed)), Counts { waived: 1, ..Counts::default() });
        assert_eq!(tier_with(vec![failed]), Tier::Audited);
        assert_eq!(tier_with(vec![waived(Check::unknown("C1", "no colliders"))]), Tier::Static);
        assert_eq!(waived(Check::fail("C2")).waived, None);
    }

    #[test]
    fn evidence_is_inert_whatever_it_quotes() {
        let check = Check::unknown("F1", "link `a\nkinematic  good.urdf\u{9b}\u{202e}`");
        let check = check.evidence("b\u{1b}[2J");
        let expected = ["link `a\\u{a}kinematic  good.urdf\\u{9b}\\u{202e}`", "b\\u{1b}[2J"];
        assert_eq!(check.evidence, expected);
    }

    #[test]
    fn a_check_nobody_ran_is_unknown() {
        let options = CheckOptions { up_to: Tier::Static, ..CheckOptions::default() };
        let some = vec![Check::pass("F1"), Check::fail("S1")];
        let checks = complete(some, &options, Subject::Object);
        assert!(checks.iter().all(|c| c.id != "S1" && c.id != "T4"), "not asked for");
        let unknown = checks.iter().filter(|c| c.status == Status::Unknown).count();
        assert_eq!((checks[0].status, unknown), (Status::Pass, checks.len() - 1));
    }

    #[test]
    fn ids_of_the_profile_are_unique_and_evidence_is_bounded() {
        let ids: std::collections::BTreeSet<_> = profile::RULES.iter().map(|r| r.id).collect();
        assert_eq!(ids.len(), profile::RULES.len());
        let many = Check::from_faults("C2", (0..100).map(|i| i.to_string()));
        assert_eq!(many.evidence.last().unwrap(), "and 80 more");
        assert_eq!(many.evidence.len(), MAX_EVIDENCE + 1);
    }

    #[test]
    fn figures_keep_four_digits() {
        let shown = [0.0, 1.0, 83.333_333, 1234.56, 0.012_345_6, 1e-9, -0.3, 2.5e9].map(figure);
        let expected = ["0", "1", "83.33", "1235", "0.01235", "1.000e-9", "-0.3", "2.500e9"];
        assert_eq!(shown, expected);
    }
}
