//! The table of rules keeps its own rules.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use forecast::{Client, RULES, Rule, Source, table};

fn rules() -> impl Iterator<Item = &'static Rule> {
    RULES.iter().copied().flatten()
}

fn here(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

#[test]
fn there_are_sixty_rules_over_eight_clients_and_each_has_its_own_id() {
    let ids: BTreeSet<_> = rules().map(|r| r.id).collect();
    assert_eq!(ids.len(), rules().count());
    assert!(ids.len() >= 60, "{}", ids.len());
    for rule in rules() {
        let client = rule.id.split_once('.').unwrap().0;
        assert_eq!(client, rule.client.name(), "{}", rule.id);
    }
    for client in Client::ALL {
        assert!(rules().any(|r| r.client == client), "{client:?}");
    }
}

#[test]
fn sentences_are_short_and_end() {
    for rule in rules() {
        for text in [rule.sentence, rule.remedy] {
            let words = text.split_whitespace().count();
            assert!(words <= 25, "{}: {words} words: {text}", rule.id);
            assert!(text.ends_with('.') && !text.contains("  "), "{}: {text}", rule.id);
        }
        let named = rule.sentence.starts_with(rule.client.label().split(' ').next().unwrap());
        assert!(named, "{}: {}", rule.id, rule.sentence);
    }
}

/// The rules that a script tests: each stands in quotes behind `@rule(`.
fn tested(script: &str) -> BTreeSet<String> {
    let lines = script.lines().filter_map(|l| l.strip_prefix("@rule("));
    lines.flat_map(|l| l.split('"').skip(1).step_by(2)).map(str::to_string).collect()
}

#[test]
fn every_measured_rule_has_a_test_of_its_name_and_every_test_a_rule() {
    let mut scripts: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for rule in rules() {
        let Source::Measured(script) = rule.source else { continue };
        let text = std::fs::read_to_string(here(script)).unwrap();
        if script.ends_with(".sh") {
            let package = rule.version.replace(' ', "==");
            assert!(text.contains(&package), "{}: {script} asks another version", rule.id);
            continue;
        }
        let tests = scripts.entry(script).or_insert_with(|| tested(&text));
        assert!(tests.remove(rule.id), "{} has no test in {script}", rule.id);
    }
    let idle: Vec<_> = scripts.into_values().flatten().collect();
    assert!(idle.is_empty(), "tests of no rule: {idle:?}");
}

#[test]
fn versions_are_those_that_are_installed_for_the_tests() {
    let listed = ["engines/requirements.txt", "../tests/requirements-usd.txt"]
        .map(|file| std::fs::read_to_string(here(file)).unwrap())
        .concat();
    for rule in rules() {
        let Source::Measured(script) = rule.source else { continue };
        let version = rule.version.split(',').next().unwrap().replace(' ', "==");
        assert!(script.ends_with(".sh") || listed.lines().any(|l| l == version), "{version}");
    }
}

#[test]
fn the_documentation_shows_the_table() {
    let path = here("../docs/forecast.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let (head, _) = text.split_once("<!-- rules -->\n").expect("a mark before the rules");
    let wanted = format!("{head}<!-- rules -->\n\n{}", table::markdown());
    if std::env::var_os("KINFOLD_BLESS").is_some() {
        std::fs::write(&path, wanted).unwrap();
    } else {
        let hint = "KINFOLD_BLESS=1 cargo test -p kinfold-forecast --test table";
        assert!(text == wanted, "docs/forecast.md is not of these rules: {hint}");
    }
}
