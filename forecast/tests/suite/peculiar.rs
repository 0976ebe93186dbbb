//! More than forty files, each with one peculiarity: no rule is silent about it, and none speaks that
//! should not.

use std::collections::BTreeSet;

use forecast::{Client, Outside, RULES, Severity, forecast};

use crate::peculiarities;

#[test]
fn each_peculiarity_wakes_its_rules_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let files = peculiarities::all();
    assert!(files.len() >= 40, "{}", files.len());
    let mut wrong = String::new();
    for file in &files {
        let said = forecast(&file.write(folder.path()), &Client::ALL, Outside::Refused).unwrap();
        let findings = said.iter().flat_map(|f| &f.findings);
        let found: BTreeSet<_> =
            findings.filter(|f| f.severity != Severity::Note).map(|f| f.rule).collect();
        let expected: BTreeSet<_> = file.rules.split_whitespace().collect();
        for rule in expected.difference(&found) {
            wrong += &format!("\n{}: {rule} is silent", file.name);
        }
        for rule in found.difference(&expected) {
            wrong += &format!("\n{}: {rule} is false", file.name);
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Rules that a file of half a megabyte would wake: `mujoco.stl-faces` has its own test.
const BY_THEMSELVES: [&str; 1] = ["mujoco.stl-faces"];

#[test]
fn every_rule_but_notes_has_a_file_that_wakes_it() {
    let woken: BTreeSet<_> =
        peculiarities::all().iter().flat_map(|f| f.rules.split_whitespace()).collect();
    let rules = RULES.iter().copied().flatten().filter(|r| r.severity != Severity::Note);
    let asleep: Vec<_> = rules
        .map(|r| r.id)
        .filter(|id| !woken.contains(id) && !BY_THEMSELVES.contains(id))
        .collect();
    assert!(asleep.is_empty(), "{asleep:?}");
}

#[test]
fn an_stl_of_too_many_faces_is_refused_by_mujoco() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = peculiarities::all();
    let mut file = files.swap_remove(files.iter().position(|f| f.name == "felt_stl").unwrap());
    let count = 200_001_u32;
    let mut bytes = vec![b' '; 80];
    bytes.extend(count.to_le_bytes());
    bytes.resize(84 + 50 * 200_001, 0);
    file.beside = vec![("t.stl", bytes)];
    let said = forecast(&file.write(folder.path()), &[Client::Mujoco], Outside::Refused).unwrap();
    assert!(said[0].findings.iter().any(|f| f.rule == "mujoco.stl-faces"));
}

#[test]
fn notes_are_told_of_the_plain_file_and_name_their_places() {
    let folder = tempfile::tempdir().unwrap();
    let plain = peculiarities::all().swap_remove(0).write(folder.path());
    let said = forecast(&plain, &Client::ALL, Outside::Refused).unwrap();
    assert_eq!(said.len(), 8);
    for of_client in &said {
        assert!(of_client.rules > 5, "{of_client:?}");
        assert!(of_client.findings.iter().all(|f| f.severity == Severity::Note));
        assert!(of_client.findings.iter().flat_map(|f| &f.places).all(|p| p.line > 0));
    }
    let motors = said[1].findings.iter().find(|f| f.rule == "pybullet.motors-hold").unwrap();
    assert_eq!((motors.count, motors.places[0].name.as_str(), motors.places[0].line), (1, "j", 4));
}

#[test]
fn a_client_without_rules_for_a_format_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let files = peculiarities::all();
    let mjcf = files.iter().find(|f| f.extension == "xml").unwrap().write(folder.path());
    let said = forecast(&mjcf, &[Client::Rerun], Outside::Refused).unwrap();
    assert_eq!((said[0].rules, said[0].findings.len()), (0, 0));
}
