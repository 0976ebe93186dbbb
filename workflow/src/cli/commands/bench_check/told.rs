//! The answers of a checker as tables.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::answers::{Bench, One};
use crate::mutate::kinds::KINDS;

/// What became of one kind over all models.
#[derive(Default)]
struct Row {
    found: usize,
    missed: Vec<String>,
    none: usize,
}

/// Rows in the order of the kinds, those with a mutant or without a place for one.
fn rows(bench: &Bench) -> Vec<(&str, Row)> {
    let mut all: BTreeMap<&str, Row> = BTreeMap::new();
    for One { kind, found, model, by, .. } in &bench.mutants {
        let row = all.entry(kind).or_default();
        match found {
            true => row.found += 1,
            false => row.missed.push(format!("{model}: {by}")),
        }
    }
    for (kind, count) in &bench.not_applicable {
        all.entry(kind).or_default().none = *count;
    }
    let place = |id: &str| KINDS.iter().position(|k| k.id == id).unwrap_or(KINDS.len());
    let mut rows: Vec<_> = all.into_iter().collect();
    rows.sort_by_key(|(id, _)| place(id));
    rows
}

pub(super) fn table(bench: &Bench) -> String {
    let rows = rows(bench);
    let wide = rows.iter().map(|(kind, _)| kind.len()).max().unwrap_or(0).max(4);
    let mut out = format!("{:wide$}  found  missed  does not apply\n", "kind");
    for (kind, row) in &rows {
        let _ =
            writeln!(out, "{kind:wide$}  {:5}  {:6}  {:14}", row.found, row.missed.len(), row.none);
        for missed in &row.missed {
            let _ = writeln!(out, "{:wide$}  missed {missed}", "");
        }
    }
    for original in &bench.originals {
        if let Some(alarm) = &original.alarm {
            let _ = writeln!(out, "false alarm on {}: {alarm}", original.model);
        }
    }
    out
}

pub(super) fn markdown(bench: &Bench) -> String {
    let mut out = format!("{}\n\n", guard::text::markup(&summary(bench)));
    out.push_str("| Kind | Found | Missed | Does not apply |\n|---|---|---|---|\n");
    for (kind, row) in rows(bench) {
        let _ = writeln!(out, "| `{kind}` | {} | {} | {} |", row.found, row.missed.len(), row.none);
    }
    out
}

pub(super) fn json(bench: &Bench) -> String {
    let text = serde_json::to_string_pretty(bench).unwrap_or_default();
    guard::text::json(&text).into_owned() + "\n"
}

pub(super) fn summary(bench: &Bench) -> String {
    let found = bench.mutants.iter().filter(|m| m.found).count();
    let all = bench.mutants.len();
    let alarms = bench.originals.iter().filter(|o| o.alarm.is_some()).count();
    let mut times: Vec<f64> = bench.mutants.iter().map(|m| m.seconds).collect();
    times.sort_by(f64::total_cmp);
    let middle = times.get(times.len() / 2).copied().unwrap_or(0.0);
    let share = if all == 0 { 0.0 } else { 100.0 * found as f64 / all as f64 };
    format!(
        "{}: {found} of {all} planted defects found ({share:.1} %), {alarms} of {} models without one \
         have findings, {middle:.2} s a file at the median",
        bench.program,
        bench.originals.len()
    )
}
