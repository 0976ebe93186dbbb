//! `kinfold explain`: why a rule of the profile matters, how it is measured, how to mend it.

use std::fmt::Write as _;

use serde_json::{Value, json};
use sim_check::Severity;
use sim_check::profile::explain::{Explanation, explain as known};
use sim_check::profile::{RULES, Rule};
use sim_check::verdict::PROFILE;

use crate::cli::args::ExplainArgs;
use crate::cli::speech::{Answer, Complaint};

/// Longest line, characters.
const WIDTH: usize = 96;

/// Explains rules of the profile, or lists them all where none is named.
///
/// # Errors
/// [`Complaint`] where there is no rule of that id.
pub fn explain(args: &ExplainArgs) -> Result<Answer, Complaint> {
    if args.ids.is_empty() {
        return Ok(Answer::done(if args.json { all_in_json() } else { list() }));
    }
    let found: Result<Vec<_>, Complaint> = args.ids.iter().map(|id| one(id)).collect();
    let found = found?;
    let result = if args.json {
        match &found[..] {
            [one] => format!("{:#}\n", value(one)),
            several => format!("{:#}\n", Value::Array(several.iter().map(value).collect())),
        }
    } else {
        found.iter().map(in_words).collect::<Vec<_>>().join("\n")
    };
    Ok(Answer::done(result))
}

fn one(id: &str) -> Result<Explanation, Complaint> {
    known(&id.trim().to_ascii_uppercase()).ok_or_else(|| {
        let ids: Vec<_> = RULES.iter().map(|r| r.id).collect();
        let found = format!("expected the id of a rule of {PROFILE}, found `{id}`");
        let complaint = Complaint::misused(found);
        complaint.hint(format!("there are {}; `kinfold explain` lists them", ids.join(" ")))
    })
}

fn severity(rule: &Rule) -> &'static str {
    match rule.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    }
}

fn list() -> String {
    let mut out =
        format!("The rules of {PROFILE}, each with the lowest tier that asks for it:\n\n");
    for rule in &RULES {
        let flag = if rule.severity == Severity::Warning { " (a warning)" } else { "" };
        let _ = writeln!(out, "{:<3} {:<10} {}{flag}", rule.id, rule.tier.name(), rule.words);
    }
    out.push_str(
        "\n`kinfold explain C1` says why a rule matters, how it is measured and how to mend it\n",
    );
    out
}

fn in_words(told: &Explanation) -> String {
    let rule = told.rule;
    let mut out = format!("{}  {}\n", rule.id, rule.words);
    let effect = match rule.severity {
        Severity::Error => format!("failing it keeps a model below tier {}", rule.tier.name()),
        Severity::Warning => "a warning, which lowers no tier".into(),
    };
    out.push_str(&wrapped(&format!("{effect}; expected {}", rule.threshold())));
    let mut section = |title: &str, texts: &[&str]| {
        let _ = writeln!(out, "\n{title}");
        texts.iter().for_each(|text| out.push_str(&wrapped(text)));
    };
    section("Why it matters", &[told.why]);
    section("How it is measured", &[&told.how]);
    let ways: Vec<String> = told
        .mend
        .iter()
        .map(|(word, way)| match *word {
            "" => format!("- {way}"),
            word => format!("- where it says `{word}`: {way}"),
        })
        .collect();
    let ways: Vec<&str> = ways.iter().map(String::as_str).collect();
    section("How to mend it", &ways);
    out
}

/// A text in lines of at most [`WIDTH`] characters, indented.
fn wrapped(text: &str) -> String {
    let indent = if text.starts_with("- ") { "    " } else { "  " };
    let (mut out, mut line) = (String::new(), String::from("  "));
    for word in text.split_whitespace() {
        let is_first = line.trim().is_empty();
        if !is_first && line.chars().count() + 1 + word.chars().count() > WIDTH {
            let _ = writeln!(out, "{line}");
            line = indent.into();
        } else if !is_first {
            line.push(' ');
        }
        line.push_str(word);
    }
    let _ = writeln!(out, "{line}");
    out
}

fn value(told: &Explanation) -> Value {
    let rule = told.rule;
    let way = |(word, way): &(&str, &str)| match *word {
        "" => json!({ "remedy": way }),
        word => json!({ "where": word, "remedy": way }),
    };
    json!({
        "profile": PROFILE,
        "id": rule.id,
        "rule": rule.words,
        "tier": rule.tier.name(),
        "severity": severity(rule),
        "expected": rule.threshold(),
        "why": told.why,
        "how": told.how,
        "mend": told.mend.iter().map(way).collect::<Vec<_>>(),
    })
}

fn all_in_json() -> String {
    let all: Vec<Value> =
        RULES.iter().filter_map(|r| known(r.id)).map(|told| value(&told)).collect();
    format!("{:#}\n", Value::Array(all))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::When;

    fn asked(ids: &[&str], json: bool) -> Result<Answer, Complaint> {
        let ids = ids.iter().map(|id| (*id).to_owned()).collect();
        explain(&ExplainArgs { ids, color: When::Never, json })
    }

    #[test]
    fn a_rule_is_explained_with_its_bounds_and_an_unknown_one_is_told() {
        let told = asked(&["g2"], false).unwrap().result;
        for words in ["G2  each collision", "Why it matters", "64 vertices", "CoACD", "0.1 %"] {
            assert!(told.contains(words), "{words}: {told}");
        }
        assert!(told.lines().all(|line| line.chars().count() <= WIDTH), "{told}");
        let unknown = asked(&["G9"], false).unwrap_err();
        assert!(unknown.to_string().contains("found `G9`") && unknown.hints[0].contains("F1 F2"));
    }

    #[test]
    fn all_rules_are_listed_and_told_to_machines() {
        let listed = asked(&[], false).unwrap().result;
        assert!(RULES.iter().all(|r| listed.contains(r.words)), "{listed}");
        let all: Value = serde_json::from_str(&asked(&[], true).unwrap().result).unwrap();
        assert_eq!(all.as_array().unwrap().len(), RULES.len());
        let one: Value = serde_json::from_str(&asked(&["C1"], true).unwrap().result).unwrap();
        assert_eq!(one["tier"], "kinematic");
        assert!(asked(&["C1", "C2"], true).unwrap().result.starts_with('['));
    }
}
