//! What was not accepted, and why: reasons with the items they are of, checks that fail, lines of the
//! manifest that are no items.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use indicatif::HumanCount;
use sim_check::profile::rule;

use super::figures::{Figures, ROWS, Reason};
use super::gallery::Look;
use super::markup::{escaped, linked, more, section};

/// Reasons, commonest first, and some of the items of each by name.
pub(super) fn failures(figures: &Figures, looks: &BTreeMap<String, Look>) -> String {
    if figures.reasons.is_empty() {
        return section(
            "What was not accepted",
            "<p class=dim>Nothing: everything was accepted.</p>",
        );
    }
    let classes: Vec<_> = figures
        .classes
        .iter()
        .map(|(class, n)| {
            format!("<span class=chip>{} <b>{}</b></span>", escaped(class), HumanCount(*n))
        })
        .collect();
    let mut body = format!(
        "<p>{}</p>\n<table>\n<tr><th>class<th>items<th class=half>reason<th>which</tr>\n",
        classes.join(" ")
    );
    for ((class, why), reason) in figures.commonest() {
        let _ = writeln!(
            body,
            "<tr><td>{}<td class=n>{}<td class=why>{}<td class=why>{}</tr>",
            escaped(class),
            HumanCount(reason.items),
            escaped(why),
            which(reason, looks),
        );
    }
    let rest = more(figures.reasons.len(), ROWS, "reasons");
    section("What was not accepted", &(body + "</table>" + &rest))
}

/// The items of a reason by name, as links to their pages where they have one.
fn which(reason: &Reason, looks: &BTreeMap<String, Look>) -> String {
    let page = |id: &str| looks.get(id).and_then(|look| look.page.as_deref());
    let names: Vec<_> = reason.ids.iter().map(|id| linked(&escaped(id), page(id))).collect();
    let left = reason.items.saturating_sub(reason.ids.len() as u64);
    let rest = if left == 0 { String::new() } else { format!(" and {} more", HumanCount(left)) };
    names.join(", ") + &rest
}

/// The checks that assets fail, commonest first.
pub(super) fn checks(figures: &Figures) -> String {
    if figures.checks.is_empty() {
        return String::new();
    }
    let mut sorted: Vec<_> = figures.checks.iter().collect();
    sorted.sort_by_key(|(_, of)| std::cmp::Reverse(of.all()));
    let mut body = String::from(
        "<p class=dim><code>kinfold explain ID</code> says how a check is measured and what mends it.</p>\n\
         <table>\n<tr><th>check<th>assets<th>accepted all the same<th class=half>rule</tr>\n",
    );
    for (id, of) in sorted.iter().take(ROWS) {
        let _ = writeln!(
            body,
            "<tr><td>{}<td class=n>{}<td class=n>{}<td class=why>{}</tr>",
            escaped(id),
            HumanCount(of.all()),
            HumanCount(of.accepted),
            escaped(rule(id).words),
        );
    }
    section("Checks that fail", &(body + "</table>" + &more(sorted.len(), ROWS, "checks")))
}

/// Lines of the manifest that are no items.
pub(super) fn bad_lines(figures: &Figures) -> String {
    let (lines, all) = &figures.bad_lines;
    if lines.is_empty() {
        return String::new();
    }
    let mut body = String::from("<table>\n<tr><th>line<th class=most>why</tr>\n");
    for (line, why) in lines {
        let _ = writeln!(body, "<tr><td class=n>{line}<td class=why>{}</tr>", escaped(why));
    }
    let rest = more(usize::try_from(*all).unwrap_or(usize::MAX), lines.len(), "lines");
    section("Lines of the manifest that are no items", &(body + "</table>" + &rest))
}
