//! `kinfold scan`: how far all models of a library get, and what keeps most of them back.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use guard::text::shown;
use serde_json::{Value, json};
use sim_check::profile::{RULES, rule};
use sim_check::{Status, Tier};

use super::checked::Checked;
use super::gathered;
use crate::cli::args::ScanArgs;
use crate::cli::speech::{Answer, Complaint, Exit};

/// Checks all models and sums up what was found; a survey is done with losses where one of them does not
/// reach the tier that is asked of it.
///
/// # Errors
/// As [`super::check()`].
pub fn scan(args: &ScanArgs) -> Result<Answer, Complaint> {
    if args.check.here {
        return Err(Complaint::misused("--here is for `kinfold check`"));
    }
    let (checked, remarks) = gathered(&args.check)?;
    let result = if args.check.json { summed_json(&checked) } else { summed(&checked, args.top) };
    let is_all = checked.iter().all(|c| c.item().is_enough());
    Ok(Answer { result, remarks, exit: if is_all { Exit::Done } else { Exit::Losses } })
}

/// Models by the tier they reach, the highest first.
fn tiers(checked: &[Checked]) -> Vec<(Tier, usize)> {
    let count = |tier: Tier| checked.iter().filter(|c| c.verdict.tier == tier).count();
    Tier::ALL.into_iter().rev().map(|tier| (tier, count(tier))).filter(|(_, n)| *n > 0).collect()
}

/// For each check that keeps models back: how many fail it, and of how many it could not be judged.
fn broken(checked: &[Checked]) -> Vec<(&'static str, [usize; 2])> {
    let mut all: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for check in checked.iter().flat_map(|c| c.verdict.failures()) {
        all.entry(rule(&check.id).id).or_default()[usize::from(check.status == Status::Unknown)] +=
            1;
    }
    let mut all: Vec<_> = all.into_iter().collect();
    all.sort_by_key(|(id, counts)| (std::cmp::Reverse(*counts), *id));
    all
}

fn summed(checked: &[Checked], top: usize) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    for (tier, count) in tiers(checked) {
        let share = 100.0 * count as f64 / checked.len().max(1) as f64;
        let _ = writeln!(out, "{:<9}  {count:>6} models  {share:>5.1} %", tier.name());
    }
    let enough = checked.iter().filter(|c| c.item().is_enough()).count();
    let _ = writeln!(out, "{enough} of {} reach the tier that is asked of them", checked.len());
    let broken = broken(checked);
    if !broken.is_empty() {
        let _ = writeln!(out, "\nmodels that fail a check, and of which it could not be judged:");
    }
    for (id, [fail, open]) in &broken {
        let words = RULES.iter().find(|r| r.id == *id).map_or("", |r| r.words);
        let _ = writeln!(out, "{id:<3}  {fail:>6}  {open:>6}  {words}");
    }
    let mut worst: Vec<&Checked> = checked.iter().filter(|c| !c.item().is_enough()).collect();
    worst.sort_by_key(|c| {
        let counts = c.verdict.counts;
        (c.verdict.tier, std::cmp::Reverse(counts.fail + counts.unknown), c.name.clone())
    });
    if !worst.is_empty() && top > 0 {
        let _ = writeln!(out, "\nfarthest from it:");
    }
    for of in worst.iter().take(top) {
        let ids: Vec<&str> = of.verdict.failures().map(|c| c.id.as_str()).take(8).collect();
        let _ =
            writeln!(out, "{:<9}  {}  {}", of.verdict.tier.name(), shown(&of.name), ids.join(" "));
    }
    if worst.len() > top && top > 0 {
        let _ = writeln!(out, "and {} more: --html FILE shows them all", worst.len() - top);
    }
    out
}

fn summed_json(checked: &[Checked]) -> String {
    let tiers: BTreeMap<&str, usize> =
        tiers(checked).into_iter().map(|(t, n)| (t.name(), n)).collect();
    let checks: Vec<Value> = broken(checked)
        .into_iter()
        .map(|(id, [fail, open])| json!({"id": id, "fail": fail, "unknown": open}))
        .collect();
    let of = |c: &Checked| {
        let ids = |status| -> Vec<&str> {
            let of = c.verdict.failures().filter(|c| c.status == status);
            of.map(|c| c.id.as_str()).collect()
        };
        json!({
            "file": c.name,
            "tier": c.verdict.tier.name(),
            "asked": c.asked.name(),
            "fail": ids(Status::Fail),
            "unknown": ids(Status::Unknown),
            "waived": c.verdict.counts.waived,
        })
    };
    let files: Vec<Value> = checked.iter().map(of).collect();
    let all = json!({"models": checked.len(), "tiers": tiers, "checks": checks, "files": files});
    let text = serde_json::to_string_pretty(&all).unwrap_or_default();
    guard::text::json(&text).into_owned() + "\n"
}
