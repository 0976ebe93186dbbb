//! Verdicts as Markdown, for a pull request or a job's summary.
//!
//! Findings quote names out of files that anybody may have written; each stands in a code span, in which
//! nothing acts.

use std::fmt::Write as _;

use super::{Item, expectation};
use crate::profile::explain::explain;
use crate::verdict::Status;

/// Findings of a check that are told.
const SHOWN: usize = 5;

/// The report; the same verdicts give the same bytes.
pub fn report(items: &[Item<'_>]) -> String {
    let enough = items.iter().filter(|i| i.is_enough()).count();
    let mut out = format!(
        "**{enough} of {} models reach the tier that is asked of them.**\n\n\
         | Model | Tier | Asked for | Fails | Not judged | To look at | Waived |\n\
         |---|---|---|---|---|---|---|\n",
        items.len()
    );
    for item in items {
        let counts = item.verdict.counts;
        let mark = if item.is_enough() { "" } else { " ✗" };
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "| {}{mark} | {} | {} | {} | {} | {} | {} |",
            span(&item.name.replace('|', "\\|")),
            item.verdict.tier.name(),
            item.asked.name(),
            counts.fail,
            counts.unknown,
            counts.warn,
            counts.waived
        );
    }
    for item in items.iter().filter(|i| !i.is_enough()) {
        let _ = writeln!(out, "\n### {}\n", span(item.name));
        for check in item.told().filter(|c| item.is_blocking(c)) {
            let word = if check.status == Status::Unknown { "not judged" } else { "fails" };
            let _ =
                writeln!(out, "- **{}** {word}: {} ({})", check.id, check.rule, expectation(check));
            for finding in check.evidence.iter().take(SHOWN) {
                let _ = writeln!(out, "  - {}", span(finding));
            }
            if check.evidence.len() > SHOWN {
                let _ = writeln!(out, "  - and {} more", check.evidence.len() - SHOWN);
            }
            let mend = explain(&check.id).map(|told| told.remedy(&check.evidence));
            if let Some(mend) = mend.filter(|m| !m.is_empty() && check.status == Status::Fail) {
                let _ = writeln!(out, "  - mend: {mend}");
            }
        }
    }
    out
}

/// A code span whose fence is longer than any run of backticks in it (CommonMark 0.31, 6.1).
fn span(text: &str) -> String {
    let text = guard::text::shown(text).replace(['\n', '\r'], " ");
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(longest + 1);
    let space =
        if text.starts_with('`') || text.ends_with('`') || text.is_empty() { " " } else { "" };
    format!("{fence}{space}{text}{space}{fence}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Check, CheckOptions, Tier, undecided};

    #[test]
    fn what_a_file_says_stands_in_code_spans_and_acts_nowhere() {
        let mut verdict = undecided("not run", &CheckOptions::default());
        let hostile = "`]</details><script>` @everyone ``![x](http://example.com)`` |";
        verdict.checks = vec![Check::fail("C1").evidence(hostile)];
        let name = "a|b`c.urdf";
        let item = Item { name, verdict: &verdict, asked: Tier::Dynamic, source: None };
        let told = report(&[item]);
        assert!(told.contains("| ``a\\|b`c.urdf`` ✗ |"), "{told}");
        assert!(told.contains(&format!("``` {hostile} ```")), "{told}");
        assert!(told.starts_with("**0 of 1 models"), "{told}");
    }
}
