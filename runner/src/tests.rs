//! What the runner promises, on the toy flow.

use std::sync::Arc;
use std::sync::atomic::AtomicU32;
use std::time::Duration;

use super::failure::{Again, Blame, StageError};
use super::observe::Quiet;
use super::outcome::{Ending, Outcome};
use super::plan::{Reason, plan};
use super::state_dir::StateDir;
use super::toy::{Toys, asking, flow, flow_of, play, sighing};

fn last(outcome: &Outcome) -> String {
    let (_, bytes) = outcome.nodes.last().unwrap().output.clone().unwrap();
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn stages(text: &str, toys: &Toys, state: &std::path::Path) -> Vec<(&'static str, Vec<Reason>)> {
    let state = StateDir::open_to_read(state).unwrap();
    let planned = plan(&flow_of(text, toys.code), toys, state.as_ref()).unwrap();
    planned.into_iter().map(|p| (p.stage, p.reasons)).collect()
}

#[test]
fn the_second_run_recalls_everything_and_gives_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let (first, toys) = play("abc", Toys::default(), dir.path(), &mut Quiet);
    assert_eq!(last(&first), "ABCcba");
    assert_eq!([toys.times("upper"), toys.times("reverse"), toys.times("join")], [1, 1, 1]);
    let (second, toys) = play("abc", Toys::default(), dir.path(), &mut Quiet);
    assert!(matches!(second.ending, Ending::Done));
    assert_eq!(last(&second), "ABCcba");
    assert_eq!([toys.times("upper"), toys.times("reverse"), toys.times("join")], [0, 0, 0]);
    assert!(second.nodes.iter().all(|n| n.recalled));
}

#[test]
fn only_what_depends_on_a_change_runs_again() {
    let dir = tempfile::tempdir().unwrap();
    play("abc", Toys::default(), dir.path(), &mut Quiet);
    let glue = || Toys { glue: "-".into(), ..Toys::default() };
    let changed = Reason::IdentityChanged { was: "glue ".into(), is: "glue -".into() };
    let expected = vec![("upper", vec![]), ("reverse", vec![]), ("join", vec![changed])];
    assert_eq!(stages("abc", &glue(), dir.path()), expected);
    let (outcome, toys) = play("abc", glue(), dir.path(), &mut Quiet);
    assert_eq!(
        (last(&outcome).as_str(), toys.times("upper"), toys.times("join")),
        ("ABC-cba", 0, 1)
    );
}

#[test]
fn a_stage_that_makes_the_same_again_stops_the_change_there() {
    let dir = tempfile::tempdir().unwrap();
    play("abc", Toys::default(), dir.path(), &mut Quiet);
    let newer = || Toys { code: 2, ..Toys::default() };
    let planned = stages("abc", &newer(), dir.path());
    assert_eq!(planned[0], ("upper", vec![Reason::CodeChanged]));
    assert_eq!(planned[2].1, [Reason::InputPending("text".into(), "upper")]);
    let (_, toys) = play("abc", newer(), dir.path(), &mut Quiet);
    assert_eq!([toys.times("upper"), toys.times("join")], [1, 0]);
}

#[test]
fn a_plan_without_a_record_runs_everything() {
    let dir = tempfile::tempdir().unwrap();
    let state = dir.path().join("none");
    let planned = stages("abc", &Toys::default(), &state);
    assert!(planned.iter().all(|(_, reasons)| reasons.contains(&Reason::NoRecord)));
    play("other text", Toys::default(), &state, &mut Quiet);
    let planned = stages("abc", &Toys::default(), &state);
    assert_eq!(planned[0], ("upper", vec![Reason::NoRecord]), "another text's record is no record");
}

#[test]
fn a_damaged_blob_is_made_again() {
    let dir = tempfile::tempdir().unwrap();
    let (first, _) = play("abc", Toys::default(), dir.path(), &mut Quiet);
    let upper = first.nodes[1].output.clone().unwrap().0;
    let path = StateDir::open(dir.path()).unwrap().store.path(&upper);
    std::fs::write(&path, "AB").unwrap();
    let reasons = &stages("abc", &Toys::default(), dir.path())[0].1;
    assert_eq!(reasons[0].to_string(), "its bytes in the store are damaged");
    let (second, toys) = play("abc", Toys::default(), dir.path(), &mut Quiet);
    assert_eq!((last(&second).as_str(), toys.times("upper"), toys.times("join")), ("ABCcba", 1, 0));
    assert_eq!(std::fs::read(path).unwrap(), b"ABC");
}

fn failing(message: &str, times: u32, again: bool) -> Toys {
    let failure = StageError::new(message);
    let failure = if again { failure.later(None) } else { failure };
    Toys { failure: Some(failure), failures: AtomicU32::new(times), ..Toys::default() }
}

#[test]
fn a_passing_trouble_is_tried_again_and_a_lasting_one_is_not() {
    let dir = tempfile::tempdir().unwrap();
    let (outcome, toys) = play("a", failing("busy", 2, true), dir.path(), &mut Quiet);
    assert!(matches!(outcome.ending, Ending::Done));
    assert_eq!(toys.times("join"), 3);
    let (outcome, toys) = play("b", failing("busy", 9, true), dir.path(), &mut Quiet);
    assert!(matches!(outcome.ending, Ending::Failed { stage: "join", .. }));
    assert_eq!(toys.times("join"), 3, "attempts are bounded");
    let (outcome, toys) = play("c", failing("wrong", 9, false), dir.path(), &mut Quiet);
    let Ending::Failed { error, .. } = outcome.ending else { panic!("it should have failed") };
    assert_eq!((error.line().as_str(), toys.times("join")), ("wrong", 1));
}

#[test]
fn after_a_failure_only_the_failed_stage_runs_again() {
    let dir = tempfile::tempdir().unwrap();
    play("abc", failing("wrong", 9, false), dir.path(), &mut Quiet);
    let (outcome, toys) = play("abc", Toys::default(), dir.path(), &mut Quiet);
    assert_eq!(
        (last(&outcome).as_str(), toys.times("upper"), toys.times("join")),
        ("ABCcba", 0, 1)
    );
}

#[test]
fn a_panic_in_a_stage_is_that_stages_failure() {
    let dir = tempfile::tempdir().unwrap();
    let (outcome, _) = play("abc", failing("panic", 9, false), dir.path(), &mut Quiet);
    let Ending::Failed { error, .. } = outcome.ending else { panic!("it should have failed") };
    assert!(error.line().contains("a toy broke"), "{}", error.line());
}

#[test]
fn a_stage_that_takes_too_long_is_given_up() {
    let dir = tempfile::tempdir().unwrap();
    let slow = Toys { nap: Duration::from_secs(5), ..Toys::default() };
    let (outcome, toys) = play("abc", slow, dir.path(), &mut Quiet);
    let Ending::Failed { error, .. } = outcome.ending else { panic!("it should have failed") };
    assert_eq!(error.line(), "took longer than 2 s and was given up");
    assert_eq!(toys.times("join"), 1);
}

/// What it asked last is still under way, and asking once more beside it could be paid for twice.
#[test]
fn a_service_that_takes_too_long_is_not_asked_once_more_beside_the_first_time() {
    let dir = tempfile::tempdir().unwrap();
    let state = StateDir::open(dir.path()).unwrap();
    let slow = Arc::new(Toys { nap: Duration::from_secs(2), ..Toys::default() });
    let options = super::toy::options(super::cancel::Cancel::default());
    let ran = super::run::run(&asking("a"), &slow, &state, &options, &mut Quiet).unwrap();
    let Ending::Failed { error, .. } = ran.ending else { panic!("it should have failed") };
    assert_eq!((error.again, slow.times("ask")), (Again::Never, 1));
    assert!(error.hint.unwrap().contains("may have been charged"));
}

#[test]
fn a_first_ctrl_c_lets_the_running_stage_finish_and_be_recorded() {
    let dir = tempfile::tempdir().unwrap();
    let cancel = super::cancel::Cancel::default();
    let nap = Duration::from_millis(100);
    let pressed = Toys { cancel: Some(cancel.clone()), nap, ..Toys::default() };
    let (outcome, _) = play("abc", pressed, dir.path(), &mut Quiet);
    assert!(matches!(outcome.ending, Ending::Done), "join was the last stage");
    let (_, toys) = play("abc", Toys::default(), dir.path(), &mut Quiet);
    assert_eq!(toys.times("join"), 0);
    let (outcome, toys) =
        play("other", Toys { cancel: Some(cancel), ..Toys::default() }, dir.path(), &mut Quiet);
    assert!(matches!(outcome.ending, Ending::Interrupted(_)));
    assert_eq!(toys.times("upper"), 0, "nothing new begins after the wish to stop");
}

#[test]
fn of_runs_that_make_the_same_at_once_one_does_the_work() {
    let dir = tempfile::tempdir().unwrap();
    let state = StateDir::open(dir.path()).unwrap();
    let toys = Arc::new(Toys { nap: Duration::from_millis(100), ..Toys::default() });
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let options = super::toy::options(super::cancel::Cancel::default());
                let ran = super::run::run(&flow("abc"), &toys, &state, &options, &mut Quiet);
                assert_eq!(last(&ran.unwrap()), "ABCcba");
            });
        }
    });
    assert_eq!([toys.times("upper"), toys.times("reverse"), toys.times("join")], [1, 1, 1]);
}

#[test]
fn a_run_that_fails_leaves_the_work_to_the_next() {
    let dir = tempfile::tempdir().unwrap();
    let state = StateDir::open(dir.path()).unwrap();
    let options = || super::toy::options(super::cancel::Cancel::default());
    let broken = Arc::new(failing("wrong", 9, false));
    super::run::run(&flow("abc"), &broken, &state, &options(), &mut Quiet).unwrap();
    let toys = Arc::new(Toys::default());
    let ran = super::run::run(&flow("abc"), &toys, &state, &options(), &mut Quiet).unwrap();
    assert_eq!((last(&ran).as_str(), toys.times("join")), ("ABCcba", 1));
}

#[test]
fn a_run_goes_on_without_what_it_can_do_without_and_the_next_one_tries_again() {
    let dir = tempfile::tempdir().unwrap();
    let state = StateDir::open(dir.path()).unwrap();
    let sigh = |failure: Option<StageError>| {
        let toys = Arc::new(Toys { failure, ..Toys::default() });
        let options = super::toy::options(super::cancel::Cancel::default());
        let ran = super::run::run(&sighing("a"), &toys, &state, &options, &mut Quiet).unwrap();
        (ran, toys.times("sigh"))
    };
    for _ in 0..2 {
        let (ran, times) = sigh(Some(StageError::new("no breath")));
        assert!(matches!(ran.ending, Ending::Done));
        assert_eq!((last(&ran).as_str(), times), ("NO SIGH: NO BREATH", 1), "nothing was kept");
    }
    let full = StageError::new("the disk is full").blamed_on(Blame::House);
    let (ran, _) = sigh(Some(full));
    assert!(matches!(ran.ending, Ending::Failed { stage: "sigh", .. }), "the house is no sigh");
    let (ran, times) = sigh(None);
    assert_eq!((last(&ran).as_str(), times), ("A!", 1));
    assert_eq!(sigh(None).1, 0, "what was made is kept");
}

#[test]
fn the_graph_of_a_flow_knows_its_own_name() {
    assert_eq!(flow("x").name(), "toy");
}
