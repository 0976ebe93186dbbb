//! Money is written down before it is spent: what may be charged is booked before it is sent, what was
//! answered is never asked again, and what stands in book and ledger cannot be changed unseen.
#![cfg(unix)]

use std::time::Duration;

use adapters::budget::Fate;
use serde_json::json;

use crate::paid::{Mood, Paid, Shop, kill_at};

fn shop(more: &str) -> Shop {
    Shop::open(Paid::open(Duration::ZERO), false, more)
}

/// The fault as it was reported: a service hangs up, the budget is one call.
#[test]
fn a_budget_of_one_call_sees_a_call_whose_answer_was_lost() {
    let lost = [Mood::HangsUp, Mood::Says(500), Mood::Says(502), Mood::Says(503), Mood::Tears];
    for mood in lost {
        let shop = shop("[budget]\ncalls = 1\n");
        shop.paid.will("kinematics", &[mood; 9]);
        let said = shop.made();
        assert_eq!(said.code, Some(1), "{mood:?}: {said:?}");
        assert!(said.err.contains("it may have been charged"), "{mood:?}: {}", said.err);
        assert!(said.err.contains("hint: look at the service's own list"), "{}", said.err);
        assert_eq!(shop.paid.counts(), [1, 0, 0], "{mood:?}: asked once");
        assert_eq!(shop.book()[0].fate, Fate::Lost);
        let said = shop.made();
        assert_eq!(said.code, Some(1), "{said:?}");
        assert!(said.err.contains("the budget of 1 calls is used up"), "{}", said.err);
        assert_eq!(shop.paid.counts(), [1, 0, 0], "{mood:?}: nothing more is sent");
        assert_eq!(shop.paid.unbooked(), 0);
    }
}

#[test]
fn after_a_loss_the_same_command_asks_that_once_more_and_books_it_again() {
    let shop = shop("");
    shop.paid.will("points", &[Mood::HangsUp]);
    assert_eq!(shop.made().code, Some(1));
    assert_eq!(shop.paid.counts(), [1, 1, 0]);
    let said = shop.made();
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(shop.paid.counts(), [1, 2, 1], "what was answered is not asked again");
    let fates: Vec<_> = shop.book().iter().map(|e| e.fate).collect();
    assert_eq!(fates, [Fate::Answered, Fate::Lost, Fate::Answered, Fate::Answered]);
    let trace = shop.path("out/trace.mcap").display().to_string();
    let replayed = shop.kinfold(&["trace", "replay", &trace]).output().unwrap();
    assert_eq!(replayed.status.code(), Some(0), "{replayed:?}");
}

#[test]
fn a_repair_whose_answer_was_lost_is_not_repeated_and_goes_on_from_there() {
    let shop = shop("");
    shop.paid.will("points", &[Mood::Errs, Mood::HangsUp]);
    let said = shop.made();
    assert!(said.err.contains("vlm.points/1") && said.err.contains("may have been charged"));
    assert_eq!(shop.paid.counts(), [1, 2, 0]);
    assert_eq!(shop.made().code, Some(0));
    assert_eq!(shop.paid.counts(), [1, 3, 1], "the first answer and its faults are on record");
}

#[test]
fn a_busy_service_is_asked_again_for_that_was_no_work() {
    let shop = shop("");
    shop.paid.will("physical", &[Mood::Says(429)]);
    let said = shop.made();
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(shop.paid.counts(), [1, 1, 2]);
    assert_eq!(shop.book().iter().filter(|e| e.fate == Fate::Refused).count(), 1);
}

#[test]
fn answers_that_stay_wrong_are_asked_for_anew_and_the_right_ones_kept() {
    let shop = shop("");
    shop.paid.will("physical", &[Mood::Errs; 3]);
    let said = shop.made();
    assert!(said.err.contains("still wrong after 2 rounds of repair"), "{said:?}");
    assert_eq!(shop.paid.counts(), [1, 1, 3]);
    assert_eq!(shop.made().code, Some(0));
    assert_eq!(shop.paid.counts(), [1, 1, 4]);
}

#[test]
fn a_job_whose_submit_was_lost_is_asked_for_once_and_counts() {
    let shop = Shop::open(Paid::open(Duration::ZERO), true, "[budget]\ncalls = 4\n");
    shop.paid.will("submit", &[Mood::HangsUp]);
    let said = shop.made();
    assert!(said.err.contains("it may have been charged"), "{said:?}");
    for _ in 0..2 {
        let said = shop.made();
        assert!(said.err.contains("may have been charged"), "{said:?}");
    }
    assert_eq!((shop.paid.count("submit"), shop.book().len()), (1, 1));
    let said = shop.make(&["--seed", "2"]).output().unwrap();
    assert_eq!(
        said.status.code(),
        Some(1),
        "the budget of four holds one loss, one job, two questions"
    );
    assert_eq!((shop.paid.count("submit"), shop.paid.counts()), (2, [1, 1, 0]));
}

/// The fault as it was reported: a kill while the third question is under way.
#[test]
fn a_kill_between_questions_asks_none_of_the_answered_ones_again() {
    let undisturbed = Shop::open(Paid::open(Duration::ZERO), true, "");
    assert_eq!(undisturbed.made().code, Some(0));
    let shop = Shop::open(Paid::open(Duration::from_millis(300)), true, "");
    for times in 1..=3 {
        shop.killed_at("physical", times);
    }
    let said = shop.made();
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!((shop.paid.count("submit"), shop.paid.counts()), (1, [1, 1, 4]));
    assert_eq!((shop.paid.unbooked(), shop.book().len()), (0, 7), "killed tries are booked");
    let (mut ours, mut theirs) = (shop.out(), undisturbed.out());
    // The trace names its provider's address, and that has another port.
    assert!(ours.remove("trace.mcap").is_some() && theirs.remove("trace.mcap").is_some());
    assert!(ours == theirs, "the bytes of an unkilled run");
}

#[test]
fn a_killed_batch_asks_for_no_answer_twice_and_counts_requests() {
    let shop = Shop::open(Paid::open(Duration::from_millis(300)), false, "");
    shop.with_items(1);
    for times in 1..=2 {
        kill_at(shop.batch(&["--max-calls", "5"]), &shop.paid, "physical", times);
    }
    let (said, answer) = shop.ran(&["--max-calls", "5"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(shop.paid.counts(), [1, 1, 3]);
    assert_eq!(answer["calls"], 5, "killed tries of unanswered ones count, and the rest is used");
    assert_eq!(shop.paid.unbooked(), 0);
    let audit = shop.kinfold(&["audit", "assets"]).output().unwrap();
    assert_eq!(audit.status.code(), Some(0), "{audit:?}");
}

#[test]
fn a_batch_stops_at_the_request_that_is_one_too_many() {
    let shop = shop("");
    shop.with_items(2);
    let (said, answer) = shop.ran(&["--max-calls", "4", "--condition-calls", "1", "--jobs", "1"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert_eq!(shop.paid.work().len(), 4);
    assert_eq!((&answer["accepted"], &answer["left"]), (&json!(1), &json!(1)));
    assert_eq!(answer["this_run"]["classes"], json!({ "budget": 1 }));
    let (said, answer) = shop.ran(&["--max-calls", "6"]);
    assert_eq!((said.code, &answer["calls"]), (Some(0), &json!(6)), "{said:?}");
    assert_eq!(shop.paid.counts(), [2, 2, 2], "nothing was asked twice");
}

#[test]
fn a_budget_in_the_configuration_stops_a_batch_like_its_own() {
    let shop = shop("[budget]\ncalls = 3\n");
    shop.with_items(2);
    let (said, answer) = shop.ran(&["--condition-calls", "1", "--jobs", "1"]);
    assert_eq!((said.code, &answer["accepted"]), (Some(3), &json!(1)), "{said:?}");
    assert_eq!(answer["this_run"]["classes"], json!({ "budget": 1 }), "and the item is not lost");
    assert_eq!(shop.paid.work().len(), 3);
}

#[test]
fn a_batch_does_not_repeat_an_item_whose_answer_was_lost_until_it_is_told_to() {
    let shop = shop("");
    shop.with_items(2);
    shop.paid.will("kinematics", &[Mood::HangsUp]);
    let (said, answer) = shop.ran(&["--condition-calls", "1", "--jobs", "1"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert_eq!(answer["this_run"]["classes"], json!({ "provider": 1 }));
    assert_eq!(shop.paid.counts(), [2, 1, 1]);
    shop.ran(&[]);
    assert_eq!(shop.paid.counts(), [2, 1, 1], "the same command does not ask either");
    let (said, answer) = shop.ran(&["--retry", "provider"]);
    assert_eq!((said.code, &answer["calls"]), (Some(0), &json!(7)), "{said:?}");
    assert_eq!(shop.paid.counts(), [3, 2, 2]);
}

#[test]
fn a_damaged_answer_on_record_is_told_and_neither_used_nor_paid_for_again() {
    let shop = shop("");
    shop.paid.will("physical", &[Mood::HangsUp]);
    shop.made();
    let bodies = shop.path("state/calls/bodies");
    let longest = std::fs::read_dir(&bodies).unwrap().map(|e| e.unwrap().path());
    let answer = longest
        .filter(|p| std::fs::read_to_string(p).is_ok_and(|t| t.contains("completion_tokens")));
    for path in answer {
        std::fs::write(path, "{}").unwrap();
    }
    let said = shop.made();
    assert_eq!(said.code, Some(1));
    assert!(said.err.contains("expected a call written down by kinfold"), "{}", said.err);
    assert_eq!(shop.paid.counts(), [1, 1, 1]);
}

#[test]
fn a_book_that_was_changed_lets_nothing_pass() {
    let shop = shop("");
    shop.paid.will("points", &[Mood::HangsUp]);
    shop.made();
    let path = shop.path("state/spent.jsonl");
    let text = std::fs::read_to_string(&path).unwrap();
    let first = text.split_inclusive('\n').next().unwrap();
    for changed in [first.to_owned(), String::new(), text.replacen("kinematics", "mathematics", 1)]
    {
        std::fs::write(&path, changed).unwrap();
        let said = shop.made();
        assert_eq!(said.code, Some(1));
        assert!(said.err.contains("an account book as kinfold wrote it"), "{}", said.err);
    }
    assert_eq!(shop.paid.counts(), [1, 1, 0]);
}

/// The fault as it was reported: requests, runs and plans changed in a ledger without triggers.
#[test]
fn an_audit_finds_changes_of_calls_runs_and_plans() {
    let shop = shop("");
    shop.with_items(2);
    let one_by_one = ["--condition-calls", "1", "--jobs", "1"];
    assert_eq!(shop.ran(&one_by_one).0.code, Some(0));
    shop.ran(&["--seed", "5"]);
    let ledger = shop.path("assets/ledger.sqlite");
    let kept = std::fs::read(&ledger).unwrap();
    let audit =
        || -> crate::kinfold::Said { shop.kinfold(&["audit", "assets"]).output().unwrap().into() };
    assert_eq!(audit().code, Some(0), "{:?}", audit());
    let forgeries = [
        ("DELETE FROM calls", "calls: "),
        (
            "DELETE FROM calls; UPDATE heads SET rows = 0, digest = (SELECT previous FROM runs WHERE run = 1) WHERE name = 'calls'",
            "calls: the outcome of `k000` names 3, 0 are there",
        ),
        (
            "DELETE FROM calls WHERE n = (SELECT max(n) FROM calls)",
            "calls: 1 rows are missing at its end",
        ),
        ("DELETE FROM calls WHERE n = 2", "calls: row 2"),
        ("UPDATE calls SET cost = 9 WHERE n = 1", "calls: row 1 (`k00"),
        (
            "UPDATE calls SET n = 1000 WHERE n = 1; UPDATE calls SET n = 1 WHERE n = 2; UPDATE calls SET n = 2 WHERE n = 1000",
            "calls: row 1",
        ),
        ("UPDATE runs SET words = '{}' WHERE run = 1", "runs: row 1 was edited"),
        ("DELETE FROM runs WHERE run = 2", "runs: 1 rows are missing at its end"),
        (
            "UPDATE planned SET spec = replace(spec, '0.png', '1.png')",
            "planned: row 1 (`k000`) was edited",
        ),
        ("DELETE FROM planned WHERE id = 'k001'", "planned: 1 rows are missing at its end"),
        ("UPDATE plans SET manifest = 'another'", "plans: row 1 was edited"),
        ("DELETE FROM heads", "nothing says where its chain ends"),
        (
            "DELETE FROM outcomes WHERE n = (SELECT max(n) FROM outcomes)",
            "rows are missing at its end",
        ),
    ];
    for (sql, found) in forgeries {
        let db = rusqlite::Connection::open(&ledger).unwrap();
        db.execute_batch("PRAGMA journal_mode = DELETE;").unwrap();
        let triggers = "SELECT name FROM sqlite_schema WHERE type = 'trigger'";
        let names: Vec<String> = {
            let mut query = db.prepare(triggers).unwrap();
            let rows = query.query_map([], |r| r.get(0)).unwrap();
            rows.collect::<Result<_, _>>().unwrap()
        };
        names.iter().for_each(|n| db.execute_batch(&format!("DROP TRIGGER {n}")).unwrap());
        db.execute_batch(sql).unwrap();
        drop(db);
        let said = audit();
        assert_eq!(said.code, Some(1), "{sql}: {said:?}");
        assert!(said.err.contains(found), "{sql}: {found} is not in {}", said.err);
        std::fs::write(&ledger, &kept).unwrap();
    }
    let db = rusqlite::Connection::open(&ledger).unwrap();
    let refused = db.execute("DELETE FROM calls", []).unwrap_err().to_string();
    assert!(refused.contains("the ledger is only added to"), "{refused}");
    let book = shop.path("assets/state/spent.jsonl");
    let text = std::fs::read_to_string(&book).unwrap();
    std::fs::write(&book, text.split_inclusive('\n').skip(1).collect::<String>()).unwrap();
    let said = audit();
    assert!(said.code == Some(1) && said.err.contains("spent.jsonl"), "{said:?}");
}

#[test]
fn a_batch_whose_requests_were_taken_away_keeps_no_budget() {
    let shop = shop("");
    shop.with_items(1);
    shop.ran(&[]);
    let db = rusqlite::Connection::open(shop.path("assets/ledger.sqlite")).unwrap();
    db.execute_batch("DROP TRIGGER calls_keep_DELETE; DELETE FROM calls WHERE n > 2").unwrap();
    drop(db);
    let said: crate::kinfold::Said = shop.batch(&["--max-calls", "9"]).output().unwrap().into();
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("what was spent is not known: calls: "), "{}", said.err);
}
