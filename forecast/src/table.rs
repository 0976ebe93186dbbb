//! The table of all rules as the documentation shows it.

use std::fmt::Write as _;

use crate::client::Client;
use crate::rule::Source;
use crate::rules::RULES;

/// The rules as tables in Markdown, one for each client.
///
/// ```
/// assert!(forecast::table::markdown().contains("| `mujoco.range-zero` |"));
/// ```
pub fn markdown() -> String {
    let mut out = String::new();
    for client in Client::ALL {
        let rules: Vec<_> =
            RULES.iter().copied().flatten().filter(|r| r.client == client).collect();
        let read = rules.iter().filter(|r| matches!(r.source, Source::Read(_))).count();
        let _ = writeln!(
            out,
            "## {}\n\n{} rules: {} measured, {read} read.\n\n\
             | Rule | Of | Severity | What will happen | Remedy | Known from |\n|---|---|---|---|---|---|",
            client.label(),
            rules.len(),
            rules.len() - read
        );
        for rule in rules {
            let from = match rule.source {
                Source::Measured(test) => format!("{}: measured by `{}`", rule.version, name(test)),
                Source::Read(place) => format!("{}: read, {place}", rule.version),
            };
            let (format, severity) = (rule.find.format(), rule.severity.name());
            let cells = [format, severity, &escaped(rule.sentence), &escaped(rule.remedy), &from];
            let _ = writeln!(out, "| `{}` | {} |", rule.id, cells.join(" | "));
        }
        out.push('\n');
    }
    out
}

/// A script by its name in the repository.
fn name(test: &str) -> &str {
    test.trim_start_matches("../")
}

/// Angle brackets and bars as Markdown shows them.
fn escaped(text: &str) -> String {
    text.replace('<', "\\<").replace('|', "\\|")
}
