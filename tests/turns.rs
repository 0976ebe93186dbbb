//! One writer at a time: the second waits, says for whom, and goes on; whoever is killed leaves
//! nothing in the way.
#![cfg(unix)]

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::batch::Batch;
use crate::folders::tree;
use crate::kinfold::{Bench, CLOCK, Said, files, names, program};

/// Longest time for a test that would hang if two runs waited for each other.
const DEADLINE: Duration = Duration::from_secs(300);

fn make(bench: &Bench, state: &str, out: &str, more: &[&str]) -> Child {
    let mut command = program();
    command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path(state));
    command.args(["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "cabinet.json"]);
    command.args(["--out", out, "--clock", CLOCK]).args(more);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// What a run said at its end; a hang is a failure.
fn ended(mut child: Child) -> Said {
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > DEADLINE {
            child.kill().unwrap();
            panic!("it hangs: {:?}", child.wait_with_output());
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.wait_with_output().unwrap().into()
}

/// Waits until something is so.
fn until(what: &str, mut so: impl FnMut() -> bool) {
    let began = Instant::now();
    while !so() {
        assert!(began.elapsed() < DEADLINE, "never: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Many runs at once, each with its own state directory or all with one: every exit 0 has its files.
fn all_at_once(many: usize, state: impl Fn(usize) -> String, out: impl Fn(usize) -> String) {
    let bench = Bench::new();
    let expected = {
        let alone = Bench::done();
        alone.out()
    };
    let children: Vec<_> =
        (0..many).map(|n| make(&bench, &state(n), &out(n), &["--quiet"])).collect();
    for (n, said) in children.into_iter().map(ended).enumerate() {
        assert_eq!(said.code, Some(0), "{many} at once: {said:?}");
        assert!(said.err.is_empty(), "it was to be quiet: {}", said.err);
        assert!(files(&bench.path(&out(n))) == expected, "{many} at once: not the whole asset");
    }
    let left = tree(&bench.path(""));
    let beside = |name: &&String| name.contains(".lock") || name.contains(".failed");
    assert_eq!(left.keys().filter(beside).count(), 0, "{:?}", left.keys());
}

#[test]
fn two_makes_in_one_output_folder_with_two_states_both_leave_whole_results() {
    for many in [2, 4] {
        all_at_once(many, |n| format!("state-{n}"), |_| "out".into());
    }
}

#[test]
fn two_four_and_eight_makes_in_one_output_folder_and_one_state_all_leave_it_whole() {
    for many in [2, 4, 8] {
        all_at_once(many, |_| "state".into(), |_| "out".into());
    }
}

#[test]
fn makes_that_share_folders_crosswise_never_wait_for_each_other() {
    all_at_once(8, |n| format!("state-{}", n % 2), |n| format!("out-{}", n / 2 % 2));
}

#[test]
fn batches_in_one_folder_take_turns() {
    let batch = Batch::of(2);
    let children: Vec<_> = (0..3).map(|_| batch.batch(&[]).spawn().unwrap()).collect();
    for said in children.into_iter().map(ended) {
        assert_eq!((said.code, said.out.as_str()), (Some(0), "accepted   2\n"), "{said:?}");
    }
    assert_eq!(batch.repeated(), 0);
    let audit = batch.say(&["audit", "out"]);
    assert_eq!(audit.code, Some(0), "{audit:?}");
}

#[test]
fn a_run_that_waits_says_for_whom_and_goes_on_when_the_first_is_done() {
    let bench = Bench::done();
    let turns = runner::ours::Turns::AT_ONCE;
    let held = workflow::output::OutFolder::open(&bench.path("out"), turns).unwrap();
    let whom = format!("out is in use: waiting for process {} on ", std::process::id());
    let refused = bench.made(&["--no-wait"]);
    assert_eq!(refused.code, Some(1), "{refused:?}");
    assert!(refused.err.contains("hint: without --no-wait this one waits"), "{refused:?}");
    let mut waiting = bench.make(&[]).spawn().unwrap();
    let mut heard = String::new();
    let mut err = std::io::BufReader::new(waiting.stderr.take().unwrap());
    std::io::BufRead::read_line(&mut err, &mut heard).unwrap();
    assert!(heard.starts_with(&whom) && heard.contains(", at work since 2"), "{heard}");
    assert!(waiting.try_wait().unwrap().is_none(), "it waits");
    drop(held);
    assert_eq!(ended(waiting).code, Some(0));
    assert!(!bench.path(".out.lock").exists());
}

/// Whether this process was started without an ear for Ctrl-C, as shells start what runs behind them;
/// programs inherit that.
fn interrupts_are_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|m| m & 2 != 0)
}

#[test]
fn a_waiter_that_is_killed_or_interrupted_ends_at_once_and_leaves_nothing() {
    let bench = Bench::done();
    let turns = runner::ours::Turns::AT_ONCE;
    let held = workflow::output::OutFolder::open(&bench.path("out"), turns).unwrap();
    let state = runner::StateDir::open(&bench.path("state")).unwrap();
    let before = tree(&bench.path(""));
    for (signal, args) in [
        ("-INT", &["--out", "out"][..]),
        ("-TERM", &["--out", "out"][..]),
        ("-KILL", &["--out", "out"][..]),
        ("-INT", &["--out", "other"][..]),
    ] {
        if signal == "-INT" && interrupts_are_ignored() {
            eprintln!("SKIPPED: whoever started the tests ignores Ctrl-C, and so do its programs");
            continue;
        }
        let mut command = program();
        command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
        command.args(["make", "photo.png", "--mesh", "cabinet.glb"]).args(args);
        command.args(["--condition", "cabinet.json", "--clock", CLOCK]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut heard = String::new();
        let mut err = std::io::BufReader::new(child.stderr.take().unwrap());
        std::io::BufRead::read_line(&mut err, &mut heard).unwrap();
        assert!(heard.contains("waiting for process"), "{heard}");
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        let said = ended(child);
        assert_ne!(said.code, Some(0), "{signal}: {said:?}");
        let mut after = tree(&bench.path(""));
        // One that was killed while it held the one lock and waited for the other leaves the file of the
        // lock; the lock is free.
        after.remove(".other.lock");
        assert!(after == before, "{signal} left {:?}", after.keys());
    }
    drop((held, state));
    assert_eq!(ended(make(&bench, "state", "other", &["--no-wait"])).code, Some(0));
    assert_eq!(bench.made(&["--no-wait"]).code, Some(0));
    assert!(names(&bench.out()).contains(&"asset.urdf"));
    assert!(!bench.path(".other.lock").exists() && !bench.path(".out.lock").exists());
}

#[test]
fn a_holder_that_is_killed_frees_its_lock_for_whoever_waits() {
    let bench = Bench::new();
    let mut first = make(&bench, "one", "out", &[]);
    until("the first is at work", || bench.path("out.failed/1/trace.mcap").exists());
    let second = make(&bench, "two", "out", &[]);
    std::thread::sleep(Duration::from_millis(100));
    // It may have ended by itself.
    let _ = first.kill();
    first.wait().unwrap();
    let said = ended(second);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(bench.out() == Bench::done().out());
}

#[test]
fn what_tidies_up_a_store_takes_its_turn() {
    let bench = Bench::done();
    let state = runner::StateDir::open(&bench.path("state")).unwrap();
    let gc = |more: &[&str]| {
        let mut command = program();
        command.args(["store", "gc"]).arg(bench.path("state")).args(more);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let refused = ended(gc(&["--no-wait"]));
    assert_eq!(refused.code, Some(1), "{refused:?}");
    let looked = ended(gc(&["--dry-run", "--no-wait"]));
    assert_eq!(looked.code, Some(0), "who only looks waits for nobody: {looked:?}");
    let waiting = gc(&[]);
    std::thread::sleep(Duration::from_millis(100));
    drop(state);
    assert_eq!(ended(waiting).code, Some(0));
}
