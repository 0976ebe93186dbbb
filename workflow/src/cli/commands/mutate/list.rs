//! The kinds of planted defects, for people and for programs.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::mutate::kinds::{KINDS, Kind};

/// Every kind, in the order of the table.
pub(super) fn list(is_json: bool) -> String {
    if is_json {
        let one = |k: &Kind| {
            let formats: Vec<&str> = k.formats.iter().map(|f| f.name()).collect();
            json!({
                "kind": k.id, "change": k.change, "wrong": k.wrong, "formats": formats,
                "rules": k.rules,
            })
        };
        return format!("{:#}\n", Value::Array(KINDS.iter().map(one).collect()));
    }
    let mut out = format!("{} kinds of planted defects:\n", KINDS.len());
    for kind in &KINDS {
        let formats: Vec<&str> = kind.formats.iter().map(|f| f.name()).collect();
        let _ = writeln!(out, "\n{}  ({})", kind.id, formats.join(", "));
        let _ = writeln!(out, "  change: {}\n  wrong:  {}", kind.change, kind.wrong);
        let _ = writeln!(out, "  found:  {}", found(kind));
    }
    out
}

/// What of kinfold's rules should find it, in words.
fn found(kind: &Kind) -> String {
    match kind.rules {
        [] => "by any finding that was not there before".to_owned(),
        rules => format!("by {}", rules.join(" or ")),
    }
}
