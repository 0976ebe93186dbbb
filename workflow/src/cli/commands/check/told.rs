//! A verdict as a person reads it: how far it gets, what to mend first, and what only follows.

use std::fmt::Write as _;

use guard::text::shown;
use sim_check::profile::explain::explain;
use sim_check::profile::rule;
use sim_check::verdict::figure;
use sim_check::{Check, Severity, Status, Subject, Tier, Verdict};

use super::causes::{OVERLAP, cause, follows, more, parts, pose, reason};

/// Findings of a check that are told where nobody asks for all.
const SHOWN: usize = 5;
/// Ids that are listed one by one.
const LISTED: usize = 12;

/// The verdict in lines: what fails first, with what could not be judged because of it, then what
/// else is open, then what a person should look at. `verbose` tells every check and every finding.
pub(super) fn told(verdict: &Verdict, asked: Tier, verbose: bool) -> String {
    let mut out = head(verdict, asked);
    let is_failure = |c: &&Check| c.counts_against() && c.status == Status::Fail;
    let mut failures: Vec<&Check> = verdict.checks.iter().filter(is_failure).collect();
    // What a lower tier asks for comes first.
    failures.sort_by_key(|c| rule(&c.id).tier);
    for check in failures.iter().filter(|c| verbose || !follows(verdict, c)) {
        block(&mut out, "FAIL", check, asked, verbose);
        consequences(&mut out, verdict, check, verbose);
    }
    open(&mut out, verdict, verbose);
    let is_flag = |c: &&Check| {
        c.waived.is_none() && (c.status == Status::Warn || !c.holds() && !c.counts_against())
    };
    for check in verdict.checks.iter().filter(is_flag).filter(|c| c.status != Status::Unknown) {
        block(&mut out, "WARN", check, asked, verbose);
    }
    for check in &verdict.checks {
        if let Some(why) = &check.waived {
            block(&mut out, "WAIVED", check, asked, verbose);
            line(&mut out, &format!("waived: {}", shown(why)));
        }
    }
    passed(&mut out, verdict, verbose);
    if let Some(first) = failures.first() {
        let _ = writeln!(
            out,
            "\n`kinfold explain {}` says why it matters, how it is measured and how to mend it",
            first.id
        );
    }
    out
}

/// The line that says all in short.
fn head(verdict: &Verdict, asked: Tier) -> String {
    let below =
        if verdict.tier < asked { format!(", asked for {}", asked.name()) } else { "".into() };
    let counts = verdict.counts;
    let words = [
        (counts.fail, "fail"),
        (counts.unknown, "not judged"),
        (counts.warn, "to look at"),
        (counts.waived, "waived"),
    ];
    let some = words.iter().filter(|(count, _)| *count > 0);
    let some: String = some.map(|(count, word)| format!("{count} {word}, ")).collect();
    let (tier, passed) = (verdict.tier.name(), counts.pass);
    let judged = verdict.judged.as_ref().map_or(String::new(), |judged| {
        let (what, base) = (judged.subject.name(), judged.base.name());
        let article = if judged.subject == Subject::Object { "an" } else { "a" };
        let other = if judged.subject == Subject::Object { "robot" } else { "object" };
        let because = shown(&judged.because);
        let hint = format!("--as {other} judges it so");
        format!("judged as {article} {what} on a {base} base: {because} ({hint})\n")
    });
    format!("{judged}tier {tier} of {}{below}: {some}{passed} passed\n", verdict.profile)
}

/// A check with what was found, what was expected and what mends it.
fn block(out: &mut String, word: &str, check: &Check, asked: Tier, verbose: bool) {
    let tier = rule(&check.id).tier;
    let beyond = if tier > asked { format!("  (only tier {})", tier.name()) } else { "".into() };
    let _ = writeln!(out, "\n{word:<6} {:<3} {}{beyond}", check.id, check.rule);
    let mut findings = if verbose { check.evidence.clone() } else { collapsed(&check.evidence) };
    let left = findings.len().saturating_sub(SHOWN);
    if !verbose && left > 1 {
        findings.truncate(SHOWN);
        findings.push(format!("and {left} more lines: --verbose"));
    }
    findings.iter().for_each(|finding| line(out, &shown(finding)));
    // Of a check that holds, the figure is none that anybody has to change.
    let value = check.value.filter(|_| !check.holds());
    let value = value.map(|v| format!("found {} {}, ", figure(v), check.unit));
    line(out, &shown(&format!("{}expected {}", value.unwrap_or_default(), check.threshold)));
    if !check.holds() && check.waived.is_none() {
        let remedy = explain(&check.id).map(|told| told.remedy(&check.evidence));
        line(out, &format!("mend: {}", remedy.unwrap_or_default()));
    }
}

fn line(out: &mut String, words: &str) {
    let _ = writeln!(out, "{:11}{words}", "");
}

/// What fails, or is not judged, because of this check.
fn consequences(out: &mut String, verdict: &Verdict, check: &Check, verbose: bool) {
    let because = |c: &&Check| {
        c.status == Status::Unknown && cause(verdict, c).is_some_and(|cause| cause.id == check.id)
    };
    let open: Vec<&Check> = verdict.checks.iter().filter(because).collect();
    if !open.is_empty() {
        line(out, &format!("{} is why {} cannot be judged", check.id, named(&open, verdict)));
    }
    let after: Vec<&Check> = verdict.checks.iter().filter(|c| follows(verdict, c)).collect();
    if check.id == "C1" && !after.is_empty() && !verbose {
        let (ids, verb) = (named(&after, verdict), if after.len() == 1 { "fails" } else { "fail" });
        line(out, &format!("C1 is why {ids} {verb}, too: the same parts overlap on the way"));
    }
}

/// What is not judged for a reason of its own, by reason.
fn open(out: &mut String, verdict: &Verdict, verbose: bool) {
    let mut groups: Vec<(String, Vec<&Check>)> = Vec::new();
    for check in verdict.checks.iter().filter(|c| c.status == Status::Unknown) {
        let behind = cause(verdict, check);
        if behind.is_some_and(|cause| cause.status == Status::Fail) {
            continue;
        }
        let reason = reason(behind.unwrap_or(check));
        match groups.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, checks)) => checks.push(check),
            None => groups.push((reason, vec![check])),
        }
    }
    for (reason, checks) in groups {
        let counts = checks.iter().any(|c| c.severity == Severity::Error);
        let word = if counts { "OPEN" } else { "WARN" };
        let _ = writeln!(out, "\n{word:<6} {} cannot be judged", named(&checks, verdict));
        line(out, &shown(&reason));
        let others = checks.iter().flat_map(|c| &c.evidence).filter(|e| **e != reason);
        if verbose {
            others.for_each(|other| line(out, &shown(other)));
        }
        let first = checks.iter().min_by_key(|c| rule(&c.id).tier);
        let remedy =
            first.and_then(|c| Some(explain(&c.id)?.remedy(std::slice::from_ref(&reason))));
        // One reason for everything is none that the model can be mended for.
        if let Some(remedy) = remedy.filter(|_| checks.len() < verdict.checks.len()) {
            line(out, &format!("mend: {remedy}"));
        }
    }
}

/// Checks by their ids: `S1, S3 and S5`.
fn named(checks: &[&Check], verdict: &Verdict) -> String {
    if checks.len() == verdict.checks.len() {
        return format!("all {} checks", checks.len());
    }
    if checks.len() > LISTED {
        return format!("{} other checks", checks.len());
    }
    let ids: Vec<&str> = checks.iter().map(|c| c.id.as_str()).collect();
    match &ids[..] {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
    }
}

fn passed(out: &mut String, verdict: &Verdict, verbose: bool) {
    let passed: Vec<_> = verdict.checks.iter().filter(|c| c.status == Status::Pass).collect();
    if !verbose {
        if !passed.is_empty() {
            let _ = writeln!(out, "\n{} passed (--verbose lists them)", passed.len());
        }
        return;
    }
    out.push('\n');
    for check in passed {
        let value = check.value.map(|v| format!("  {} {}", figure(v), check.unit));
        let told =
            format!("{:<6} {:<3} {}{}", "pass", check.id, check.rule, value.unwrap_or_default());
        let _ = writeln!(out, "{}", shown(told.trim_end()));
    }
}

/// Findings where poses in which the same two parts overlap are one line.
fn collapsed(findings: &[String]) -> Vec<String> {
    let overlaps = |finding: &str| {
        let found = pose(finding).1;
        let parts = parts(found).filter(|_| found != finding)?;
        Some((parts.to_owned(), found[parts.len() + OVERLAP.len()..].to_owned()))
    };
    let poses = findings.iter().filter(|f| overlaps(f).is_some()).count();
    let untold = findings.iter().find_map(|f| more(f)).filter(|_| poses > 0);
    let all = poses + untold.unwrap_or(0);
    let mut told: Vec<String> = Vec::new();
    let mut known: Vec<String> = Vec::new();
    for finding in findings {
        let Some((parts, deepest)) = overlaps(finding) else {
            if more(finding).is_none() || untold.is_none() {
                told.push(finding.clone());
            }
            continue;
        };
        if known.contains(&parts) {
            continue;
        }
        let same = findings.iter().filter_map(|f| overlaps(f)).filter(|(p, _)| *p == parts);
        let depths: Vec<String> = same.map(|(_, depth)| depth).collect();
        let (count, equal) = (depths.len(), depths.iter().all(|d| *d == deepest));
        let least = if untold.is_some() { "at least " } else { "" };
        let to = if equal { "" } else { "up to " };
        told.push(match count {
            1 => finding.clone(),
            _ => format!("{least}{count} of {all} poses: {parts}{OVERLAP}{to}{deepest}"),
        });
        known.push(parts);
    }
    told
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim_check::{CheckOptions, undecided};

    fn passing(but: Vec<Check>) -> Verdict {
        let mut verdict = undecided("x", &CheckOptions::default());
        verdict.checks.iter_mut().for_each(|c| *c = Check::pass(&c.id));
        for check in but {
            let place = verdict.checks.iter_mut().find(|c| c.id == check.id).unwrap();
            *place = check;
        }
        let count = |status| verdict.checks.iter().filter(|c| c.status == status).count();
        verdict.counts.pass = count(Status::Pass);
        verdict.counts.fail = count(Status::Fail);
        verdict.counts.unknown = count(Status::Unknown);
        verdict.counts.warn = count(Status::Warn);
        verdict.tier = Tier::Static;
        verdict
    }

    const PAIR: &str = "`base_link` and `right_gripper` overlap by 127.75 mm";

    #[test]
    fn fifteen_equal_poses_are_one_line() {
        let pose = |i: usize| format!("`a` at {i} deg, `b` at 3 deg: {PAIR}");
        let mut found: Vec<String> = (0..15).map(pose).collect();
        found.push("`a` at 1 deg: `x` and `y` overlap by 3.00 mm".into());
        found.push("looked at every pair".into());
        let told = collapsed(&found);
        assert_eq!(told[0], format!("15 of 16 poses: {PAIR}"));
        assert_eq!(told[1..], found[15..]);
        found.push("and 8 more".into());
        assert_eq!(collapsed(&found)[0], format!("at least 15 of 24 poses: {PAIR}"));
        let deeper = [
            "`a` at 1 deg: `x` and `y` overlap by 3.00 mm",
            "`a` at 2 deg: `x` and `y` overlap by 2.00 mm",
        ];
        let told = collapsed(&deeper.map(String::from));
        assert_eq!(told, ["2 of 2 poses: `x` and `y` overlap by up to 3.00 mm"]);
        assert_eq!(collapsed(&["`x` and `y` overlap by 3.00 mm".into()]).len(), 1);
    }

    #[test]
    fn what_fails_comes_first_with_what_it_is_the_cause_of() {
        let reason = "C1 does not hold: parts that overlap at rest would be flung apart";
        let verdict = passing(vec![
            Check::fail("C1").value(127.75).evidence(PAIR),
            Check::fail("C3").evidence(format!("`a` at 3 deg: {PAIR}")),
            Check::unknown("S1", reason),
            Check::unknown("S3", reason),
        ]);
        let text = told(&verdict, Tier::Kinematic, false);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[..10],
            [
                "tier static of simready-urdf 1.0, asked for kinematic: 2 fail, 2 not judged, 39 passed",
                "",
                "FAIL   C1  no parts overlap at rest",
                "           `base_link` and `right_gripper` overlap by 127.75 mm",
                "           found 127.8 mm, expected depth <= max(1 mm, 0.2 % of the diagonal)",
                "           mend: shrink or move the collision pieces of the two links that are named, or waive a pin that sits in its hole",
                "           C1 is why S1 and S3 cannot be judged",
                "           C1 is why C3 fails, too: the same parts overlap on the way",
                "",
                "39 passed (--verbose lists them)",
            ]
        );
        let all = told(&verdict, Tier::Kinematic, true);
        assert!(all.contains("FAIL   C3 ") && all.contains("pass   F1 "), "{all}");
    }

    #[test]
    fn one_reason_for_everything_is_told_once() {
        let verdict = undecided("it took too long", &CheckOptions::default());
        let text = told(&verdict, Tier::Static, false);
        assert_eq!(text.matches("it took too long").count(), 1, "{text}");
        assert!(text.contains(" checks cannot be judged"), "{text}");
        assert_eq!(text.lines().count(), 4, "{text}");
    }

    #[test]
    fn what_strangers_say_is_inert() {
        let mut check = Check::fail("F3");
        check.evidence = vec!["a\nFAIL   C1  \u{1b}[2J".into()];
        let text = told(&passing(vec![check]), Tier::Static, false);
        assert!(!text.contains('\u{1b}') && !text.contains("\nFAIL   C1"), "{text}");
    }
}
