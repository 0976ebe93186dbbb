//! What the ledger promises.

use std::path::{Path, PathBuf};

use adapters::budget::{Entry, Fate};
use adapters::usage::Usage;
use rusqlite::Connection;
use rusqlite::types::Value;
use trace::Digest;

use super::super::manifest::Item;
use super::super::record::{Ended, Record};
use super::*;

fn item(id: &str, seed: u64) -> Item {
    Item { id: id.into(), photo: "p.png".into(), seed: Some(seed), ..Item::default() }
}

fn lines(ids: &[&str]) -> Vec<(u64, Result<Item, String>)> {
    ids.iter().zip(1..).map(|(id, line)| (line, Ok(item(id, 0)))).collect()
}

fn open(folder: &Path) -> Ledger {
    Ledger::open(&folder.join(FILE)).unwrap()
}

fn settings() -> Digest {
    Digest::of(b"settings")
}

fn note(ledger: &Ledger, run: i64, id: &str, class: Option<&str>) {
    let spec = serde_json::to_string(&item(id, 0)).unwrap();
    let mut record = Record::new(id, Ended::Accepted);
    if class.is_some() {
        (record.outcome, record.class) = (Ended::Failed, class.map(String::from));
    }
    ledger.add(run, &settings(), &[(Digest::of(spec.as_bytes()), record)]).unwrap();
}

fn pending(ledger: &Ledger, plan: i64, run: i64, again: &[&str]) -> Vec<String> {
    let settled = Settled { plan, settings: Some(&settings()), again, run };
    let found = ledger.pending(&settled, 0, 100).unwrap();
    found.into_iter().map(|p| p.item.id).collect()
}

fn planned(ledger: &Ledger, ids: &[&str]) -> i64 {
    let plan = ledger.begin_plan(&Digest::of(ids.join(" ").as_bytes())).unwrap();
    ledger.take(plan, &lines(ids)).unwrap();
    ledger.end_plan(plan).unwrap();
    plan
}

#[test]
fn what_has_an_outcome_that_stands_is_not_handed_out_again() {
    let dir = tempfile::tempdir().unwrap();
    let ledger = open(dir.path());
    let plan = planned(&ledger, &["a", "b", "c", "d"]);
    note(&ledger, 1, "a", None);
    note(&ledger, 1, "b", Some("transient"));
    note(&ledger, 1, "c", Some("geometry"));
    assert_eq!(pending(&ledger, plan, 2, &[]), ["b", "d"]);
    assert_eq!(pending(&ledger, plan, 2, &["geometry"]), ["b", "c", "d"]);
    note(&ledger, 2, "c", Some("geometry"));
    assert_eq!(pending(&ledger, plan, 2, &["geometry"]), ["b", "d"], "once in a run is enough");
    let standing = ledger.standing(plan, &settings()).unwrap();
    assert_eq!((standing.planned, standing.accepted, standing.failed), (4, 1, 1));
}

#[test]
fn a_changed_line_is_another_question_and_a_dropped_one_is_none() {
    let dir = tempfile::tempdir().unwrap();
    let ledger = open(dir.path());
    let plan = planned(&ledger, &["a", "b"]);
    ["a", "b"].into_iter().for_each(|id| note(&ledger, 1, id, None));
    assert!(pending(&ledger, plan, 2, &[]).is_empty());
    let newer = ledger.begin_plan(&Digest::of(b"newer")).unwrap();
    ledger.take(newer, &[(1, Ok(item("b", 7)))]).unwrap();
    ledger.end_plan(newer).unwrap();
    assert_eq!(pending(&ledger, newer, 2, &[]), ["b"]);
    assert_eq!(ledger.standing(newer, &settings()).unwrap().planned, 1);
    let other = Settled { plan, settings: Some(&Digest::of(b"other")), again: &[], run: 2 };
    assert_eq!(ledger.pending(&other, 0, 9).unwrap().len(), 2, "other settings, other assets");
}

#[test]
fn an_id_that_stands_twice_is_a_bad_line_with_the_first_ones_number() {
    let dir = tempfile::tempdir().unwrap();
    let ledger = open(dir.path());
    let plan = ledger.begin_plan(&Digest::of(b"m")).unwrap();
    ledger.take(plan, &lines(&["a", "b", "a"])).unwrap();
    let bad = ledger.bad_lines(plan, 9).unwrap();
    assert_eq!(bad, [(3, "the id `a` stands in line 1 already".to_string())]);
}

#[test]
fn a_plan_that_was_broken_off_is_taken_in_again() {
    let dir = tempfile::tempdir().unwrap();
    let ledger = open(dir.path());
    let manifest = Digest::of(b"m");
    let plan = ledger.begin_plan(&manifest).unwrap();
    ledger.take(plan, &lines(&["a"])).unwrap();
    assert_eq!(ledger.plan_of(&manifest).unwrap(), None);
    let plan = ledger.begin_plan(&manifest).unwrap();
    ledger.take(plan, &lines(&["a", "b"])).unwrap();
    assert!(ledger.bad_lines(plan, 9).unwrap().is_empty());
    ledger.end_plan(plan).unwrap();
    assert_eq!(ledger.plan_of(&manifest).unwrap(), Some(plan));
}

#[test]
fn outcomes_cannot_be_changed_or_taken_away_unnoticed() {
    let dir = tempfile::tempdir().unwrap();
    let ledger = open(dir.path());
    for id in ["a", "b", "c"] {
        note(&ledger, 1, id, None);
    }
    assert!(ledger.broken_links().unwrap().is_empty());
    drop(ledger);
    let db = Connection::open(dir.path().join(FILE)).unwrap();
    for sql in ["UPDATE outcomes SET verdict = 'dynamic'", "DELETE FROM outcomes"] {
        let refused = db.execute(sql, []).unwrap_err().to_string();
        assert!(refused.contains("the ledger is only added to"), "{refused}");
    }
    let broken = || {
        let ledger = Ledger::open_to_read(&dir.path().join(FILE)).unwrap().unwrap();
        ledger.broken_links().unwrap().remove(0)
    };
    let force = "DROP TRIGGER outcomes_keep_UPDATE; DROP TRIGGER outcomes_keep_DELETE;";
    db.execute_batch(force).unwrap();
    db.execute("UPDATE outcomes SET verdict = 'dynamic' WHERE id = 'b'", []).unwrap();
    assert_eq!(broken(), "row 2 (`b`) was edited");
    db.execute("DELETE FROM outcomes WHERE id = 'b'", []).unwrap();
    assert_eq!(broken(), "row 2 (`c`) does not follow the row before it");
}

#[test]
fn a_reopened_item_is_pending_again_and_no_item_meanwhile() {
    let dir = tempfile::tempdir().unwrap();
    let ledger = open(dir.path());
    let plan = planned(&ledger, &["a"]);
    note(&ledger, 1, "a", None);
    let question = Digest::of(b"q");
    ledger.add(1, &settings(), &[(question, Record::new("a", Ended::Reopened))]).unwrap();
    assert_eq!(pending(&ledger, plan, 2, &[]), ["a"]);
    assert_eq!(ledger.standing(plan, &settings()).unwrap().accepted, 0);
    let mut seen = 0;
    ledger
        .each_item(|_| {
            seen += 1;
            Ok::<(), LedgerError>(())
        })
        .unwrap();
    assert_eq!(seen, 0);
}

fn asked(step: &str, fate: Fate) -> Entry {
    let (question, usage) = (Digest::of(b"q"), Usage::default());
    Entry { question, step: step.into(), work: true, fate, usage, money: None }
}

fn call(id: &'static str, cost: f64) -> Call<'static> {
    Call { run: 1, id, stage: "propose-condition", cost, at: 5 }
}

#[test]
fn requests_are_counted_by_item_and_over_all() {
    let ledger = Ledger::passing().unwrap();
    for id in ["a", "b", "a"] {
        ledger.call(&call(id, 0.5), &asked("vlm.points/0", Fate::Asked)).unwrap();
    }
    let unsent = ledger.call(&call("b", 0.5), &asked("vlm.points/0", Fate::Asked)).unwrap();
    ledger.settle(unsent, &call("b", 0.0), &asked("vlm.points/0", Fate::Unsent)).unwrap();
    ledger.settle(1, &call("a", 0.0), &asked("vlm.points/0", Fate::Refused)).unwrap();
    let all = ledger.calls(None).unwrap();
    assert_eq!((all[0].requests, all[0].cost, all[0].old), (3, 1.0, 0));
    assert_eq!(ledger.calls(Some("b")).unwrap()[0].requests, 1);
    assert!(ledger.calls(Some("c")).unwrap().is_empty());
    assert!(ledger.broken_links().unwrap().is_empty());
}

/// The tables of kinfold 0.1.0 with some rows.
fn old_ledger(folder: &Path) -> PathBuf {
    let path = folder.join(FILE);
    let fresh = Ledger::open(&path).unwrap();
    note(&fresh, 1, "a", None);
    drop(fresh);
    let db = Connection::open(&path).unwrap();
    let spec = serde_json::to_string(&item("a", 0)).unwrap();
    let question = Digest::of(spec.as_bytes());
    let drop_all: String = ["heads", "runs", "plans", "planned", "bad_lines", "calls"]
        .map(|t| format!("DROP TABLE {t};"))
        .concat();
    db.execute_batch(&drop_all).unwrap();
    db.execute_batch(&format!(
        "CREATE TABLE runs (run INTEGER PRIMARY KEY, version TEXT NOT NULL, settings TEXT NOT NULL,
            words TEXT NOT NULL, at_ns INTEGER NOT NULL);
         CREATE TABLE plans (plan INTEGER PRIMARY KEY, manifest TEXT NOT NULL, whole INTEGER NOT NULL DEFAULT 0);
         CREATE TABLE planned (n INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE, line INTEGER NOT NULL,
            spec TEXT NOT NULL, question TEXT NOT NULL, plan INTEGER NOT NULL);
         CREATE TABLE bad_lines (plan INTEGER NOT NULL, line INTEGER NOT NULL, why TEXT NOT NULL);
         CREATE TABLE calls (n INTEGER PRIMARY KEY, run INTEGER NOT NULL, id TEXT NOT NULL,
            stage TEXT NOT NULL, at_ns INTEGER NOT NULL);
         CREATE INDEX calls_by_id ON calls (id, stage);
         CREATE TRIGGER calls_keep_UPDATE BEFORE UPDATE ON calls
            BEGIN SELECT RAISE(ABORT, 'the ledger is only added to'); END;
         INSERT INTO runs VALUES (1, '0.1.0', 's', 'w', 3);
         INSERT INTO plans VALUES (1, 'm', 1);
         INSERT INTO planned VALUES (4, 'a', 1, '{spec}', '{question}', 1);
         INSERT INTO bad_lines VALUES (1, 2, 'no item');
         INSERT INTO calls VALUES (1, 1, 'a', 'generate-mesh', 4);
         INSERT INTO calls VALUES (2, 1, 'a', 'propose-condition', 5);
         PRAGMA user_version = 1;"
    ))
    .unwrap();
    path
}

#[test]
fn a_ledger_of_the_first_release_is_read_as_such_and_says_what_is_not_chained() {
    let dir = tempfile::tempdir().unwrap();
    let ledger = Ledger::open_to_read(&old_ledger(dir.path())).unwrap().unwrap();
    assert!(ledger.broken_links().unwrap().is_empty(), "its outcomes hold");
    let unchained = ledger.unchained().unwrap();
    let expected = [("runs", 1), ("plans", 1), ("planned", 1), ("bad_lines", 1), ("calls", 2)];
    assert_eq!(unchained, expected.map(|(t, n)| (t.to_string(), n)));
}

#[test]
fn a_ledger_of_the_first_release_is_taken_into_the_chain_and_stays_told() {
    let dir = tempfile::tempdir().unwrap();
    let path = old_ledger(dir.path());
    let ledger = Ledger::open(&path).unwrap();
    assert!(ledger.broken_links().unwrap().is_empty());
    assert_eq!(ledger.unchained().unwrap().len(), 5);
    let sent = ledger.calls(None).unwrap();
    assert_eq!(sent.iter().map(|s| (s.requests, s.old)).collect::<Vec<_>>(), [(1, 1), (1, 1)]);
    assert_eq!(ledger.plan_of(&Digest::of(b"m")).unwrap(), None, "another manifest");
    assert_eq!(pending(&ledger, 1, 2, &[]).len(), 0, "what has an outcome keeps it");
    ledger.call(&call("a", 0.1), &asked("vlm.points/0", Fate::Asked)).unwrap();
    drop(ledger);
    let ledger = Ledger::open(&path).unwrap();
    assert!(ledger.broken_links().unwrap().is_empty());
    assert_eq!(ledger.unchained().unwrap().len(), 5, "nothing vouches for what was before");
    drop(ledger);
    let db = Connection::open(&path).unwrap();
    db.execute_batch("DROP TRIGGER runs_keep_UPDATE; UPDATE runs SET words = 'x'").unwrap();
    drop(db);
    let ledger = Ledger::open_to_read(&path).unwrap().unwrap();
    assert_eq!(ledger.broken_links().unwrap(), ["runs: row 1 was edited"]);
}

#[test]
fn questions_in_sql_are_answered_and_changes_refused() {
    let dir = tempfile::tempdir().unwrap();
    note(&open(dir.path()), 1, "a", None);
    let ledger = Ledger::open_to_read(&dir.path().join(FILE)).unwrap().unwrap();
    let longest = std::time::Duration::from_secs(60);
    let (names, rows) = ledger.ask("SELECT id, outcome FROM items", 10, longest).unwrap();
    assert_eq!(names, ["id", "outcome"]);
    assert_eq!(rows, [[Value::Text("a".into()), Value::Text("accepted".into())]]);
    let error = ledger.ask("CREATE TABLE x (y)", 10, longest).unwrap_err().to_string();
    assert!(error.contains("only the ledger's own tables can be asked"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_photo_whose_name_is_no_text_is_a_bad_line_and_the_rest_goes_on() {
    use std::os::unix::ffi::OsStringExt as _;
    let ledger = Ledger::passing().unwrap();
    let plan = ledger.begin_plan(&Digest::of(b"names")).unwrap();
    let photo = std::ffi::OsString::from_vec(vec![b'p', 0xff]).into();
    let lines = [(1, Ok(Item { photo, ..item("odd", 0) })), (2, Ok(item("even", 0)))];
    ledger.take(plan, &lines).unwrap();
    assert_eq!(pending(&ledger, plan, 1, &[]), ["even"]);
    let bad = ledger.bad_lines(plan, 9).unwrap();
    assert!(bad.len() == 1 && bad[0].1.contains("cannot be written down"), "{bad:?}");
}

#[test]
fn a_damaged_question_is_told_and_its_item_not_passed_over() {
    let ledger = Ledger::passing().unwrap();
    let plan = planned(&ledger, &["a"]);
    let rot = "DROP TRIGGER planned_keep_UPDATE; UPDATE planned SET question = 'rot'";
    ledger.db().execute_batch(rot).unwrap();
    let settled = Settled { plan, settings: Some(&settings()), again: &[], run: 1 };
    let error = ledger.pending(&settled, 0, 9).unwrap_err();
    assert!(error.to_string().contains("`rot` is no digest"), "{error}");
}
