//! Verdicts as one page for a browser: who gets how far, what fails most, and why.
//!
//! The page has no script and loads nothing; what files say stands in it as text.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::{Item, expectation};
use crate::profile::explain::explain;
use crate::profile::{RULES, Tier};
use crate::verdict::{Check, Status};

/// Findings of a check that are told.
const SHOWN: usize = 5;

const HEAD: &str = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n\
<meta name=\"viewport\" content=\"width=device-width\"><title>kinfold check</title>\n<style>\n\
:root{color-scheme:light dark}\n\
body{font:15px/1.5 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem}\n\
table{border-collapse:collapse;width:100%;margin:1rem 0}\n\
th,td{text-align:left;padding:.3rem .6rem;border-bottom:1px solid #8884;vertical-align:top}\n\
td.n,th.n{text-align:right}\n\
summary{cursor:pointer;overflow-wrap:anywhere}\n\
.bar{display:flex;height:1.6rem;border-radius:.3rem;overflow:hidden;margin:1rem 0}\n\
.bar span{padding:0 .5rem;min-width:max-content;color:#fff;white-space:nowrap;overflow:hidden}\n\
.none{background:#9b2c2c}.parse{background:#b7791f}.static{background:#2b6cb0}\n\
.kinematic{background:#2c7a7b}.dynamic{background:#2f855a}.audited{background:#22543d}\n\
b.tier{padding:.05rem .45rem;border-radius:.3rem;color:#fff;font-weight:600}\n\
li{overflow-wrap:anywhere}\n\
</style></head><body>\n";

/// The page; the same verdicts give the same bytes. Models stand best first, then by name.
pub fn report(items: &[Item<'_>]) -> String {
    let mut out = HEAD.to_owned();
    let enough = items.iter().filter(|i| i.is_enough()).count();
    // Writing to a string cannot fail.
    let _ = write!(
        out,
        "<h1>{enough} of {} models reach the tier that is asked of them</h1>\n<div class=\"bar\">",
        items.len()
    );
    for tier in Tier::ALL.iter().rev() {
        let count = items.iter().filter(|i| i.verdict.tier == *tier).count();
        if count > 0 {
            let name = tier.name();
            let _ =
                write!(out, "<span class=\"{name}\" style=\"flex:{count}\">{name} {count}</span>");
        }
    }
    out.push_str("</div>\n");
    most_often(&mut out, items);
    out.push_str(
        "<h2>Models</h2>\n<table><thead><tr><th class=\"n\">#</th><th>Model and what keeps it back</th>\
         <th>Tier</th><th>Asked for</th><th class=\"n\">Pass</th><th class=\"n\">Fail</th>\
         <th class=\"n\">Not judged</th><th class=\"n\">Waived</th></tr></thead><tbody>\n",
    );
    let mut ranked: Vec<&Item<'_>> = items.iter().collect();
    ranked.sort_by_key(|i| {
        let counts = i.verdict.counts;
        (std::cmp::Reverse(i.verdict.tier), counts.fail + counts.unknown, i.name)
    });
    for (rank, item) in ranked.iter().enumerate() {
        row(&mut out, rank + 1, item);
    }
    out.push_str("</tbody></table>\n</body></html>\n");
    out
}

fn row(out: &mut String, rank: usize, item: &Item<'_>) {
    let blocking: Vec<&Check> = item.told().filter(|c| c.counts_against()).collect();
    let name = text(item.name);
    let _ = write!(out, "<tr><td class=\"n\">{rank}</td><td>");
    if blocking.is_empty() {
        out.push_str(&name);
    } else {
        let _ = write!(out, "<details><summary>{name}</summary><ul>");
        for check in blocking {
            let word = if check.status == Status::Unknown { "not judged" } else { "fails" };
            let _ = write!(
                out,
                "<li><b>{}</b> {word}: {} ({})<ul>",
                check.id,
                text(&check.rule),
                text(&expectation(check))
            );
            for finding in check.evidence.iter().take(SHOWN) {
                let _ = write!(out, "<li>{}</li>", text(finding));
            }
            if check.evidence.len() > SHOWN {
                let _ = write!(out, "<li>and {} more</li>", check.evidence.len() - SHOWN);
            }
            let mend = explain(&check.id).map(|told| told.remedy(&check.evidence));
            if let Some(mend) = mend.filter(|m| !m.is_empty() && check.status == Status::Fail) {
                let _ = write!(out, "<li><i>mend: {}</i></li>", text(mend));
            }
            out.push_str("</ul></li>");
        }
        out.push_str("</ul></details>");
    }
    let (tier, counts) = (item.verdict.tier.name(), item.verdict.counts);
    let _ = writeln!(
        out,
        "</td><td><b class=\"tier {tier}\">{tier}</b></td><td>{}</td><td class=\"n\">{}</td>\
         <td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
        item.asked.name(),
        counts.pass,
        counts.fail,
        counts.unknown,
        counts.waived
    );
}

/// Which rules the most models break.
fn most_often(out: &mut String, items: &[Item<'_>]) {
    let mut broken: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for check in items.iter().flat_map(Item::told).filter(|c| c.counts_against()) {
        let id = RULES.iter().find(|r| r.id == check.id).map_or("", |r| r.id);
        broken.entry(id).or_default()[usize::from(check.status == Status::Unknown)] += 1;
    }
    if broken.is_empty() {
        return;
    }
    let mut broken: Vec<_> = broken.into_iter().collect();
    broken.sort_by_key(|(id, [fail, open])| (std::cmp::Reverse((*fail, *open)), *id));
    out.push_str(
        "<h2>What fails most</h2>\n<table><thead><tr><th>Check</th><th>Rule</th>\
         <th class=\"n\">Models that fail it</th><th class=\"n\">Models it cannot judge</th></tr></thead><tbody>\n",
    );
    for (id, [fail, open]) in broken {
        let words = RULES.iter().find(|r| r.id == id).map_or("", |r| r.words);
        let _ = writeln!(
            out,
            "<tr><td>{id}</td><td>{}</td><td class=\"n\">{fail}</td><td class=\"n\">{open}</td></tr>",
            text(words)
        );
    }
    out.push_str("</tbody></table>\n");
}

fn text(text: &str) -> String {
    guard::text::markup(&guard::text::shown(text)).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CheckOptions, undecided};

    #[test]
    fn what_a_file_says_is_text_and_the_best_stands_first() {
        let mut good = undecided("not run", &CheckOptions::default());
        good.checks = vec![Check::pass("F1")];
        good.tier = Tier::Dynamic;
        let mut bad = good.clone();
        bad.checks = vec![Check::fail("C1").evidence("`<script>alert(1)</script>` overlaps")];
        bad.tier = Tier::Static;
        let of = |name, verdict| Item { name, verdict, asked: Tier::Kinematic, source: None };
        let page = report(&[of("a<b>.urdf", &bad), of("z.urdf", &good)]);
        assert!(page.contains("<h1>1 of 2 models") && !page.contains("<script>"), "{page}");
        assert!(page.find("z.urdf").unwrap() < page.find("a&lt;b&gt;.urdf").unwrap());
    }
}
